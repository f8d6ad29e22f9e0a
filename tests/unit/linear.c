/* The reference tracer: linear search, instances, planes, and what blocks of rays are promised. */
#include "random.h"
#include "reference/reference.h"
#include "trace/trace.h"
#include "worlds.h"

#include <float.h>

UNIT_OWNS(tracer, trace_tracer, trace_destroy)

typedef struct fixture {
    fathom_context *context;
    fathom_scene *scene;
    world *world;
    trace_tracer *tracer;
} fixture;

static fixture begin(void) {
    fixture f = {.context = new_context()};
    f.scene = new_scene(f.context);
    return f;
}

static void build(fixture *f) {
    trace_options options = {.words = "reference", .width = 16, .threads = 1};
    f->world = new_world(f->scene);
    assert_ok(f->context, trace_create(f->context, f->world, &options, &f->tracer));
    own_tracer(f->tracer);
    assert_string_equal(trace_name(f->tracer), "reference");
}

static void add_sphere(fixture *f, fathom_id group, double x, double y, double z, double radius,
                       unsigned flags) {
    fathom_sphere sphere = default_sphere();
    fathom_id id;
    sphere.center[0] = x, sphere.center[1] = y, sphere.center[2] = z;
    sphere.radius = radius, sphere.flags = flags;
    assert_ok(f->context, fathom_scene_add_sphere(f->scene, group, &sphere, &id));
}

static void add_plane(fixture *f, double z, unsigned flags) {
    fathom_plane plane = default_plane();
    fathom_id id;
    plane.point[2] = z, plane.flags = flags;
    assert_ok(f->context, fathom_scene_add_plane(f->scene, FATHOM_ROOT, &plane, &id));
}

static fathom_id add_mesh(fixture *f, fathom_id group, const float *positions, uint32_t vertices,
                          const uint32_t *indices, uint32_t triangles, size_t stride) {
    fathom_mesh mesh = default_mesh();
    fathom_id id;
    mesh.positions = positions, mesh.vertex_count = vertices, mesh.position_stride = stride;
    mesh.indices = indices, mesh.triangle_count = triangles;
    assert_ok(f->context, fathom_scene_add_mesh_shared(f->scene, group, &mesh, &id));
    return id;
}

static void add_instance(fixture *f, fathom_id group, const double transform[12]) {
    fathom_instance instance = default_instance();
    fathom_id id;
    instance.group = group, instance.parent = FATHOM_ROOT;
    memcpy(instance.transform, transform, sizeof instance.transform);
    assert_ok(f->context, fathom_scene_add_instance(f->scene, &instance, &id));
}

static void set_ray(trace_rays *rays, unsigned lane, vec3_f32 org, vec3_f32 dir, float t_near, float t_far) {
    rays->org_x[lane] = org.x, rays->org_y[lane] = org.y, rays->org_z[lane] = org.z;
    rays->dir_x[lane] = dir.x, rays->dir_y[lane] = dir.y, rays->dir_z[lane] = dir.z;
    rays->t_near[lane] = t_near, rays->t_far[lane] = t_far;
    rays->time[lane] = 0, rays->mask[lane] = UINT32_MAX, rays->id[lane] = lane, rays->flags[lane] = 0;
}

/* ---- a scene of everything ---- */

#define VERTICES 60
#define TRIANGLES 40

static float strided[VERTICES * 5 + 8], tight[VERTICES * 3 + 8];
static uint32_t indices[TRIANGLES * 3];

static const double mirrored[12] = {-2, 0.3, 0, 1, 0, 0.5, 0.1, -1, 0.2, 0, 1.5, 0.5};
static const double turned[12] = {0, -1, 0, -2, 1, 0, 0, 1, 0, 0, 1, 0};

