/* Chooses Embree's kernels for a block.
 *
 * The kernels for coherent packets trace all rays of a packet together: in half of single rays' time if the
 * rays are similar, but up to half more time if they are not. The other kernels split a packet when its rays
 * diverge and go ray by ray, about as fast as single rays. The table gives the time of packets of 16 divided
 * by that of single rays, for reflected and refracted rays of meshes of 0.36 and 2 million triangles. The
 * columns are the sum of the ranges of the direction's coordinates in the block:
 *
 *     closest hits                         up to 0.25      0.25 to 1       1 to 2          more
 *     first mirrored: coherent, others     0.46, 0.96      0.5-0.7, 0.98   0.8-0.9, 1.0    1.05, 0.97
 *     first refracted                      0.9-1.0, 0.97   1.1-1.2, 0.96
 *     later                                                0.95-1.3, 1.0   1.2-1.5, 1.0    1.4-1.5, 0.98
 *
 * So the coherent kernels need similar directions and neighbouring origins; the caller knows about the
 * origins. They gain nothing through instances, 1.0 to 1.1 of the others' time even for similar rays, nor for
 * shadow rays from secondary hits, 1.1 to 1.7 of it.
 *
 * Packets of 8 save a twentieth of the others' time, and converting blocks to them costs as much
 * (bench/README.md).
 *
 * The choice depends only on the rays, and no hit depends on the choice: embree_settle.c. */
#include "trace/embree/embree.h"

/* The user chose the packet width. */
static bool named(const embree_tracer *tracer) { return tracer->spec.calls != TRACE_CALLS_AUTO; }

static bool run_alike(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                      trace_coherence coherence) {
    embree_spread spread = tracer->kernels->spread(rays, lanes);
    return spread == EMBREE_SPREAD_ALIKE ||
           (spread == EMBREE_SPREAD_SIMILAR && coherence == TRACE_NEIGHBOURS);
}

/* Rays in all directions that are told to be coherent, as `validate` asks them: through instances, Embree's
 * coherent kernels miss a surface for one in 2,000 of those along an axis to within 2^-40. */
static bool is_coherent(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                        trace_coherence coherence) {
    return coherence == TRACE_COHERENT && !(tracer->base.world->instances.count &&
                                            tracer->kernels->spread(rays, lanes) == EMBREE_SPREAD_WIDE);
}

embree_way embree_way_closest(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                              trace_coherence coherence) {
    const bool coherent = is_coherent(tracer, rays, lanes, coherence);
    if (coherent || named(tracer) || tracer->base.world->instances.count)
        return (embree_way){tracer->width, coherent};
    return (embree_way){tracer->width, run_alike(tracer, rays, lanes, coherence)};
}

embree_way embree_way_any(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                          trace_coherence coherence) {
    const bool coherent = is_coherent(tracer, rays, lanes, coherence);
    return (embree_way){coherent && tracer->width > 8 && embree_may_hang(tracer) ? 8 : tracer->width,
                        coherent};
}
