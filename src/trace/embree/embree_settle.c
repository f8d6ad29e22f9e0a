/* Makes the hit of a ray independent of how rays are grouped.
 *
 * Embree's kernels agree to the last bit on whether a ray hits a triangle and at which t. But if two
 * candidates have equal t, the last one visited wins. That depends on the kernel, on the other rays of the
 * packet and on the tree, whose layout at low build quality depends on the threads. Coherent packets also
 * skip a box whose rounded start lies behind the current t, so candidates a few units apart can swap too.
 * Both happen at every shared edge and wherever surfaces touch.
 *
 * So the filter records each candidate that Embree accepts, and sets the ray's t_far beyond its best hit by a
 * window, so that further candidates in it are still visited. If there was only one, it is the hit. If there
 * were two, the ray is tied and is traced once more, alone: the vote of embree_vote.h decides between the
 * candidates within half the window of the best.
 *
 * The window, 2^-14 of t, is 1024 units of roundoff. The error of a triangle's t is about 8 u / cos θ, θ the
 * angle to its normal, so half of the window covers grazing rays up to cos θ = 1/64. Measured differences
 * between kernels are at most 2e-6 of t, a fifteenth of that.
 *
 * A ray along an axis (with a constant coordinate) that runs in a face of a box enters only the box on one
 * side of it. Which of the two triangles at an edge in such a plane it hits depends on the tree. So if such a
 * ray hits an edge, it is traced once for each side, with directions that lean to that side by less than
 * rounding.
 *
 * One case remains: if a ray passes an edge within rounding, the triangle test may accept it although the
 * traversal skips the triangle's box. This depends on kernel and tree. It happened to none of 4e7 random and
 * camera rays; of rays aimed at edges and vertices, 2 in a million.
 *
 * Embree and the reference intersector still disagree about some edges. Both decide the side in float, with
 * an error of a few units of the distance, so Embree may report only the neighbour of the triangle that the
 * reference hits: for 24 of 4.9 million camera rays on a sphere of 100 thousand triangles, and for 78 on one
 * of a million. Two of those 78 pass the rim of the only triangle that the reference hits, and hit something
 * farther away. No filter sees the triangles that Embree rejects, so no vote finds them. Kernels with and
 * without fused multiply-add differ from each other as often. */
#include "base/kernel.h"
#include "trace/embree/embree_vote.h"

#include <math.h>

/* ---- every ray: recording candidates ---- */

float embree_offer(embree_call *call, unsigned lane, const float *hit, unsigned n, float t) {
    if (call->vote) embree_vote_consider(call->vote, hit, n, t);
    float best = call->best[lane], nearest = t < best ? t : best, reach = nearest * EMBREE_WINDOW;
    call->tied[lane] = best <= t * EMBREE_WINDOW;
    call->best[lane] = nearest;
    return reach < call->far[lane] ? reach : call->far[lane];
}

/* Accepts every candidate and extends t_far again, which filters may do. */
static __attribute__((noinline)) void filter_any(const struct RTCFilterFunctionNArguments *args) {
    embree_call *call = (embree_call *)args->context;
    unsigned n = args->N;
    float *ray = (float *)(void *)args->ray, *t_far = ray + EMBREE_ROW_T_FAR * n;
    const uint32_t *ids = (const uint32_t *)(const void *)(ray + EMBREE_ROW_ID * n);
    const float *hit = (const float *)(const void *)args->hit;
    for (unsigned i = 0; i < n; ++i)
        if (args->valid[i]) t_far[i] = embree_offer(call, ids[i], hit + i, n, t_far[i]);
}

/* True if the rays of a packet are consecutive lanes of the block in order. They are, unless Embree regrouped
 * them. */
static inline __attribute__((always_inline)) bool in_order(const uint32_t *ids, unsigned n) {
    uint32_t first = ids[0] & (LANES - n), moved = 0;
    for (unsigned i = 0; i < n; ++i) moved |= ids[i] ^ (first + i);
    return !moved;
}