static fixture everything(random_state *r) {
    fixture f = begin();
    for (int i = 0; i < VERTICES * 5; ++i) strided[i] = (float)random_in(r, -2, 2);
    for (int i = 0; i < VERTICES * 3; ++i) tight[i] = (float)random_in(r, -2, 2);
    for (int i = 0; i < TRIANGLES * 3; ++i) indices[i] = (uint32_t)(random_bits(r) % VERTICES);
    const fathom_id group = new_group(f.scene, "group");
    for (fathom_id where = FATHOM_ROOT;; where = group) {
        add_sphere(&f, where, 1, 0, 0.5, 0.7, 0);
        add_sphere(&f, where, -1, 0.4, 0, 0.4, 0);
        fathom_quad quad;
        fathom_id id;
        const double center[3] = {0, 0.3, -0.4}, u[3] = {0.8, 0.1, 0}, v[3] = {0, 0.2, 0.9};
        fathom_quad_from_axes(center, u, v, &quad);
        assert_ok(f.context, fathom_scene_add_quad(f.scene, where, &quad, &id));
        add_mesh(&f, where, strided, VERTICES, indices, TRIANGLES, 20);
        if (where == group) break;
        add_mesh(&f, where, tight, VERTICES, indices, TRIANGLES, 0);
    }
    add_instance(&f, group, mirrored);
    add_instance(&f, group, turned);
    add_plane(&f, -3, 0);
    build(&f);
    assert_int_equal(f.world->instances.count, 2);
    return f;
}

/* What one ray meets, one primitive at a time. */
typedef struct lone_hit {
    float t, u, v;
    uint32_t instance, geometry, primitive;
} lone_hit;

static bool meets(const world *w, const world_geometry *g, uint32_t k, vec3_f32 org, vec3_f32 dir,
                  float t_max, reference_hit_f32 *hit) {
    hit->u = hit->v = 0;
    if (g->kind == WORLD_SPHERES) {
        const world_sphere *s = &w->spheres.items[g->first + k];
        return sphere_robust_f32(s->center, s->radius, org, dir, 0, t_max, &hit->t);
    }
    if (g->kind == WORLD_QUADS) {
        const vec3_f32 *v = w->quads.items[g->first + k].corner;
        return quad_robust_f32(v[0], v[1], v[2], v[3], org, dir, 0, t_max, hit);
    }
    const fathom_mesh *mesh = &w->meshes.items[g->first];
    const size_t floats = mesh->position_stride ? mesh->position_stride / 4 : 3;
    const uint32_t *i = mesh->indices + 3 * k;
    return triangle_robust_f32(load_f32(mesh->positions + i[0] * floats),
                               load_f32(mesh->positions + i[1] * floats),
                               load_f32(mesh->positions + i[2] * floats), org, dir, 0, t_max, hit);
}

static void search_group(const world *w, uint32_t group, uint32_t instance, vec3_f32 org, vec3_f32 dir,
                         lone_hit *best) {
    for (uint32_t g = 0; g < w->groups.items[group].count; ++g) {
        uint32_t geometry = w->groups.items[group].first + g;
        for (uint32_t k = 0; k < w->geometries.items[geometry].count; ++k) {
            reference_hit_f32 hit;
            if (!meets(w, &w->geometries.items[geometry], k, org, dir, best->t, &hit)) continue;
            *best = (lone_hit){hit.t, hit.u, hit.v, instance, geometry, k};
        }
    }
}

static float row_times(const float row[4], vec3_f32 p, double w) {
    return (float)((double)row[0] * (double)p.x + (double)row[1] * (double)p.y +
                   (double)row[2] * (double)p.z + (double)row[3] * w);
}

static lone_hit search(const world *w, vec3_f32 org, vec3_f32 dir) {
    lone_hit best = {INFINITY, 0, 0, FATHOM_NONE, FATHOM_NONE, 0};
    search_group(w, 0, FATHOM_NONE, org, dir, &best);
    for (size_t k = 0; k < w->instances.count; ++k) {
        const float(*m)[4] = w->instances.items[k].to_object;
        vec3_f32 o = {row_times(m[0], org, 1), row_times(m[1], org, 1), row_times(m[2], org, 1)};
        vec3_f32 d = {row_times(m[0], dir, 0), row_times(m[1], dir, 0), row_times(m[2], dir, 0)};
        search_group(w, w->instances.items[k].group, (uint32_t)k, o, d, &best);
    }
    for (size_t k = 0; k < w->planes.count; ++k) {
        const world_plane *p = &w->planes.items[k];
        float t;
        if (!plane_robust_f32(p->point, p->normal, org, dir, 0, best.t, &t)) continue;
        best = (lone_hit){t, 0, 0, FATHOM_NONE, TRACE_PLANE, (uint32_t)k};
    }
    return best;
}

