/* What tests of tracers share: scenes of every shape, and sets of rays. */
#pragma once

#include "base/array.h"
#include "trace/trace.h"
#include "worlds.h"

/* ---- random numbers, the same in each run ---- */

static uint64_t seed;
static inline double uniform(void) { /* [0,1) */
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return (double)(seed >> 11) * 0x1p-53;
}
static inline double between(double a, double b) { return a + (b - a) * uniform(); }

/* ---- scenes ---- */

typedef struct stage {
    fathom_context *context;
    fathom_scene *scene;
    world *world;
} stage;

UNIT_OWNS(tracer, trace_tracer, trace_destroy)

static inline stage stage_open(void) {
    stage s = {.context = new_context()};
    seed = 88172645463325252u;
    s.scene = new_scene(s.context);
    return s;
}

static inline world *stage_world(stage *s) {
    if (!s->world) s->world = new_world(s->scene);
    return s->world;
}

static inline trace_tracer *stage_trace(stage *s, const char *words, unsigned width, trace_quality quality,
                                        unsigned threads) {
    trace_options options = {.words = words, .width = width, .threads = threads, .quality = quality};
    trace_tracer *tracer = NULL;
    assert_ok(s->context, trace_create(s->context, stage_world(s), &options, &tracer));
    return own_tracer(tracer);
}

/* A tracer by its words. */
static inline trace_tracer *stage_spec(stage *s, const char *text) {
    trace_spec spec;
    assert_ok(s->context, trace_spec_parse(s->context, text, &spec));
    trace_options options = {.spec = &spec, .threads = 2};
    trace_tracer *tracer = NULL;
    assert_ok(s->context, trace_create(s->context, stage_world(s), &options, &tracer));
    return own_tracer(tracer);
}

static inline trace_tracer *stage_embree(stage *s, unsigned width) {
    return stage_trace(s, "embree", width, TRACE_QUALITY_AUTO, 2);
}

/* A closed, bumpy sphere of 4 n (n - 1) triangles around the origin. */
static inline fathom_id add_ball(stage *s, fathom_id group, unsigned n, double bump, double radius, double x,
                                 unsigned flags) {
    unsigned around = 2 * n, vertices = around * (n - 1) + 2;
    float *p = unit_memory(vertices * 3 * sizeof *p);
    uint32_t *index = unit_memory((size_t)around * 2 * (n - 1) * 3 * sizeof *index), *t = index;
    float *v = p;
    for (unsigned j = 1; j < n; ++j) {
        for (unsigned i = 0; i < around; ++i) {
            double theta = M_PI * j / n, phi = 2 * M_PI * i / around;
            double r = radius * (1 + bump * sin(9 * theta) * cos(11 * phi));
            *v++ = (float)(x + r * sin(theta) * cos(phi)), *v++ = (float)(r * cos(theta)),
            *v++ = (float)(r * sin(theta) * sin(phi));
        }
    }
    uint32_t top = vertices - 2, bottom = vertices - 1;
    v[0] = v[3] = (float)x, v[1] = (float)radius, v[4] = -(float)radius;
    for (unsigned i = 0; i < around; ++i) {
        uint32_t next = (i + 1) % around, last = around * (n - 2);
        *t++ = top, *t++ = next, *t++ = i;
        *t++ = bottom, *t++ = last + i, *t++ = last + next;
        for (unsigned j = 0; j + 2 < n; ++j) {
            uint32_t a = j * around + i, b = j * around + next, c = a + around, d = b + around;
            *t++ = a, *t++ = b, *t++ = c, *t++ = b, *t++ = d, *t++ = c;
        }
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = vertices;
    mesh.indices = index, mesh.triangle_count = (uint32_t)(t - index) / 3;
    mesh.flags = flags;
    fathom_id id;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, &id));
    return id;
}

