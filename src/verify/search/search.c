#include "verify/search/search.h"
#include "trace/trace.h"
#include "verify/exact/filter.h"
#include "verify/mode.h"
#include "verify/search/search_tree.h"

#include <stdlib.h>
#include <string.h>

#define BATCH 64 /* spheres tested at a time */

struct search {
    const world *world;
    search_tree tree;
};

/* ---- primitives ---- */

static void set_plane(const world *w, uint32_t index, oracle_primitive *out) {
    out->shape = ORACLE_PLANE;
    out->v[0] = w->planes.items[index].point, out->v[1] = w->planes.items[index].normal;
}

static void set_sphere(const world_sphere *sphere, oracle_primitive *out) {
    out->shape = ORACLE_SPHERE;
    out->v[0] = sphere->center, out->radius = sphere->radius;
    out->rest = sphere->center_rest, out->radius_rest = sphere->radius_rest;
}

oracle_primitive search_primitive(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance) {
    oracle_primitive p;
    memset(&p, 0, sizeof p);
    if (instance != FATHOM_NONE) p.instance = &w->instances.items[instance];
    if (geometry == TRACE_PLANE) {
        set_plane(w, primitive, &p);
        return p;
    }
    const world_geometry *g = &w->geometries.items[geometry];
    switch (g->kind) {
    case WORLD_SPHERES: set_sphere(&w->spheres.items[g->first + primitive], &p); break;
    case WORLD_QUADS:
        p.shape = ORACLE_QUAD;
        memcpy(p.v, w->quads.items[g->first + primitive].corner, sizeof p.v);
        break;
    case WORLD_MESH: {
        const fathom_mesh *mesh = &w->meshes.items[g->first];
        p.shape = ORACLE_TRIANGLE;
        for (unsigned c = 0; c < 3; ++c)
            p.v[c] = load_f32(mesh_vertex(mesh, mesh->indices[3 * (size_t)primitive + c]));
        break;
    }
    }
    return p;
}

static MODE_APART bool prepare(search *s) { return search_tree_build(s->world, &s->tree); }

fathom_status search_create(fathom_context *context, const world *w, search **out) {
    *out = NULL;
    search *s = calloc(1, sizeof *s);
    if (!s) return fail_memory(context, sizeof *s);
    s->world = w;
    unsigned mode = mode_enter();
    bool built = prepare(s);
    mode_leave(mode);
    if (!built) {
        search_destroy(s);
        return fail_memory(context, w->geometries.count * sizeof *s->tree.parts);
    }
    *out = s;
    return FATHOM_OK;
}

void search_destroy(search *s) {
    if (!s) return;
    search_tree_free(&s->tree);
    free(s);
}

double search_extent(const search *s) { return s->tree.extent; }

void search_result_free(search_result *result) {
    array_free(&result->ties);
    array_free(&result->candidates);
    memset(result, 0, sizeof *result);
}

/* ---- candidates ---- */

typedef struct search_walk {
    const search *search;
    const oracle_ray *ray;
    search_result *result;
    filter_ray local; /* the ray in the current instance's space; its t_far shrinks with `closest` */
    double closest;   /* upper bound of the closest hit's t, from certain hits */
    uint32_t geometry, instance;
    bool shadows;     /* skip shapes that cast none */
    bool exhaustive;  /* test every primitive */
    double aside;     /* not 0: search_near() */
    bool failed;      /* out of memory */
    search_hit asked; /* the last candidate and its answer, hit or miss; geometry FATHOM_NONE: none yet */
    oracle_primitive primitive; /* the same candidate, for the oracle */
} search_walk;

static void add(search_walk *walk, uint32_t primitive, double low) {
    search_candidate c = {walk->geometry, primitive, walk->instance, low};
    if (!array_push(&walk->result->candidates, c)) walk->failed = true;
}

/* A certain hit shortens the ray for all later tests, but keeps hits with equal t. */
static void shorten(search_walk *walk, double high) {
    if (walk->aside > 0) return;
    if (high < walk->closest) walk->closest = high;
    double limit = walk->closest + fabs(walk->closest) * 0x1p-50;
    if (limit < walk->local.t_far) walk->local.t_far = limit;
}

static void consider_part(search_walk *walk, const oracle_primitive *p, unsigned part, double *low,
                          filter_verdict *verdict) {
    double first, high;
    vec3_f32 v[3];
    oracle_part(p, part, v);
    filter_verdict one = filter_triangle(&walk->local, widen(v[0]), widen(v[1]), widen(v[2]), &first, &high);
    if (one == FILTER_MISS) return;
    if (*verdict == FILTER_MISS || first < *low) *low = first;
    if (one > *verdict) *verdict = one;
    if (one == FILTER_HIT) shorten(walk, high);
}