/* A block answers what its rays would each alone, one primitive after the other, to the last bit. */
UNIT_TEST(blocks_are_single_rays) {
    random_state r = {1};
    fixture f = everything(&r);
    int seen[4] = {0};
    for (int round = 0; round < 2000; ++round) {
        static trace_block blocks[2];
        vec3_f32 org[32], dir[32];
        const size_t count = 17 + (size_t)(round % 16);
        for (unsigned i = 0; i < 32; ++i) {
            org[i] = vec_f32((float)random_in(&r, -6, 6), (float)random_in(&r, -6, 6),
                             (float)random_in(&r, -2.9, 6));
            dir[i] = vec_f32((float)random_in(&r, -1, 1), (float)random_in(&r, -1, 1),
                             (float)random_in(&r, -1, 1));
            if (round % 3 == 0) dir[i] = sub_f32(vec_f32(0, 0, 0), org[i]);
            set_ray(&blocks[i / 16].rays, i % 16, org[i], dir[i], 0, INFINITY);
        }
        trace_rays shadows[2] = {blocks[0].rays, blocks[1].rays};
        trace_closest(f.tracer, blocks, count, TRACE_INCOHERENT);
        trace_any(f.tracer, shadows, count, TRACE_INCOHERENT);
        for (unsigned i = 0; i < count; ++i) {
            const trace_rays *rays = &blocks[i / 16].rays;
            const trace_hits *hits = &blocks[i / 16].hits;
            const unsigned l = i % 16;
            lone_hit alone = search(f.world, org[i], dir[i]);
            assert_true(rays->t_far[l] == alone.t);
            assert_int_equal(hits->geometry[l], alone.geometry);
            assert_true(shadows[i / 16].t_far[l] == (alone.geometry == FATHOM_NONE ? INFINITY : -INFINITY));
            if (alone.geometry == FATHOM_NONE) continue;
            assert_int_equal(hits->primitive[l], alone.primitive);
            assert_int_equal(hits->instance[l], alone.instance);
            assert_true(hits->u[l] == alone.u && hits->v[l] == alone.v);
            ++seen[alone.geometry == TRACE_PLANE ? 3 : (int)f.world->geometries.items[alone.geometry].kind];
        }
    }
    for (int k = 0; k < 4; ++k) assert_true(seen[k] > 100);
}

/* An ellipsoid, mirrored and sheared: the point at t, in world space, is on it, whatever the direction's
 * length. */
UNIT_TEST(t_keeps_its_meaning) {
    random_state r = {2};
    fixture f = begin();
    const fathom_id group = new_group(f.scene, "group");
    add_sphere(&f, group, 0, 0, 0, 1, 0);
    add_instance(&f, group, mirrored);
    build(&f);
    for (int round = 0; round < 500; ++round) {
        trace_block block;
        vec3_f64 org[16], dir[16];
        const world_instance *instance = &f.world->instances.items[0];
        for (unsigned i = 0; i < 16; ++i) {
            vec3_f32 o = {(float)random_in(&r, 4, 6), (float)random_in(&r, -4, 4),
                          (float)random_in(&r, -4, 4)};
            /* At the centre, which lies at the map's translation. */
            vec3_f32 d = scale_f32((float)random_log(&r, 1e-10, 1e10), sub_f32(vec_f32(1, -1, 0.5f), o));
            org[i] = widen(o), dir[i] = widen(d);
            set_ray(&block.rays, i, o, d, 0, INFINITY);
        }
        trace_closest(f.tracer, &block, 16, TRACE_COHERENT);
        for (unsigned i = 0; i < 16; ++i) {
            assert_int_equal(block.hits.instance[i], 0);
            vec3_f64 p = madd_f64(org[i], (double)block.rays.t_far[i], dir[i]), q;
            double *to = &q.x;
            for (int k = 0; k < 3; ++k) {
                const float *m = instance->to_object[k];
                to[k] = (double)m[0] * p.x + (double)m[1] * p.y + (double)m[2] * p.z + (double)m[3];
            }
            /* In object space the origin is up to 15 away; ray and t carry a few roundings each of that, and
             * the ray meets the sphere head on. */
            assert_near(length_f64(q), 1, 16 * 15 * 0x1p-24);
        }
    }
}

