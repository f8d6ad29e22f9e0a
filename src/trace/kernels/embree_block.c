/* What is done to a block of rays around Embree's call. */
#include "base/kernel.h"
#include "trace/embree.h"
#include "trace/stretch.h"

#include <math.h>

#define ALWAYS_INLINE inline __attribute__((always_inline))

/* ---- before ---- */

/* Embree can abort on numbers that are not finite or too large for it, so such lanes never reach it, and meet
 * nothing. The far end of the interval is open, and Embree's is closed: t_far moves to the float below
 * (infinity and what is not positive stays). */
static ALWAYS_INLINE void prepare(const embree_tracer *tracer, trace_rays *restrict rays, unsigned lanes,
                                  uint32_t mask, int *restrict valid) {
    const float reach = tracer->reach, longest = tracer->longest; /* and no NaN is within them */
    for (unsigned i = lanes; i < TRACE_WIDTH; ++i) valid[i] = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        bool from = (fabsf(rays->org_x[i]) <= reach) & (fabsf(rays->org_y[i]) <= reach) &
                    (fabsf(rays->org_z[i]) <= reach);
        bool to = (fabsf(rays->dir_x[i]) <= longest) & (fabsf(rays->dir_y[i]) <= longest) &
                  (fabsf(rays->dir_z[i]) <= longest);
        valid[i] = from & to & (rays->t_near[i] < rays->t_far[i]) ? -1 : 0;
    }
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t bits;
        memcpy(&bits, &rays->t_far[i], sizeof bits);
        bits -= bits - 1 < 0x7f7fffffu;
        memcpy(&rays->t_far[i], &bits, sizeof bits);
    }
    for (unsigned i = 0; i < lanes; ++i) {
        rays->time[i] = 0, rays->mask[i] = mask, rays->id[i] = i, rays->flags[i] = 0;
    }
}

static void prepare_lanes(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, uint32_t mask,
                          int valid[TRACE_WIDTH]) {
    prepare(tracer, rays, lanes, mask, valid);
}

static ALWAYS_INLINE bool begin(const embree_tracer *tracer, trace_rays *restrict rays, unsigned lanes,
                                uint32_t mask, bool scaled, embree_asked *restrict asked) {
    if (!scaled && stretch_needed(rays, lanes)) return false;
    for (unsigned i = 0; i < lanes; ++i) asked->t_far[i] = rays->t_far[i];
    prepare(tracer, rays, lanes, mask, asked->valid);
    return true;
}

static ALWAYS_INLINE bool begin_closest_lanes(const embree_tracer *tracer, trace_block *restrict block,
                                              unsigned lanes, bool scaled, embree_asked *restrict asked,
                                              embree_call *restrict call) {
    if (!begin(tracer, &block->rays, lanes, EMBREE_SEEN, scaled, asked)) return false;
    for (unsigned i = 0; i < lanes; ++i) {
        block->hits.geometry[i] = block->hits.instance[i] = RTC_INVALID_GEOMETRY_ID;
        call->far[i] = block->rays.t_far[i];
    }
    for (unsigned i = 0; i < TRACE_WIDTH; ++i) call->best[i] = INFINITY, call->tied[i] = 0;
    return true;
}

/* Nearly all blocks are full, and loops of known length have no ends to look after. */
static bool begin_closest(const embree_tracer *tracer, trace_block *block, unsigned lanes, bool scaled,
                          embree_asked *asked, embree_call *call) {
    return lanes == TRACE_WIDTH ? begin_closest_lanes(tracer, block, TRACE_WIDTH, scaled, asked, call)
                                : begin_closest_lanes(tracer, block, lanes, scaled, asked, call);
}

static bool begin_any(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, bool scaled,
                      embree_asked *asked) {
    return lanes == TRACE_WIDTH ? begin(tracer, rays, TRACE_WIDTH, EMBREE_SHADOWS, scaled, asked)
                                : begin(tracer, rays, lanes, EMBREE_SHADOWS, scaled, asked);
}

/* ---- after ---- */

static ALWAYS_INLINE uint32_t end_closest_lanes(trace_block *restrict block, unsigned lanes,
                                                const embree_asked *restrict asked,
                                                const embree_call *restrict call) {
    uint32_t tied = 0, noted = call->raw ? 0 : ~0u;
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t missed = block->hits.geometry[i] == RTC_INVALID_GEOMETRY_ID ? ~0u : 0;
        float met = chosen(noted, call->best[i], block->rays.t_far[i]);
        block->rays.t_far[i] = chosen(missed, asked->t_far[i], met);
        tied |= (uint32_t)call->tied[i] & noted & ~missed;
    }
    return tied;
}

static bool end_closest(trace_block *block, unsigned lanes, const embree_asked *asked,
                        const embree_call *call) {
    return lanes == TRACE_WIDTH ? end_closest_lanes(block, TRACE_WIDTH, asked, call)
                                : end_closest_lanes(block, lanes, asked, call);
}

static ALWAYS_INLINE void end_any_lanes(trace_rays *restrict rays, unsigned lanes,
                                        const embree_asked *restrict asked) {
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t met = asked->valid[i] & (rays->t_far[i] < 0) ? ~0u : 0;
        rays->t_far[i] = chosen(met, -INFINITY, asked->t_far[i]);
    }
}

static void end_any(trace_rays *rays, unsigned lanes, const embree_asked *asked) {
    if (lanes == TRACE_WIDTH)
        end_any_lanes(rays, TRACE_WIDTH, asked);
    else
        end_any_lanes(rays, lanes, asked);
}

const embree_kernels KERNEL(embree_kernels) = {
    .prepare = prepare_lanes,
    .begin_closest = begin_closest,
    .end_closest = end_closest,
    .begin_any = begin_any,
    .end_any = end_any,
};
