/* A few spheres, tested after Embree's calls; see embree_spheres.h. */
#include "base/kernel.h"
#include "trace/embree/embree_vote.h"

#include <math.h>
#include <stdlib.h>

KERNEL_BEST(few_kernels)

static void add_sphere(const world *w, uint32_t geometry, uint32_t primitive, few_spheres *out) {
    const world_geometry *run = &w->geometries.items[geometry];
    const world_sphere *sphere = &w->spheres.items[run->first + primitive];
    unsigned k = out->count++;
    out->x[k] = sphere->center.x, out->y[k] = sphere->center.y, out->z[k] = sphere->center.z;
    out->radius[k] = sphere->radius;
    out->sphere[k] = sphere;
    out->geometry[k] = geometry, out->primitive[k] = primitive;
    if (!(run->flags & FATHOM_CASTS_NO_SHADOW)) out->shadows |= 1u << k;
}

bool few_gather(const world *w, few_spheres *out) {
    const world_group *root = &w->groups.items[0];
    *out = (few_spheres){.count = 0};
    for (uint32_t g = root->first; g < root->first + root->count; ++g) {
        if (w->geometries.items[g].kind != WORLD_SPHERES) continue;
        if (w->geometries.items[g].count > FEW_SPHERES_MOST - out->count) return false;
        for (uint32_t i = 0; i < w->geometries.items[g].count; ++i) add_sphere(w, g, i, out);
    }
    return out->count > 0;
}

fathom_status embree_spheres_choose(embree_tracer *tracer) {
    few_spheres spheres;
    if (tracer->spec.shapes == TRACE_SHAPES_USER || !few_gather(tracer->base.world, &spheres))
        return FATHOM_OK;
    tracer->few = aligned_alloc(_Alignof(few_spheres), sizeof spheres);
    if (!tracer->few) return fail_memory(tracer->context, sizeof spheres);
    *tracer->few = spheres;
    tracer->few_kernels = few_kernels_best();
    return FATHOM_OK;
}

/* ---- one ray ---- */

/* The sphere's nearest t in the interval, by the reference intersector. */
static bool sphere_t(const world_sphere *sphere, const trace_rays *r, unsigned i, float t_far, float *t) {
    return search_sphere_robust_f32(sphere, trace_org(r, i), trace_dir(r, i), r->t_near[i], t_far, t);
}

/* The valid lanes as bits. In a partial block, the unused lanes are undefined. */
static unsigned lanes_of(const int valid[LANES]) {
    unsigned lanes = 0;
    for (unsigned i = 0; i < LANES; ++i) lanes |= (unsigned)(valid[i] & 1) << i;
    return lanes;
}

/* Returns the lanes that may hit the sphere, as bits. A partial block is not tested here: all its lanes are
 * in doubt. */
static unsigned candidates(const embree_tracer *tracer, unsigned k, const trace_rays *rays, unsigned lanes,
                           bool whole, few_roots *roots) {
    if (whole)
        tracer->few_kernels->roots(tracer->few->sphere[k], rays, roots);
    else
        roots->met = 0, roots->doubt = lanes;
    return (roots->met | roots->doubt) & lanes;
}

static bool lane_t(const world_sphere *sphere, const trace_rays *rays, const few_roots *roots, unsigned i,
                   float t_far, float *t) {
    if (roots->doubt >> i & 1) return sphere_t(sphere, rays, i, t_far, t);
    const float both[2] = {roots->near[i], roots->far[i]};
    return sphere_choose_f32(both, rays->t_near[i], t_far, t);
}

/* ---- a hit ---- */

/* True if the sphere at t is nearer than the lane's present hit. If both are about equally near, compares the
 * reference intersector's t of both, as embree_settle.c does. */
static bool comes_first(const embree_tracer *tracer, const trace_block *block, unsigned lane, float t_far,
                        const uint32_t ids[3], float t) {
    const trace_hits *hits = &block->hits;
    float met = block->rays.t_far[lane];
    if (hits->geometry[lane] == FATHOM_NONE) return true;
    const uint32_t other[3] = {hits->instance[lane], hits->geometry[lane], hits->primitive[lane]};
    bool settled = tracer->filter && t <= met * EMBREE_HALF_WINDOW && met <= t * EMBREE_HALF_WINDOW;
    /* If the reference intersector misses, Embree's t stays. */
    if (settled) (void)embree_vote_reference(tracer, &block->rays, lane, t_far, other, &met);
    return t < met || (t == met && search_comes_before_f32(ids, other));
}

static void set_hit(trace_block *block, unsigned lane, const few_spheres *s, unsigned k, float t) {
    trace_rays *r = &block->rays;
    trace_hits *hits = &block->hits;
    vec3_f32 normal = madd_f32(sub_f32(trace_org(r, lane), s->sphere[k]->center), t, trace_dir(r, lane));
    hits->ng_x[lane] = normal.x, hits->ng_y[lane] = normal.y, hits->ng_z[lane] = normal.z;
    hits->u[lane] = hits->v[lane] = 0;
    hits->primitive[lane] = s->primitive[k], hits->geometry[lane] = s->geometry[k];
    hits->instance[lane] = FATHOM_NONE;
    r->t_far[lane] = t;
}

/* t_far of any-hit queries that meet the sphere. */
static float end_of(const embree_tracer *tracer, const few_spheres *s, unsigned k) {
    const embree_passing *p = tracer->passing ? &tracer->passing[s->geometry[k]] : NULL;
    return p && p->tracer && embree_lets_pass(p, s->primitive[k], RTC_INVALID_GEOMETRY_ID) ? TRACE_NOT_OPAQUE
                                                                                           : -INFINITY;
}

/* ---- a block ---- */

/* Tests the spheres `close` (bits): closest hits, or any hits if `block` is NULL. */
static void test_spheres(const embree_tracer *tracer, uint32_t close, trace_rays *rays, trace_block *block,
                         unsigned lanes, const embree_asked *asked) {
    const few_spheres *s = tracer->few;
    const bool whole = lanes == LANES;
    if (whole && close) close &= tracer->few_kernels->close(s, rays);
    const unsigned valid = close ? lanes_of(asked->valid) : 0;
    for (; close; close &= close - 1) {
        unsigned k = (unsigned)__builtin_ctz(close);
        const uint32_t ids[3] = {FATHOM_NONE, s->geometry[k], s->primitive[k]};
        few_roots roots;
        unsigned left = candidates(tracer, k, rays, valid, whole, &roots);
        for (; left; left &= left - 1) {
            unsigned i = (unsigned)__builtin_ctz(left);
            const float t_far = block ? asked->t_far[i] : rays->t_far[i];
            float t;
            if (!lane_t(s->sphere[k], rays, &roots, i, t_far, &t)) continue;
            if (!block)
                rays->t_far[i] = end_of(tracer, s, k);
            else if (comes_first(tracer, block, i, t_far, ids, t))
                set_hit(block, i, s, k, t);
        }
    }
}

void embree_spheres_closest(const embree_tracer *tracer, trace_block *block, unsigned lanes,
                            const embree_asked *asked) {
    test_spheres(tracer, (1u << tracer->few->count) - 1, &block->rays, block, lanes, asked);
}

void embree_spheres_any(const embree_tracer *tracer, trace_rays *rays, unsigned lanes,
                        const embree_asked *asked) {
    test_spheres(tracer, tracer->few->shadows, rays, NULL, lanes, asked);
}