/* ---- ties, shadows, lanes ---- */

static const float wall[12 + 4] = {-1, -1, 0, 3, -1, 0, -1, 3, 0, 9, 9, 9};

UNIT_TEST(equal_t_goes_to_the_first) {
    static const uint32_t twice[9] = {0, 3, 3, 0, 1, 2, 0, 1, 2};
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    fixture f = begin();
    const fathom_id group = new_group(f.scene, "group");
    add_mesh(&f, group, wall, 4, twice + 3, 2, 0);
    add_instance(&f, group, identity);
    add_instance(&f, group, identity);
    fathom_id first = add_mesh(&f, FATHOM_ROOT, wall, 4, twice, 3, 0);
    add_mesh(&f, FATHOM_ROOT, wall, 4, twice + 3, 1, 0);
    add_plane(&f, 0, 0);
    add_plane(&f, 0, 0);
    build(&f);
    trace_block block;
    set_ray(&block.rays, 0, vec_f32(0, 0, 2), vec_f32(0, 0, -1), 0, INFINITY);
    set_ray(&block.rays, 1, vec_f32(50, 0, 2), vec_f32(0, 0, -1), 0, INFINITY); /* beside the triangles */
    trace_closest(f.tracer, &block, 2, TRACE_COHERENT);
    assert_true(block.rays.t_far[0] == 2 && block.rays.t_far[1] == 2);
    assert_int_equal(block.hits.instance[0], FATHOM_NONE);
    assert_int_equal(world_object(f.world, block.hits.geometry[0], block.hits.primitive[0]), first);
    assert_int_equal(block.hits.primitive[0], 1); /* the one before it has no area */
    assert_int_equal(block.hits.geometry[1], TRACE_PLANE);
    assert_int_equal(block.hits.primitive[1], 0);
}

UNIT_TEST(first_instance_wins) {
    static const uint32_t one[3] = {0, 1, 2};
    static const double nearer[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.5};
    fixture f = begin();
    const fathom_id group = new_group(f.scene, "group");
    add_mesh(&f, group, wall, 4, one, 1, 0);
    add_mesh(&f, FATHOM_ROOT, wall, 4, one, 1, 0);
    for (int i = 0; i < 3; ++i) add_instance(&f, group, i ? nearer : mirrored);
    build(&f);
    assert_int_equal(f.world->instances.count, 3);
    trace_block block;
    set_ray(&block.rays, 0, vec_f32(0, 0, 0.75f), vec_f32(0, 0, -1), 0, INFINITY);
    trace_closest(f.tracer, &block, 1, TRACE_COHERENT);
    assert_true(block.rays.t_far[0] == 0.25f);
    assert_int_equal(block.hits.instance[0], 1);
}

