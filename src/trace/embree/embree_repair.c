/* Finds hits that Embree missed at vertices.
 *
 * Embree's robust triangle test (Plücker coordinates relative to the ray's origin) decides each edge by a
 * sum. Its error is a few units u of the distance times the edge's length, whatever the triangle's size. The
 * two triangles at an edge compute the same sum, so edges do not leak. Around a vertex, each edge of the fan
 * has its own error: a ray that passes within a few u of the distance can be outside every triangle. The
 * reference intersector has no such gaps: it decides exactly on corners that it rounds once, in the same way
 * for each triangle.
 *
 * So a ray with an impossible hit (found by watertight.c) is surrounded: sixteen rays around it, at 2^-20 of
 * the distance, sixteen times the error, find the nearby triangles as candidates. The reference intersector
 * decides which of them the ray itself hits. If a triangle is too narrow or too small for these rays, or an
 * instance's transform rounds more, further rounds follow, with the rays rotated and four times farther out
 * each time. */
#include "trace/embree/embree_vote.h"

#include <math.h>
#include <stdlib.h>

/* A call that records all candidates and accepts none. The ray masks exclude user geometry, so only the
 * filter gets this context. */
typedef struct gather {
    embree_context context; /* first, so that a callback's context is the gather */
    embree_vote *vote;      /* either collect candidates here */
    trace_crossings *list;  /* or list crossings here */
    bool out_of_memory;
} gather;

static void list_crossing(gather *to, const struct RTCFilterFunctionNArguments *args, unsigned i) {
    unsigned n = args->N;
    const float *ray = (const float *)(const void *)args->ray + i;
    const float *hit = (const float *)(const void *)args->hit + i;
    const uint32_t *id = (const uint32_t *)(const void *)hit;
    float along = 0; /* both in the space of the primitive */
    for (unsigned c = 0; c < 3; ++c) along += ray[(EMBREE_ROW_DIR + c) * n] * hit[(EMBREE_ROW_NG + c) * n];
    trace_crossing crossing = {.t = ray[EMBREE_ROW_T_FAR * n],
                               .instance = id[EMBREE_ROW_INSTANCE * n],
                               .geometry = id[EMBREE_ROW_GEOMETRY * n],
                               .primitive = id[EMBREE_ROW_PRIMITIVE * n],
                               .entering = along < 0};
    if (!array_push(to->list, crossing)) to->out_of_memory = true;
}

static void gather_filter(const struct RTCFilterFunctionNArguments *args) {
    gather *to = (gather *)args->context;
    const float *hit = (const float *)(const void *)args->hit;
    const float *t = (const float *)(const void *)args->ray + EMBREE_ROW_T_FAR * args->N;
    for (unsigned i = 0; i < args->N; ++i) {
        if (!args->valid[i]) continue;
        args->valid[i] = 0;
        if (to->list)
            list_crossing(to, args, i);
        else
            embree_vote_consider(to->vote, hit + i, args->N, t[i]);
    }
}

/* ---- surrounding a ray ---- */

/* Sixteen rays on a cone around the lane's ray. In double, because directions need not be unit and may be
 * huge. */
static void surround(const trace_rays *from, unsigned lane, unsigned round, trace_rays *out) {
    const double apart = ldexp(1, -20 + 2 * (int)round), step = 6.283185307179586 / LANES;
    vec3_f64 d = {(double)from->dir_x[lane], (double)from->dir_y[lane], (double)from->dir_z[lane]};
    vec3_f64 axis = fabs(d.x) < fabs(d.y) ? vec_f64(1, 0, 0) : vec_f64(0, 1, 0);
    vec3_f64 a = normalize_f64(cross_f64(d, axis)), b = cross_f64(normalize_f64(d), a);
    double radius = apart * length_f64(d);
    float far = from->t_far[lane] * (float)(1 + 4 * apart);
    for (unsigned i = 0; i < LANES; ++i) {
        double angle = (i + 0.38 * (round + 1)) * step;
        vec3_f64 to = madd_f64(madd_f64(d, radius * cos(angle), a), radius * sin(angle), b);
        out->org_x[i] = from->org_x[lane], out->org_y[i] = from->org_y[lane];
        out->org_z[i] = from->org_z[lane];
        out->dir_x[i] = (float)to.x, out->dir_y[i] = (float)to.y, out->dir_z[i] = (float)to.z;
        out->t_near[i] = from->t_near[lane], out->t_far[i] = far;
    }
}

