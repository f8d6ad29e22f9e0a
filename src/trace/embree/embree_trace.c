/* Passes blocks of rays to Embree and gets the hits: whole blocks if a call takes 16 rays, else packets. */
#include "base/kernel.h"
#include "trace/embree/embree.h"
#include "trace/stretch.h"

#include <math.h>

KERNEL_BEST(embree_kernels)

/* ---- closest hit ---- */

void embree_closest_packets(const embree_tracer *tracer, trace_block *block, const int *valid, unsigned lanes,
                            const embree_way *way, embree_context *context, RTCFilterFunctionN filter) {
    const unsigned width = way->width;
    if (width == LANES) {
        embree_intersect(width, valid, tracer->scenes[0], context, way->coherent, filter, block);
        return;
    }
    embree_packets packets;
    tracer->kernels->split(&block->rays, &block->hits, width, &packets);
    for (unsigned first = 0; first < lanes; first += width) {
        if (width == 1 && !valid[first]) continue;
        embree_intersect(width, &valid[first], tracer->scenes[0], context, way->coherent, filter,
                         embree_packet(&packets, first));
    }
    tracer->kernels->join(&packets, width, &block->rays, &block->hits);
}

/* Converts Embree's ids of hits to the world's. Without instances there is only one group, and the ids are
 * equal. */
static void translate(const embree_tracer *tracer, trace_hits *hits, unsigned lanes) {
    const world *w = tracer->base.world;
    for (unsigned i = 0; w->instances.count && i < lanes; ++i) {
        if (hits->geometry[i] != RTC_INVALID_GEOMETRY_ID)
            embree_world_ids(w, 0, &hits->instance[i], &hits->geometry[i]);
    }
    if (tracer->halved) tracer->kernels->join_halves(tracer->halved, hits, lanes);
}

static void settle(const embree_tracer *tracer, trace_block *block, unsigned lanes, const embree_call *call) {
    for (unsigned i = 0; i < lanes; ++i) {
        bool met = block->hits.geometry[i] != RTC_INVALID_GEOMETRY_ID;
        if (met && call->tied[i]) embree_settle(tracer, block, i, call->far[i]);
    }
}

/* False if directions must be scaled first. */
static bool closest_block(const embree_tracer *tracer, trace_block *block, unsigned lanes, bool scaled,
                          trace_coherence coherence) {
    embree_asked asked;
    embree_call call;
    if (!tracer->kernels->begin_closest(tracer, block, lanes, scaled, &asked, &call)) return false;
    embree_context_init(&call.context);
    call.vote = NULL;
    call.raw = !tracer->filter;
    const embree_way way = embree_way_closest(tracer, &block->rays, lanes, coherence);
    embree_closest_packets(tracer, block, asked.valid, lanes, &way, &call.context, tracer->filter);
    bool tied = tracer->kernels->end_closest(block, lanes, &asked, &call);
    translate(tracer, &block->hits, lanes);
    if (tied) settle(tracer, block, lanes, &call);
    if (tracer->few) embree_spheres_closest(tracer, block, lanes, &asked);
    return true;
}

/* Traces a copy, because only t_far of the caller's rays may change. */
static __attribute__((noinline)) void closest_stretched(const embree_tracer *tracer, trace_block *block,
                                                        unsigned lanes, trace_coherence coherence) {
    trace_block scaled = *block;
    stretch s;
    stretch_rays(&scaled.rays, lanes, tracer->reach.direction, &s);
    closest_block(tracer, &scaled, lanes, true, coherence);
    block->hits = scaled.hits;
    for (unsigned i = 0; i < lanes; ++i) {
        if (block->hits.geometry[i] == RTC_INVALID_GEOMETRY_ID) continue;
        float t = scaled.rays.t_far[i];
        block->rays.t_far[i] = stretch_back(&s, i, t, block->rays.t_near[i], block->rays.t_far[i]);
    }
}

void embree_closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence) {
    (void)fine;
    for (size_t b = 0; b * LANES < count; ++b) {
        unsigned lanes = trace_lanes(count, b);
        if (!closest_block((const embree_tracer *)tracer, &blocks[b], lanes, false, coherence))
            closest_stretched((const embree_tracer *)tracer, &blocks[b], lanes, coherence);
    }
}

/* ---- any hit ---- */

static void any_packets(const embree_tracer *tracer, trace_rays *rays, const int *valid, unsigned lanes,
                        const embree_way *way, embree_context *context) {
    const unsigned width = way->width;
    embree_packets packets;
    tracer->kernels->split(rays, NULL, width, &packets);
    for (unsigned first = 0; first < lanes; first += width) {
        if (width == 1 && !valid[first]) continue;
        embree_occluded(width, &valid[first], tracer->scenes[0], context, way->coherent,
                        embree_packet(&packets, first));
    }
    tracer->kernels->join(&packets, width, rays, NULL);
    for (unsigned first = 0; tracer->passing && first < LANES; first += width)
        memcpy(&rays->flags[first], embree_packet(&packets, first) + EMBREE_ROW_FLAGS * width,
               width * sizeof *rays->flags);
}

bool embree_may_hang(const embree_tracer *tracer) {
    return EMBREE_COHERENT_16_MAY_HANG && tracer->base.world->instances.count;
}

static bool any_block(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, bool scaled,
                      trace_coherence coherence) {
    embree_asked asked;
    if (!tracer->kernels->begin_any(tracer, rays, lanes, scaled, &asked)) return false;
    embree_context context;
    embree_context_init(&context);
    const embree_way way = embree_way_any(tracer, rays, lanes, coherence);
    if (tracer->base.tells_opaque) memset(rays->flags, 0, sizeof rays->flags);
    if (way.width == LANES)
        embree_occluded(LANES, asked.valid, tracer->scenes[0], &context, way.coherent, rays);
    else
        any_packets(tracer, rays, asked.valid, lanes, &way, &context);
    tracer->kernels->end_any(rays, lanes, &asked);
    for (unsigned i = 0; tracer->passing && i < lanes; ++i)
        if (rays->flags[i] & TRACE_PASSED_SOME && rays->t_far[i] > 0) rays->t_far[i] = TRACE_NOT_OPAQUE;
    if (tracer->few) embree_spheres_any(tracer, rays, lanes, &asked);
    return true;
}

static __attribute__((noinline)) void any_stretched(const embree_tracer *tracer, trace_rays *rays,
                                                    unsigned lanes, trace_coherence coherence) {
    trace_rays scaled = *rays;
    stretch s;
    stretch_rays(&scaled, lanes, tracer->reach.direction, &s);
    any_block(tracer, &scaled, lanes, true, coherence);
    memcpy(rays->flags, scaled.flags, sizeof rays->flags);
    for (unsigned i = 0; i < lanes; ++i)
        if (scaled.t_far[i] < 0 && rays->t_far[i] > 0) rays->t_far[i] = scaled.t_far[i];
}

void embree_any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    for (size_t b = 0; b * LANES < count; ++b) {
        unsigned lanes = trace_lanes(count, b);
        if (!any_block((const embree_tracer *)tracer, &blocks[b], lanes, false, coherence))
            any_stretched((const embree_tracer *)tracer, &blocks[b], lanes, coherence);
    }
}
