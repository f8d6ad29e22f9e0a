/* One answer for every ray, however rays are grouped.
 *
 * Embree's kernels agree to the last bit on whether a ray meets a triangle and at which t, but where two
 * candidates are equally near, the one visited last stays, and that depends on the kernel, on the other rays
 * of the packet and on the tree, whose layout at low build quality depends on the threads. Coherent packets
 * also skip a box that begins, rounded, behind the t at hand, so candidates a few units apart can change
 * places too. Both happen at every edge that two triangles share and wherever surfaces touch.
 *
 * So each candidate is noted when Embree accepts it, and the ray is kept longer than its best hit by
 * a window, within which further candidates are still seen. A ray that saw but one keeps it. A ray that saw
 * two is tied, and is asked once more, alone: the candidates within half the window of the best are put to
 * the vote of embree_vote.h.
 *
 * The window, 2^-14 of t, is 1024 units of roundoff. The t of a triangle is off by some 8 u / cos θ, θ the
 * angle to its normal, so half of it covers rays that graze at cos θ = 1/64. Differences between kernels were
 * measured up to 2e-6 of t, a fifteenth of that.
 *
 * A ray along an axis, one that keeps a coordinate, gets to one side alone of a box's face in which it runs:
 * to which of two triangles at an edge in such a plane depends on the tree. So where such a ray meets an edge
 * it is asked once for each side, by directions that lean to it by less than rounding.
 *
 * One case remains: a ray that passes an edge within rounding can be accepted by the triangle but skipped by
 * its box, which depends on kernel and tree. None of 4e7 random and camera rays did; of rays aimed at edges
 * and vertices, 2 in a million.
 *
 * Embree and the reference intersector still disagree about some edges. Both decide the side in float, each
 * off by a few units of the distance, so Embree may offer only the neighbour of what the reference meets: for
 * 24 of 4.9 million camera rays on a sphere of 100 thousand triangles, and for 78 on one of a million. Two of
 * those 78 pass the rim of what only the reference meets, and meet something farther. No filter sees what
 * Embree rejects, so no vote finds it. Kernels with and without fused products differ among themselves as
 * much. */
#include "base/kernel.h"
#include "trace/embree/embree_vote.h"

#include <math.h>

/* ---- every ray: noting candidates ---- */

float embree_offer(embree_call *call, unsigned lane, const float *hit, unsigned n, float t) {
    if (call->vote) embree_vote_consider(call->vote, hit, n, t);
    float best = call->best[lane], nearest = t < best ? t : best, reach = nearest * EMBREE_WINDOW;
    call->tied[lane] = best <= t * EMBREE_WINDOW;
    call->best[lane] = nearest;
    return reach < call->far[lane] ? reach : call->far[lane];
}

/* Accepts every candidate and lengthens the ray again, as filters may. */
static __attribute__((noinline)) void filter_any(const struct RTCFilterFunctionNArguments *args) {
    embree_call *call = (embree_call *)args->context;
    unsigned n = args->N;
    float *ray = (float *)(void *)args->ray, *t_far = ray + EMBREE_ROW_T_FAR * n;
    const uint32_t *ids = (const uint32_t *)(const void *)(ray + EMBREE_ROW_ID * n);
    const float *hit = (const float *)(const void *)args->hit;
    for (unsigned i = 0; i < n; ++i)
        if (args->valid[i]) t_far[i] = embree_offer(call, ids[i], hit + i, n, t_far[i]);
}

/* True if the rays of a packet are a run of the block's lanes in order, as they are unless Embree regrouped
 * them. */
static inline __attribute__((always_inline)) bool in_order(const uint32_t *ids, unsigned n) {
    uint32_t first = ids[0] & (LANES - n), moved = 0;
    for (unsigned i = 0; i < n; ++i) moved |= ids[i] ^ (first + i);
    return !moved;
}

/* The same for a packet of n rays, n known to the compiler, as a loop that vectorises. */
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

/* Where Embree runs packets of 16 or 8 the processor has the instructions for them. Compares, selects and
 * products come out the same with all of them. */
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

/* ---- the tied ray asked again ---- */

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

/* Puts to the vote what the lane's ray meets in a direction of its own. */
static void ask(const embree_tracer *tracer, const trace_rays *r, unsigned lane, vec3_f32 dir, float t_far,
                embree_vote *vote) {
    struct RTCRayHit alone =
        embree_alone(trace_org(r, lane), dir, embree_t_near(r->t_near[lane]), t_far, EMBREE_SEEN);
    alone.ray.time = r->time[lane];
    embree_call call = {.best[0] = INFINITY, .far[0] = t_far, .vote = vote};
    embree_context_init(&call.context);
    embree_intersect(1, NULL, tracer->scenes[0], &call.context, false, filter_any, &alone);
}

/* Asks on both sides of each coordinate that the ray keeps too small for Embree. */
void embree_settle(const embree_tracer *tracer, trace_block *block, unsigned lane, float t_far) {
    const trace_rays *r = &block->rays;
    const float straight[3] = {r->dir_x[lane], r->dir_y[lane], r->dir_z[lane]};
    embree_vote vote;
    embree_vote_begin(&vote, tracer, r, lane, t_far);
    for (unsigned side = 0; side < 8; ++side) {
        float dir[3];
        bool other = true; /* than those before it */
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