/* Same for a packet of n rays. n is a compile-time constant, so the loop vectorises. */
static inline __attribute__((always_inline)) void
filter_packet(const struct RTCFilterFunctionNArguments *args, unsigned n) {
    embree_call *call = (embree_call *)args->context;
    float *ray = (float *)(void *)args->ray, *restrict t_far = ray + EMBREE_ROW_T_FAR * n;
    const uint32_t *ids = (const uint32_t *)(const void *)(ray + EMBREE_ROW_ID * n);
    if (args->N != n || !in_order(ids, n)) {
        filter_any(args);
        return;
    }
    uint32_t first = n == LANES ? 0 : ids[0];
    const int *restrict valid = args->valid;
    float *restrict bests = call->best + first, *restrict fars = call->far + first;
    int *restrict ties = call->tied + first;
    for (unsigned i = 0; i < n; ++i) {
        float t = t_far[i], best = bests[i], nearest = t < best ? t : best, reach = nearest * EMBREE_WINDOW;
        int tied = best <= t * EMBREE_WINDOW;
        reach = reach < fars[i] ? reach : fars[i];
        ties[i] = valid[i] ? tied : ties[i];
        bests[i] = valid[i] ? nearest : best;
        t_far[i] = valid[i] ? reach : t;
    }
}

/* If Embree runs packets of 16 or 8, the processor has the instructions for them. Comparisons, selects and
 * products give the same bits with every instruction set. */
#if defined(__x86_64__)
#define INSTRUCTIONS(isa) __attribute__((target(isa)))
#else
#define INSTRUCTIONS(isa)
#endif

INSTRUCTIONS(KERNEL_TARGET_AVX512)
static void filter_16(const struct RTCFilterFunctionNArguments *args) { filter_packet(args, 16); }

INSTRUCTIONS("avx") static void filter_8(const struct RTCFilterFunctionNArguments *args) {
    filter_packet(args, 8);
}

RTCFilterFunctionN embree_filter(unsigned width) {
    return width == 16 ? filter_16 : (width == 8 ? filter_8 : filter_any);
}

/* ---- tracing the tied ray again ---- */

static void announce(trace_block *block, unsigned lane, float t_far, const embree_offered *winner) {
    block->rays.t_far[lane] = embree_move_inside(winner->t, block->rays.t_near[lane], t_far);
    trace_hits *hits = &block->hits;
    hits->ng_x[lane] = winner->normal[0], hits->ng_y[lane] = winner->normal[1],
    hits->ng_z[lane] = winner->normal[2];
    hits->u[lane] = winner->u, hits->v[lane] = winner->v;
    hits->instance[lane] = winner->ids[0];
    hits->geometry[lane] = winner->ids[1];
    hits->primitive[lane] = winner->ids[2];
}

/* Traces the lane's ray with another direction; its candidates go to the vote. */
static void ask(const embree_tracer *tracer, const trace_rays *r, unsigned lane, vec3_f32 dir, float t_far,
                embree_vote *vote) {
    struct RTCRayHit alone =
        embree_alone(trace_org(r, lane), dir, embree_t_near(r->t_near[lane]), t_far, EMBREE_SEEN);
    alone.ray.time = r->time[lane];
    embree_call call = {.best[0] = INFINITY, .far[0] = t_far, .vote = vote};
    embree_context_init(&call.context);
    embree_intersect(1, NULL, tracer->scenes[0], &call.context, false, filter_any, &alone);
}

/* Each direction component that is below Embree's minimum is tried with both signs of that minimum. */
void embree_settle(const embree_tracer *tracer, trace_block *block, unsigned lane, float t_far) {
    const trace_rays *r = &block->rays;
    const float straight[3] = {r->dir_x[lane], r->dir_y[lane], r->dir_z[lane]};
    embree_vote vote;
    embree_vote_begin(&vote, tracer, r, lane, t_far);
    for (unsigned side = 0; side < 8; ++side) {
        float dir[3];
        bool other = true; /* different from all earlier directions */
        for (unsigned k = 0; k < 3; ++k) {
            bool kept = fabsf(straight[k]) < EMBREE_LEAST_DIRECTION, below = side >> k & 1;
            dir[k] = !kept ? straight[k] : (below ? -EMBREE_LEAST_DIRECTION : EMBREE_LEAST_DIRECTION);
            other &= kept || !below;
        }
        if (other) ask(tracer, r, lane, load_f32(dir), t_far, &vote);
    }
    bool near = vote.met.any && vote.search.best.t <= vote.offered.t * EMBREE_HALF_WINDOW;
    if (vote.offered.any) announce(block, lane, t_far, near ? &vote.met : &vote.offered);
}