/* A flat square [-1,1]² of 2 n² triangles at height z. */
static inline void add_grid(stage *s, unsigned n, double z) {
    float *p = unit_memory((n + 1) * (n + 1) * 3 * sizeof *p), *v = p;
    uint32_t *index = unit_memory((size_t)n * n * 6 * sizeof *index), *t = index;
    for (unsigned j = 0; j <= n; ++j) {
        for (unsigned i = 0; i <= n; ++i) {
            *v++ = -1 + 2 * (float)i / (float)n, *v++ = -1 + 2 * (float)j / (float)n, *v++ = (float)z;
        }
    }
    for (unsigned k = 0; k < n * n; ++k) {
        uint32_t a = k / n * (n + 1) + k % n, b = a + 1, c = a + n + 1, d = c + 1;
        *t++ = a, *t++ = b, *t++ = c, *t++ = b, *t++ = d, *t++ = c;
    }
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = (n + 1) * (n + 1);
    mesh.indices = index, mesh.triangle_count = 2 * n * n;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

static inline void add_sphere(stage *s, fathom_id group, double x, double y, double z, double r,
                              unsigned flags) {
    fathom_sphere sphere = default_sphere();
    sphere.center[0] = x, sphere.center[1] = y, sphere.center[2] = z, sphere.radius = r;
    sphere.flags = flags;
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, group, &sphere, NULL));
}

static inline void add_quad(stage *s, fathom_id group, const double center[3], const double u[3],
                            const double v[3], unsigned flags) {
    fathom_quad quad = default_quad();
    fathom_quad_from_axes(center, u, v, &quad);
    quad.flags = flags;
    assert_ok(s->context, fathom_scene_add_quad(s->scene, group, &quad, NULL));
}

static inline void add_plane(stage *s, double z, unsigned flags) {
    fathom_plane plane = default_plane();
    plane.point[2] = z, plane.flags = flags;
    assert_ok(s->context, fathom_scene_add_plane(s->scene, FATHOM_ROOT, &plane, NULL));
}

