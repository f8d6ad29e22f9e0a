/* The work on a block of rays before and after Embree's call. */
#include "base/kernel.h"
#include "trace/embree/embree.h"
#include "trace/stretch.h"

#include <math.h>

#define ALWAYS_INLINE inline __attribute__((always_inline))

/* ---- before ---- */

/* Embree can abort on numbers that are not finite or too large. Lanes with such numbers are not traced: they
 * miss. */
static ALWAYS_INLINE void prepare(const embree_tracer *tracer, trace_rays *restrict rays, unsigned lanes,
                                  uint32_t mask, int *restrict valid) {
    const float reach = tracer->reach.origin,
                longest = tracer->reach.direction; /* a NaN is never within them */
    for (unsigned i = lanes; i < LANES; ++i) valid[i] = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        bool from = (fabsf(rays->org_x[i]) <= reach) & (fabsf(rays->org_y[i]) <= reach) &
                    (fabsf(rays->org_z[i]) <= reach);
        bool to = (fabsf(rays->dir_x[i]) <= longest) & (fabsf(rays->dir_y[i]) <= longest) &
                  (fabsf(rays->dir_z[i]) <= longest);
        valid[i] = from & to & (rays->t_near[i] < rays->t_far[i]) ? -1 : 0;
    }
    for (unsigned i = 0; i < lanes; ++i) {
        rays->t_near[i] = embree_t_near(rays->t_near[i]);
        rays->t_far[i] = embree_last_inside(rays->t_far[i]);
    }
    for (unsigned i = 0; i < lanes; ++i) rays->mask[i] = mask, rays->id[i] = i, rays->flags[i] = 0;
    if (tracer->base.world->moves) return;
    for (unsigned i = 0; i < lanes; ++i) rays->time[i] = 0;
}

static void prepare_lanes(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, uint32_t mask,
                          int valid[LANES]) {
    prepare(tracer, rays, lanes, mask, valid);
}

static ALWAYS_INLINE bool begin(const embree_tracer *tracer, trace_rays *restrict rays, unsigned lanes,
                                uint32_t mask, bool scaled, embree_asked *restrict asked) {
    if (!scaled && stretch_needed(rays, lanes, tracer->reach.direction)) return false;
    for (unsigned i = 0; i < lanes; ++i) asked->t_near[i] = rays->t_near[i], asked->t_far[i] = rays->t_far[i];
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
    for (unsigned i = 0; i < LANES; ++i) call->best[i] = INFINITY, call->tied[i] = 0;
    return true;
}

/* Nearly all blocks are full, and loops of constant length need no remainder code. */
static bool begin_closest(const embree_tracer *tracer, trace_block *block, unsigned lanes, bool scaled,
                          embree_asked *asked, embree_call *call) {
    return lanes == LANES ? begin_closest_lanes(tracer, block, LANES, scaled, asked, call)
                          : begin_closest_lanes(tracer, block, lanes, scaled, asked, call);
}

static bool begin_any(const embree_tracer *tracer, trace_rays *rays, unsigned lanes, bool scaled,
                      embree_asked *asked) {
    return lanes == LANES ? begin(tracer, rays, LANES, EMBREE_SHADOWS, scaled, asked)
                          : begin(tracer, rays, lanes, EMBREE_SHADOWS, scaled, asked);
}

static ALWAYS_INLINE embree_spread spread_lanes(const trace_rays *restrict rays, unsigned lanes) {
    const float x = rays->dir_x[0], y = rays->dir_y[0], z = rays->dir_z[0];
    const float length = fabsf(x) + fabsf(y) + fabsf(z);
    const float alike = EMBREE_ALIKE * length, similar = EMBREE_SIMILAR * length;
    uint32_t beyond_alike = 0, beyond_similar = 0;
    for (unsigned i = 0; i < lanes; ++i) {
        float off = fabsf(rays->dir_x[i] - x) + fabsf(rays->dir_y[i] - y) + fabsf(rays->dir_z[i] - z);
        beyond_alike |= off <= alike ? 0 : ~0u;
        beyond_similar |= off <= similar ? 0 : ~0u;
    }
    return beyond_similar ? EMBREE_SPREAD_WIDE : (beyond_alike ? EMBREE_SPREAD_SIMILAR : EMBREE_SPREAD_ALIKE);
}