static void consider(search_walk *walk, uint32_t primitive, double run_low) {
    oracle_primitive p = search_primitive(walk->search->world, walk->geometry, primitive, FATHOM_NONE);
    if (!search_tree_takes(&p)) return;
    filter_verdict verdict = FILTER_MISS;
    double low = run_low;
    switch (p.shape) {
    case ORACLE_SPHERE: {
        bool meets = filter_sphere(&walk->local, oracle_center(&p), fabs(oracle_radius(&p)), &low);
        verdict = meets ? FILTER_DOUBT : FILTER_MISS;
        break;
    }
    case ORACLE_TRIANGLE:
    case ORACLE_QUAD:
        for (unsigned part = 0; part < oracle_corners(&p) - 2; ++part)
            consider_part(walk, &p, part, &low, &verdict);
        break;
    case ORACLE_PLANE: verdict = FILTER_DOUBT; break;
    }
    if (verdict == FILTER_MISS) return;
    add(walk, primitive, low > run_low ? low : run_low);
}

static void consider_run(search_walk *walk, const search_part *part, size_t run, double low) {
    uint32_t count = walk->search->world->geometries.items[walk->geometry].count;
    uint32_t from = (uint32_t)run * SEARCH_RUN, end = count - from < SEARCH_RUN ? count : from + SEARCH_RUN;
    for (uint32_t p = from; p < end; ++p) consider(walk, part->order ? part->order[p] : p, low);
}

/* Tests the spheres [first, first + count) of a level, and their contents. */
static void walk_level(search_walk *walk, const search_part *part, unsigned level, size_t first,
                       size_t count) {
    uint8_t meets[BATCH];
    double low[BATCH];
    for (size_t i = first; i < first + count && !walk->failed; i += BATCH) {
        size_t n = first + count - i < BATCH ? first + count - i : BATCH;
        filter_run(&walk->local, &walk->search->tree.bounds, part->slot[level] + i, n, meets, low);
        for (size_t k = 0; k < n && !walk->failed; ++k) {
            if (!meets[k]) continue;
            if (level == 0) {
                consider_run(walk, part, i + k, low[k]);
            } else {
                size_t below = (i + k) * SEARCH_RUN, left = part->count[level - 1] - below;
                walk_level(walk, part, level - 1, below, left < SEARCH_RUN ? left : SEARCH_RUN);
            }
        }
    }
}

static int by_primitive(const void *a, const void *b) {
    uint32_t x = ((const search_candidate *)a)->primitive, y = ((const search_candidate *)b)->primitive;
    return (x > y) - (x < y);
}

static void walk_geometry(search_walk *walk) {
    const search_part *part = &walk->search->tree.parts[walk->geometry];
    uint32_t count = walk->search->world->geometries.items[walk->geometry].count;
    size_t begin = walk->result->candidates.count;
    if (walk->exhaustive) {
        for (uint32_t p = 0; p < count && !walk->failed; ++p) consider(walk, p, -(double)INFINITY);
    } else if (part->levels) {
        walk_level(walk, part, part->levels - 1, 0, part->count[part->levels - 1]);
    }
    size_t found = walk->result->candidates.count - begin;
    if (found > 1 && part->order)
        qsort(walk->result->candidates.items + begin, found, sizeof *walk->result->candidates.items,
              by_primitive);
}

/* Treats the origin as uncertain by `aside`, and ignores the interval, because t is then uncertain too. */
static void widen_filter(search_walk *walk, const world_instance *placed) {
    double norm = 0;
    for (int i = 0; placed && i < 9; ++i) norm += fabs((double)placed->to_object[i / 3][i % 3]);
    walk->local.org_error += walk->aside * (placed ? norm : 1);
    walk->local.t_near = -(double)INFINITY, walk->local.t_far = (double)INFINITY;
}

static void walk_group(search_walk *walk, uint32_t group, uint32_t instance) {
    const world *w = walk->search->world;
    const world_instance *placed = instance == FATHOM_NONE ? NULL : &w->instances.items[instance];
    walk->local = filter_ray_of(walk->ray, placed);
    if (walk->aside > 0) widen_filter(walk, placed);
    shorten(walk, walk->closest);
    walk->instance = instance;
    for (uint32_t g = 0; g < w->groups.items[group].count && !walk->failed; ++g) {
        walk->geometry = w->groups.items[group].first + g;
        if (walk->shadows && w->geometries.items[walk->geometry].flags & FATHOM_CASTS_NO_SHADOW) continue;
        walk_geometry(walk);
    }
}