/* True if the lane's own ray hits any of the triangles around it. */
static bool look_around(const embree_tracer *tracer, const trace_rays *rays, unsigned lane, unsigned round,
                        uint32_t mask, embree_vote *vote) {
    trace_block around;
    _Alignas(64) int valid[LANES];
    gather to = {.vote = vote};
    embree_vote_begin(vote, tracer, rays, lane, rays->t_far[lane]);
    surround(rays, lane, round, &around.rays);
    tracer->kernels->prepare(tracer, &around.rays, LANES, mask, valid);
    for (unsigned i = 0; i < LANES; ++i)
        around.hits.geometry[i] = around.hits.instance[i] = RTC_INVALID_GEOMETRY_ID;
    embree_context_init(&to.context);
    const embree_way way = {tracer->width, true};
    embree_closest_packets(tracer, &around, valid, LANES, &way, &to.context, gather_filter);
    return vote->met.any;
}

static bool retry_closest(const trace_tracer *tracer, trace_block *block, unsigned lane, unsigned round) {
    embree_vote vote;
    if (!look_around((const embree_tracer *)tracer, &block->rays, lane, round, EMBREE_MESHES, &vote))
        return false;
    search_end_f32(&vote.search, block, NULL, lane);
    return true;
}

static bool retry_any(const trace_tracer *tracer, trace_rays *rays, unsigned lane, unsigned round) {
    embree_vote vote;
    if (!look_around((const embree_tracer *)tracer, rays, lane, round, EMBREE_MESH_SHADOWS, &vote))
        return false;
    rays->t_far[lane] = -INFINITY;
    return true;
}

/* ---- all crossings of a line ---- */

static int by_ids(const void *a, const void *b) {
    const trace_crossing *x = a, *y = b;
    if (x->instance != y->instance) return x->instance < y->instance ? -1 : 1;
    if (x->geometry != y->geometry) return x->geometry < y->geometry ? -1 : 1;
    return (x->primitive > y->primitive) - (x->primitive < y->primitive);
}

/* If a build splits a triangle spatially, both parts report it: keeps one of each. */
static void leave_one_each(trace_crossings *list) {
    size_t kept = 0;
    if (list->count) qsort(list->items, list->count, sizeof *list->items, by_ids);
    for (size_t i = 0; i < list->count; ++i)
        if (!kept || by_ids(&list->items[kept - 1], &list->items[i]) != 0)
            list->items[kept++] = list->items[i];
    list->count = kept;
}

static bool crossings(const trace_tracer *base, uint32_t group, vec3_f32 org, vec3_f32 dir,
                      trace_crossings *out) {
    const embree_tracer *tracer = (const embree_tracer *)base;
    struct RTCRayHit alone = embree_alone(org, dir, 0, INFINITY, EMBREE_MESHES);
    gather to = {.list = out};
    out->count = 0;
    if (!tracer->scenes[group]) return true;
    embree_context_init(&to.context);
    embree_intersect(1, NULL, tracer->scenes[group], &to.context, false, gather_filter, &alone);
    for (size_t i = 0; i < out->count; ++i)
        embree_world_ids(base->world, group, &out->items[i].instance, &out->items[i].geometry);
    leave_one_each(out);
    return !to.out_of_memory;
}

static void bounds(const trace_tracer *base, uint32_t group, vec3_f32 *lower, vec3_f32 *upper) {
    RTCScene scene = ((const embree_tracer *)base)->scenes[group];
    struct RTCBounds b = {.lower_x = 1, .upper_x = 0};
    if (scene) rtcGetSceneBounds(scene, &b);
    *lower = vec_f32(b.lower_x, b.lower_y, b.lower_z);
    *upper = vec_f32(b.upper_x, b.upper_y, b.upper_z);
}

const trace_retry *embree_retry(const trace_spec *spec) {
    static const trace_retry retry = {retry_closest, retry_any, crossings, bounds};
    return spec->shapes == TRACE_SHAPES_USER || spec->ties == TRACE_RAW ? NULL : &retry;
}
