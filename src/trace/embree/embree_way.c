/* Which of Embree's kernels answers a block.
 *
 * The kernels for coherent packets follow all rays of a packet at once: half of single rays' time where rays
 * run alike, up to half more than it where they do not. The others take a packet apart as soon as its rays
 * part, and go ray by ray, about as fast as single rays. Time over that of single rays by packets of 16,
 * mirrored and refracted rays of meshes of 0.36 and 2 million triangles, by the sum of the ranges of
 * direction's coordinates in the block:
 *
 *     closest hits                         up to 0.25      0.25 to 1       1 to 2          more
 *     first mirrored: coherent, others     0.46, 0.96      0.5-0.7, 0.98   0.8-0.9, 1.0    1.05, 0.97
 *     first refracted                      0.9-1.0, 0.97   1.1-1.2, 0.96
 *     later                                                0.95-1.3, 1.0   1.2-1.5, 1.0    1.4-1.5, 0.98
 *
 * So the coherent kernels want directions that differ little, and origins that are neighbours: which the
 * caller knows. Through instances they gain nothing, 1.0 to 1.1 of the others' time even for rays that run
 * alike; nor do they from shadow rays that leave secondary hits, 1.1 to 1.7 of it.
 *
 * Packets of 8 save a twentieth of the others' time, and bringing blocks into them costs as much
 * (bench/README.md).
 *
 * The choice depends on the rays alone, and no answer on the choice: embree_settle.c. */
#include "trace/embree/embree.h"

/* A way that was asked for by name is kept. */
static bool named(const embree_tracer *tracer) { return tracer->spec.calls != TRACE_CALLS_AUTO; }

static bool run_alike(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                      trace_coherence coherence) {
    embree_spread spread = tracer->kernels->spread(rays, lanes);
    return spread == EMBREE_SPREAD_ALIKE ||
           (spread == EMBREE_SPREAD_SIMILAR && coherence == TRACE_NEIGHBOURS);
}

embree_way embree_way_closest(const embree_tracer *tracer, const trace_rays *rays, unsigned lanes,
                              trace_coherence coherence) {
    bool told = coherence == TRACE_COHERENT;
    if (told || named(tracer) || tracer->base.world->instances.count)
        return (embree_way){tracer->width, told};
    return (embree_way){tracer->width, run_alike(tracer, rays, lanes, coherence)};
}

embree_way embree_way_any(const embree_tracer *tracer, trace_coherence coherence) {
    bool told = coherence == TRACE_COHERENT;
    return (embree_way){told && tracer->width > 8 && embree_may_hang(tracer) ? 8 : tracer->width, told};
}