static void walk_planes(search_walk *walk) {
    const world *w = walk->search->world;
    walk->geometry = TRACE_PLANE, walk->instance = FATHOM_NONE;
    for (uint32_t p = 0; p < w->planes.count; ++p) {
        if (walk->shadows && w->planes.items[p].flags & FATHOM_CASTS_NO_SHADOW) continue;
        add(walk, p, -(double)INFINITY);
    }
}

static void walk_world(search_walk *walk) {
    const world *w = walk->search->world;
    if (w->groups.count) walk_group(walk, 0, FATHOM_NONE);
    for (uint32_t k = 0; k < w->instances.count && !walk->failed; ++k) {
        walk_group(walk, w->instances.items[k].group, k);
    }
    walk_planes(walk);
}

/* ---- the oracle decides the remaining candidates ---- */

static bool same_shape(const oracle_primitive *a, const oracle_primitive *b) {
    return a->shape == b->shape && a->instance == b->instance && a->radius == b->radius &&
           a->radius_rest == b->radius_rest && memcmp(&a->rest, &b->rest, sizeof a->rest) == 0 &&
           memcmp(a->v, b->v, sizeof a->v) == 0;
}

/* Tests equal copies of a shape only once. The extreme cases have up to 10,000 copies. */
static const search_hit *ask(search_walk *walk, const search_candidate *c) {
    oracle_primitive primitive =
        search_primitive(walk->search->world, c->geometry, c->primitive, c->instance);
    search_hit *asked = &walk->asked;
    bool again = asked->geometry != FATHOM_NONE && same_shape(&primitive, &walk->primitive);
    asked->geometry = c->geometry, asked->primitive = c->primitive, asked->instance = c->instance;
    if (again) return asked;
    walk->primitive = primitive;
    oracle_ask(walk->ray, &primitive, &asked->answer);
    return asked;
}

static int order_of(search_walk *walk, const search_hit *hit, const search_hit *best) {
    oracle_pair a = {walk->primitive, hit->answer};
    oracle_pair b = {search_primitive(walk->search->world, best->geometry, best->primitive, best->instance),
                     best->answer};
    if (same_shape(&a.primitive, &b.primitive)) return 0;
    return oracle_compare(walk->ray, &a, &b);
}

static void decide(search_walk *walk) {
    search_result *result = walk->result;
    for (size_t i = 0; i < result->candidates.count && !walk->failed; ++i) {
        const search_candidate *c = &result->candidates.items[i];
        if (c->t_low > walk->closest) continue;
        const search_hit *hit = ask(walk, c);
        if (!hit->answer.hit) continue;
        int order = result->ties.count ? order_of(walk, hit, &result->ties.items[0]) : -1;
        if (order > 0) continue;
        if (order < 0) result->ties.count = 0;
        if (!array_push(&result->ties, *hit)) walk->failed = true;
        /* The next double above, because t may have been rounded down. */
        double above = nextafter((double)hit->answer.t, (double)INFINITY);
        if (above < walk->closest) walk->closest = above;
    }
}

static MODE_APART void walk_and_decide(search_walk *walk) {
    walk->asked.geometry = FATHOM_NONE;
    walk->closest = (double)INFINITY;
    walk->result->ties.count = walk->result->candidates.count = 0;
    walk_world(walk);
    if (walk->aside == 0) decide(walk);
}

static bool search_run(search_walk walk) {
    unsigned mode = mode_enter();
    walk_and_decide(&walk);
    mode_leave(mode);
    return !walk.failed;
}

bool search_closest(const search *s, const oracle_ray *ray, search_result *result) {
    return search_run((search_walk){.search = s, .ray = ray, .result = result});
}
bool search_exhaustive(const search *s, const oracle_ray *ray, search_result *result) {
    return search_run((search_walk){.search = s, .ray = ray, .result = result, .exhaustive = true});
}
bool search_shadow(const search *s, const oracle_ray *ray, search_result *result) {
    return search_run((search_walk){.search = s, .ray = ray, .result = result, .shadows = true});
}
bool search_near(const search *s, const oracle_ray *ray, double aside, search_result *result) {
    return search_run(
        (search_walk){.search = s, .ray = ray, .result = result, .shadows = true, .aside = aside});
}