static inline void add_instance(stage *s, fathom_id group, const double m[12]) {
    fathom_instance instance = default_instance();
    instance.group = group;
    memcpy(instance.transform, m, sizeof instance.transform);
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

/* Every kind of shape, in the root and instanced, turned, squeezed and mirrored. */
static inline void add_everything(stage *s) {
    fathom_id group;
    assert_ok(s->context, fathom_scene_add_group(s->scene, "things", &group));
    add_ball(s, FATHOM_ROOT, 12, 0.05, 0.7, 0, 0);
    add_ball(s, group, 8, 0.1, 0.5, 0, 0);
    for (int i = 0; i < 12; ++i) {
        fathom_id where = i % 3 ? FATHOM_ROOT : group;
        double c[3] = {between(-2, 2), between(-2, 2), between(-2, 2)};
        add_sphere(s, where, c[0], c[1], c[2], between(0.05, 0.5), 0);
        double d[3] = {between(-2, 2), between(-2, 2), between(-2, 2)};
        double a = between(0, 6), u[3] = {0.4 * cos(a), 0.4 * sin(a), 0}, v[3] = {0, 0, between(0.1, 0.5)};
        add_quad(s, where, d, u, v, 0);
    }
    add_plane(s, -2.5, 0);
    const double maps[4][12] = {{0.5, 0, 0, 2, 0, 1.5, 0, 0, 0, 0, 0.2, 0.5},
                                {-1, 0, 0, -2, 0, 1, 0, 0.3, 0, 0, 1, 0},
                                {0.6, -0.8, 0, 0, 0.8, 0.6, 0.1, 1.8, 0, 0.2, 0.7, 0},
                                {1, 0.3, 0, 0, 0, 1, 0, -1.9, 0.1, 0, -1.1, 0.4}};
    for (int i = 0; i < 4; ++i) add_instance(s, group, maps[i]);
}

/* Three columns of a shadow caster below what casts none, in the root, instanced, and as a plane far below.
 */
static inline void add_shadow_columns(stage *s) {
    fathom_id group;
    assert_ok(s->context, fathom_scene_add_group(s->scene, "glass", &group));
    const double move[12] = {1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0};
    const double origin[3] = {0, 0, 0}, u[3] = {0.5, 0, 0}, v[3] = {0, 0.5, 0};
    add_sphere(s, FATHOM_ROOT, 0, 0, 0, 1, FATHOM_CASTS_NO_SHADOW);
    add_sphere(s, FATHOM_ROOT, 0, 3, 0, 1, 0);
    add_sphere(s, group, 0, 0, 0, 1, FATHOM_CASTS_NO_SHADOW);
    add_sphere(s, group, 0, 3, 0, 1, 0);
    add_ball(s, FATHOM_ROOT, 6, 0, 1, -4, FATHOM_CASTS_NO_SHADOW);
    add_quad(s, group, origin, u, v, FATHOM_CASTS_NO_SHADOW);
    add_instance(s, group, move);
    add_plane(s, -10, FATHOM_CASTS_NO_SHADOW);
}

/* ---- rays ---- */

typedef struct ray_set {
    size_t count;
    trace_block *blocks;
} ray_set;

static inline ray_set rays_new(size_t count) {
    ray_set set = {count, NULL};
    size_t bytes = (count + 15) / 16 * sizeof(trace_block);
    set.blocks = aligned_alloc(64, bytes);
    assert_non_null(set.blocks);
    memset(set.blocks, 0, bytes);
    unit_own(set.blocks, free);
    return set;
}

static inline void ray_set_to(ray_set *set, size_t i, const double org[3], const double dir[3], float t_far) {
    trace_rays *r = &set->blocks[i / 16].rays;
    size_t k = i % 16;
    r->org_x[k] = (float)org[0], r->org_y[k] = (float)org[1], r->org_z[k] = (float)org[2];
    r->dir_x[k] = (float)dir[0], r->dir_y[k] = (float)dir[1], r->dir_z[k] = (float)dir[2];
    r->t_near[k] = 0, r->t_far[k] = t_far;
}

static inline void ray_towards(ray_set *set, size_t i, const double org[3], const double target[3]) {
    double dir[3] = {target[0] - org[0], target[1] - org[1], target[2] - org[2]};
    ray_set_to(set, i, org, dir, INFINITY);
}

/* Sanitizers watch memory and conversions, which fewer rays reach as well. Odd counts stay odd: the last
 * block is partial. */
static inline size_t fewer(size_t count) {
#ifdef FATHOM_SANITIZED
    return count > 1000 ? count / 8 | (count & 7) : count;
#else
    return count;
#endif
}

/* From anywhere around the scene to anywhere in it. */
static inline ray_set random_rays(size_t count) {
    ray_set set = rays_new(count);
    for (size_t i = 0; i < count; ++i) {
        double org[3] = {between(-4, 4), between(-4, 4), between(-4, 4)};
        double target[3] = {between(-2, 2), between(-2, 2), between(-2, 2)};
        ray_towards(&set, i, org, target);
    }
    return set;
}

/* A pinhole's rays, row by row, through the square [-1,1]² at z = 0: many pass exactly through vertices. */
static inline ray_set camera_rays(size_t side) {
    ray_set set = rays_new(side * side);
    for (size_t i = 0; i < set.count; ++i) {
        double org[3] = {0, 0, 3};
        double target[3] = {-1 + 2 * (double)(i % side) / (double)side,
                            -1 + 2 * (double)(i / side) / (double)side, 0};
        ray_towards(&set, i, org, target);
    }
    return set;
}

/* From inside and outside at points on the edges of the world's meshes. */
static inline ray_set edge_rays(const world *w, size_t count) {
    ray_set set = rays_new(count);
    for (size_t i = 0; i < count; ++i) {
        const fathom_mesh *m = &w->meshes.items[(size_t)(uniform() * (double)w->meshes.count)];
        const uint32_t *t = &m->indices[3 * (size_t)(uniform() * m->triangle_count)];
        size_t c = (size_t)(uniform() * 3);
        const float *a = &m->positions[3 * (size_t)t[c]], *b = &m->positions[3 * (size_t)t[(c + 1) % 3]];
        double s = i % 8 ? uniform() : 0, target[3];
        for (int k = 0; k < 3; ++k) target[k] = (double)a[k] + s * ((double)b[k] - (double)a[k]);
        double reach = i % 2 ? 4 : 0.3;
        double org[3] = {between(-reach, reach), between(-reach, reach), between(-reach, reach)};
        ray_towards(&set, i, org, target);
    }
    return set;
}

/* Adds spheres with radii of 10^least to 1, and makes rays that graze them, from so many radii (powers of
 * ten) before the silhouette: hit or miss is decided by the intersector. */
static inline ray_set silhouette_rays(stage *s, size_t spheres, double least, size_t count, double nearest,
                                      double farthest) {
    double(*c)[4] = unit_memory(spheres * sizeof *c);
    for (size_t i = 0; i < spheres; ++i) {
        for (int k = 0; k < 3; ++k) c[i][k] = between(-10, 10);
        c[i][3] = pow(10, between(least, 0));
        add_sphere(s, FATHOM_ROOT, c[i][0], c[i][1], c[i][2], c[i][3], 0);
    }
    ray_set set = rays_new(count);
    for (size_t i = 0; i < count; ++i) {
        const double *sphere = c[i % spheres];
        vec3_f64 axis = normalize_f64(vec_f64(between(-1, 1), between(-1, 1), between(-1, 1)));
        vec3_f64 side =
            normalize_f64(cross_f64(axis, vec_f64(between(-1, 1), between(-1, 1), between(-1, 1))));
        if (i % 4 == 0) side = vec_f64(1, 0, 0), axis = vec_f64(0, 0.6, 0.8); /* along a face of the box */
        double off = sphere[3] * (1 + between(-1e-6, 1e-6));
        double back = sphere[3] * pow(10, between(nearest, farthest)), target[3], org[3];
        store_f64(target, madd_f64(load_f64(sphere), off, side));
        store_f64(org, madd_f64(load_f64(target), -back, axis));
        ray_towards(&set, i, org, target);
    }
    return set;
}

static inline ray_set rays_copy(const ray_set *set) {
    ray_set copy = rays_new(set->count);
    memcpy(copy.blocks, set->blocks, (set->count + 15) / 16 * sizeof *set->blocks);
    return copy;
}

static inline ray_set traced(const trace_tracer *tracer, const ray_set *set, trace_coherence coherence) {
    ray_set copy = rays_copy(set);
    unsigned state = trace_thread_begin();
    trace_closest(tracer, copy.blocks, copy.count, coherence);
    trace_thread_end(state);
    return copy;
}

/* 1: met, for each ray. */
static inline unsigned char *occluded(const trace_tracer *tracer, const ray_set *set,
                                      trace_coherence coherence) {
    size_t blocks = (set->count + 15) / 16;
    trace_rays *rays = aligned_alloc(64, blocks * sizeof *rays);
    unsigned char *met = malloc(set->count);
    assert_true(rays && met);
    for (size_t b = 0; b < blocks; ++b) rays[b] = set->blocks[b].rays;
    unsigned state = trace_thread_begin();
    trace_any(tracer, rays, set->count, coherence);
    trace_thread_end(state);
    for (size_t i = 0; i < set->count; ++i) met[i] = rays[i / 16].t_far[i % 16] == -INFINITY;
    free(rays);
    unit_own(met, free);
    return met;
}

static inline bool same_hit(const ray_set *a, const ray_set *b, size_t i) {
    const trace_hits *x = &a->blocks[i / 16].hits, *y = &b->blocks[i / 16].hits;
    size_t k = i % 16;
    if (x->geometry[k] != y->geometry[k]) return false;
    return x->geometry[k] == FATHOM_NONE ||
           (x->primitive[k] == y->primitive[k] && x->instance[k] == y->instance[k]);
}

static inline float hit_t(const ray_set *a, size_t i) { return a->blocks[i / 16].rays.t_far[i % 16]; }