static embree_spread spread(const trace_rays *rays, unsigned lanes) {
    return lanes == LANES ? spread_lanes(rays, LANES) : spread_lanes(rays, lanes);
}

/* ---- packets ---- */

/* Embree's kernels load whole rows; a row that was stored in parts stalls on store forwarding. Without tuning
 * flags, gcc would copy 32 bytes as two moves of 16. */
typedef uint32_t row_of_8 __attribute__((vector_size(32), aligned(4), may_alias));

static ALWAYS_INLINE void copy_row(uint32_t *to, const uint32_t *from, unsigned width) {
    if (width == 8)
        *(row_of_8 *)to = *(const row_of_8 *)from;
    else
        memcpy(to, from, width * sizeof *to);
}

/* Copies rows of `width` numbers. */
static ALWAYS_INLINE void copy_rows(uint32_t *to, unsigned to_row, const uint32_t *from, unsigned from_row,
                                    unsigned rows, unsigned width) {
    for (unsigned r = 0; r < rows; ++r) copy_row(to + r * to_row, from + r * from_row, width);
}

#define HIT_ROWS (EMBREE_ROW_INSTANCE + 1)

static ALWAYS_INLINE void split_by(unsigned width, const trace_rays *rays, const trace_hits *hits,
                                   embree_packets *out) {
    const uint32_t *ray = (const uint32_t *)(const void *)rays, *hit = (const uint32_t *)(const void *)hits;
    for (unsigned first = 0; first < LANES; first += width) {
        uint32_t *to = embree_packet(out, first);
        copy_rows(to, width, ray + first, LANES, EMBREE_RAY_ROWS, width);
        if (hit) copy_rows(to + EMBREE_RAY_ROWS * width, width, hit + first, LANES, HIT_ROWS, width);
    }
}

static void split(const trace_rays *rays, const trace_hits *hits, unsigned width, embree_packets *out) {
    if (width == 8) split_by(8, rays, hits, out);
    if (width == 4) split_by(4, rays, hits, out);
    if (width == 1) split_by(1, rays, hits, out);
}

static ALWAYS_INLINE void join_by(unsigned width, const embree_packets *packets, trace_rays *rays,
                                  trace_hits *hits) {
    uint32_t *hit = (uint32_t *)(void *)hits;
    for (unsigned first = 0; first < LANES; first += width) {
        const uint32_t *from = &packets->rows[EMBREE_PACKET_ROWS * first];
        memcpy(&rays->t_far[first], from + EMBREE_ROW_T_FAR * width, width * sizeof *rays->t_far);
        if (hit) copy_rows(hit + first, LANES, from + EMBREE_RAY_ROWS * width, width, HIT_ROWS, width);
    }
}

static void join(const embree_packets *from, unsigned width, trace_rays *rays, trace_hits *hits) {
    if (width == 8) join_by(8, from, rays, hits);
    if (width == 4) join_by(4, from, rays, hits);
    if (width == 1) join_by(1, from, rays, hits);
}

/* ---- after ---- */

/* Width of an edge in barycentric coordinates: above their rounding error, for triangles seen from up to 2^10
 * times their size. */
#define EDGE 0x1p-12f

/* All ones if embree_settle.c must trace both sides of a box: a hit at an edge by a ray along an axis. */
static ALWAYS_INLINE uint32_t along_box(const trace_block *restrict block, unsigned i) {
    const trace_rays *r = &block->rays;
    const float u = block->hits.u[i], v = block->hits.v[i], least = EMBREE_LEAST_DIRECTION;
    bool along = (fabsf(r->dir_x[i]) < least) | (fabsf(r->dir_y[i]) < least) | (fabsf(r->dir_z[i]) < least);
    bool edge = (u <= EDGE) | (v <= EDGE) | (u + v >= 1 - EDGE);
    return along & edge ? ~0u : 0;
}