UNIT_TEST(shadows_pass_what_casts_none) {
    fixture f = begin();
    add_sphere(&f, FATHOM_ROOT, 0, 0, 0, 1, FATHOM_CASTS_NO_SHADOW);
    add_sphere(&f, FATHOM_ROOT, 10, 0, 0, 1, 0);
    add_plane(&f, -5, FATHOM_CASTS_NO_SHADOW);
    build(&f);
    trace_block block;
    for (unsigned i = 0; i < 3; ++i) {
        set_ray(&block.rays, i, vec_f32(5 * (float)i, 0, 3), vec_f32(0, 0, -1), 0, INFINITY);
    }
    trace_rays shadows = block.rays;
    trace_closest(f.tracer, &block, 3, TRACE_COHERENT);
    assert_true(block.rays.t_far[0] == 2 && block.rays.t_far[1] == 8 && block.rays.t_far[2] == 2);
    trace_any(f.tracer, &shadows, 3, TRACE_COHERENT);
    assert_true(shadows.t_far[0] == INFINITY && shadows.t_far[1] == INFINITY &&
                shadows.t_far[2] == -INFINITY);
}

UNIT_TEST(lanes_out_of_use_stay) {
    fixture f = begin();
    add_sphere(&f, FATHOM_ROOT, 0, 0, 0, 1, 0);
    add_plane(&f, -5, 0);
    build(&f);
    trace_block block, before;
    memset(&block, 0x5a, sizeof block);
    for (unsigned i = 0; i < 16; ++i)
        set_ray(&block.rays, i, vec_f32(0, 0, 3), vec_f32(0, 0, -1), 0, INFINITY);
    block.rays.t_far[1] = -INFINITY;                        /* done before */
    block.rays.t_near[2] = 2.5f, block.rays.t_far[2] = 3.5; /* inside the sphere */
    block.rays.t_near[3] = 4, block.rays.t_far[3] = 8; /* between the sphere and the plane, both excluded */
    before = block;
    trace_closest(f.tracer, &block, 5, TRACE_COHERENT);
    assert_true(block.rays.t_far[0] == 2 && block.rays.t_far[4] == 2);
    for (unsigned i = 1; i < 4; ++i) {
        assert_int_equal(block.hits.geometry[i], FATHOM_NONE);
        assert_true(block.rays.t_far[i] == before.rays.t_far[i]);
    }
    for (unsigned i = 5; i < 16; ++i) {
        assert_true(block.rays.t_far[i] == INFINITY);
        assert_int_equal(block.hits.geometry[i], 0x5a5a5a5a);
    }
    trace_rays shadows = before.rays;
    trace_any(f.tracer, &shadows, 5, TRACE_COHERENT);
    assert_true(shadows.t_far[0] == -INFINITY && shadows.t_far[2] == 3.5f && shadows.t_far[3] == 8);
    assert_true(shadows.t_far[5] == INFINITY);
    trace_any(f.tracer, &shadows, 0, TRACE_COHERENT);
}

UNIT_TEST(triangles_that_are_none_are_skipped) {
    static const uint32_t some[12] = {3, 1, 2, 0, 0, 1, 0, 1, 2, 0, 1, 3};
    float vertices[16];
    memcpy(vertices, wall, sizeof vertices);
    fixture f = begin();
    add_mesh(&f, FATHOM_ROOT, vertices, 4, some, 4, 0);
    vertices[9] = NAN, vertices[10] = INFINITY;
    build(&f);
    trace_block block;
    for (unsigned i = 0; i < 16; ++i) {
        set_ray(&block.rays, i, vec_f32((float)i / 16 - 1, -1, 2), vec_f32(0, 0, -1), 0, INFINITY);
    }
    trace_closest(f.tracer, &block, 16, TRACE_COHERENT);
    for (unsigned i = 0; i < 16; ++i) {
        assert_true(block.rays.t_far[i] == 2);
        assert_int_equal(block.hits.primitive[i], 2);
    }
}

UNIT_TEST(threads_flush_denormals_and_restore) {
    volatile float small = FLT_MIN, half = 0.5f;
    unsigned before = trace_thread_begin();
    volatile float flushed = small * half;
    trace_thread_end(before);
    volatile float kept = small * half;
    assert_true(kept > 0);
#if defined(__SSE2__)
    assert_true(flushed == 0);
#else
    (void)flushed;
#endif
}

int main(void) { return unit_main(NULL, NULL); }