static ALWAYS_INLINE uint32_t end_closest_lanes(trace_block *restrict block, unsigned lanes,
                                                const embree_asked *restrict asked,
                                                embree_call *restrict call) {
    uint32_t tied = 0, noted = call->raw ? 0 : ~0u;
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t missed = block->hits.geometry[i] == RTC_INVALID_GEOMETRY_ID ? ~0u : 0;
        float met = chosen(noted, call->best[i], block->rays.t_far[i]);
        met = embree_move_inside(met, asked->t_near[i], call->far[i]);
        block->rays.t_far[i] = chosen(missed, asked->t_far[i], met);
        block->rays.t_near[i] = asked->t_near[i];
        uint32_t open = (uint32_t)call->tied[i] | along_box(block, i);
        call->tied[i] = (int)open;
        tied |= open & noted & ~missed;
    }
    return tied;
}

static bool end_closest(trace_block *block, unsigned lanes, const embree_asked *asked, embree_call *call) {
    return lanes == LANES ? end_closest_lanes(block, LANES, asked, call)
                          : end_closest_lanes(block, lanes, asked, call);
}

/* in_halves: 1 for lanes whose hit is a quad traced as two triangles. Without a branch, because the half is
 * unpredictable. */
static ALWAYS_INLINE void join_lanes(const uint32_t *restrict in_halves, trace_hits *restrict hits,
                                     unsigned lanes) {
    for (unsigned i = 0; i < lanes; ++i) {
        const uint32_t second = 0u - (in_halves[i] & hits->primitive[i]);
        hits->u[i] = chosen(second, 1 - hits->u[i], hits->u[i]);
        hits->v[i] = chosen(second, 1 - hits->v[i], hits->v[i]);
        hits->primitive[i] >>= in_halves[i];
    }
}

/* Most blocks hit only one geometry, which is then looked up once. The smallest id is one that was hit. */
static ALWAYS_INLINE void join_halves_lanes(const uint32_t *restrict halved, trace_hits *restrict hits,
                                            unsigned lanes) {
    uint32_t least = RTC_INVALID_GEOMETRY_ID, other = 0, in_halves[LANES];
    for (unsigned i = 0; i < lanes; ++i) least = hits->geometry[i] < least ? hits->geometry[i] : least;
    for (unsigned i = 0; i < lanes; ++i) {
        in_halves[i] = hits->geometry[i] == RTC_INVALID_GEOMETRY_ID ? 0 : 1;
        other |= in_halves[i] & (hits->geometry[i] == least ? 0 : 1);
    }
    if (other) {
        for (unsigned i = 0; i < lanes; ++i) in_halves[i] &= halved[in_halves[i] ? hits->geometry[i] : least];
    } else if (least == RTC_INVALID_GEOMETRY_ID || !halved[least]) {
        return;
    }
    join_lanes(in_halves, hits, lanes);
}

static void join_halves(const uint32_t *halved, trace_hits *hits, unsigned lanes) {
    if (lanes == LANES)
        join_halves_lanes(halved, hits, LANES);
    else
        join_halves_lanes(halved, hits, lanes);
}

static ALWAYS_INLINE void end_any_lanes(trace_rays *restrict rays, unsigned lanes,
                                        const embree_asked *restrict asked) {
    for (unsigned i = 0; i < lanes; ++i) {
        uint32_t met = asked->valid[i] & (rays->t_far[i] < 0) ? ~0u : 0;
        rays->t_far[i] = chosen(met, -INFINITY, asked->t_far[i]);
        rays->t_near[i] = asked->t_near[i];
    }
}

static void end_any(trace_rays *rays, unsigned lanes, const embree_asked *asked) {
    if (lanes == LANES)
        end_any_lanes(rays, LANES, asked);
    else
        end_any_lanes(rays, lanes, asked);
}

const embree_kernels KERNEL(embree_kernels) = {
    .prepare = prepare_lanes,
    .begin_closest = begin_closest,
    .end_closest = end_closest,
    .join_halves = join_halves,
    .begin_any = begin_any,
    .end_any = end_any,
    .spread = spread,
    .split = split,
    .join = join,
};
