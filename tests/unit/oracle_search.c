/* The exact search over a world against asking the oracle, in whole numbers, about every primitive. */
#include "random.h"
#include "trace/trace.h"
#include "verify/search/search.h"
#include "worlds.h"

UNIT_OWNS(search, search, search_destroy)

typedef struct fixture {
    fathom_context *context;
    fathom_scene *scene;
    world *world;
    search *search;
} fixture;

#define SIDE 12 /* of the grid of the mesh */

static float positions[(SIDE + 1) * (SIDE + 1) * 3 + 4];
static uint32_t indices[SIDE * SIDE * 6];

/* A wavy sheet over whole numbers, so that rays at its vertices and edges can be exact; a few corners spoilt.
 */
static void make_sheet(random_state *r) {
    for (int i = 0; i <= SIDE; ++i) {
        for (int k = 0; k <= SIDE; ++k) {
            float *p = &positions[3 * (i * (SIDE + 1) + k)];
            p[0] = (float)(i - SIDE / 2), p[1] = (float)(k - SIDE / 2), p[2] = (float)(random_bits(r) % 3);
        }
    }
    uint32_t *t = indices;
    for (uint32_t i = 0; i < SIDE; ++i) {
        for (uint32_t k = 0; k < SIDE; ++k, t += 6) {
            uint32_t a = i * (SIDE + 1) + k, b = a + SIDE + 1;
            const uint32_t two[6] = {a, b, a + 1, b + 1, a + 1, b};
            memcpy(t, two, sizeof two);
        }
    }
    t[-1] = t[-2]; /* without area */
}

static void add_shapes(fathom_scene *scene, fathom_id group, random_state *r) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.indices = indices;
    mesh.vertex_count = (SIDE + 1) * (SIDE + 1), mesh.triangle_count = 2 * SIDE * SIDE;
    assert_int_equal(fathom_scene_add_mesh_shared(scene, group, &mesh, NULL), FATHOM_OK);
    for (int i = 0; i < 20; ++i) {
        fathom_sphere sphere = default_sphere();
        for (int k = 0; k < 3; ++k) sphere.center[k] = floor(random_in(r, -6, 6));
        sphere.radius = i % 2 ? 1 : random_in(r, 0.01, 2), sphere.flags = i % 3 ? 0 : FATHOM_CASTS_NO_SHADOW;
        assert_int_equal(fathom_scene_add_sphere(scene, group, &sphere, NULL), FATHOM_OK);
        fathom_quad quad;
        const double u[3] = {1, 0, 0}, v[3] = {0, 1, 1};
        fathom_quad_from_axes(sphere.center, u, v, &quad);
        assert_int_equal(fathom_scene_add_quad(scene, group, &quad, NULL), FATHOM_OK);
        if (i == 0) assert_int_equal(fathom_scene_add_quad(scene, group, &quad, NULL), FATHOM_OK);
    }
}

static void add_instance(fathom_scene *scene, fathom_id group, const double rows[12]) {
    fathom_instance instance = default_instance();
    instance.group = group;
    memcpy(instance.transform, rows, sizeof instance.transform);
    assert_int_equal(fathom_scene_add_instance(scene, &instance, NULL), FATHOM_OK);
}

static int set_up(void **state) {
    fixture *f = unit_memory(sizeof *f);
    random_state r = {1};
    make_sheet(&r);
    f->context = new_context(), f->scene = new_scene(f->context);
    add_shapes(f->scene, FATHOM_ROOT, &r);
    const fathom_id group = new_group(f->scene, "part");
    add_shapes(f->scene, group, &r);
    const double turned[12] = {0, -0.6, 0.8, 3, 1, 0, 0, 4, 0, 0.8, 0.6, 5};
    const double flat[12] = {2, 0, 0, -1, 0, 2, 0, 0, 0, 0, -0x1p-20, 7};
    add_instance(f->scene, group, turned);
    add_instance(f->scene, group, flat);
    add_instance(f->scene, group, turned); /* everything in them twice */
    add_instance(f->scene, group, flat);
    fathom_plane plane = default_plane();
    plane.point[2] = -9;
    assert_ok(f->context, fathom_scene_add_plane(f->scene, FATHOM_ROOT, &plane, NULL));
    f->world = new_world(f->scene);
    positions[5] = NAN, positions[3 * 40] = INFINITY; /* behind the scene's back, which refuses them */
    assert_ok(f->context, search_create(f->context, f->world, &f->search));
    own_search(f->search);
    *state = f;
    return 0;
}

/* ---- the plain way ---- */

typedef struct brute {
    const world *world;
    const oracle_ray *ray;
    oracle_pair best;
    bool hit, shadow;
    int ties;
} brute;

static void try_primitive(brute *b, uint32_t geometry, uint32_t primitive, uint32_t instance,
                          unsigned flags) {
    oracle_pair pair = {.primitive = search_primitive(b->world, geometry, primitive, instance)};
    oracle_ask(b->ray, &pair.primitive, &pair.answer);
    if (!pair.answer.hit) return;
    b->shadow |= !(flags & FATHOM_CASTS_NO_SHADOW);
    int order = b->hit ? oracle_compare(b->ray, &pair, &b->best) : -1;
    if (order > 0) return;
    b->ties = order ? 1 : b->ties + 1;
    if (order) b->best = pair;
    b->hit = true;
}

static void try_group(brute *b, uint32_t group, uint32_t instance) {
    const world *w = b->world;
    for (uint32_t g = 0; g < w->groups.items[group].count; ++g) {
        uint32_t geometry = w->groups.items[group].first + g;
        const world_geometry *all = &w->geometries.items[geometry];
        for (uint32_t p = 0; p < all->count; ++p) try_primitive(b, geometry, p, instance, all->flags);
    }
}

static brute try_all(const world *w, const oracle_ray *ray) {
    brute b = {.world = w, .ray = ray};
    try_group(&b, 0, FATHOM_NONE);
    for (uint32_t k = 0; k < w->instances.count; ++k) try_group(&b, w->instances.items[k].group, k);
    for (uint32_t p = 0; p < w->planes.count; ++p) {
        try_primitive(&b, TRACE_PLANE, p, FATHOM_NONE, w->planes.items[p].flags);
    }
    return b;
}

/* Half of them on whole numbers, where edges, vertices, tangents and interval ends are met exactly. */
static oracle_ray ray_of(random_state *r, int i) {
    oracle_ray ray = {.t_near = 0, .t_far = INFINITY};
    float *org = &ray.org.x, *dir = &ray.dir.x;
    for (int k = 0; k < 3; ++k) {
        double target = random_in(r, -7, 7);
        org[k] = (float)random_in(r, -12, 12);
        dir[k] = (float)((target - (double)org[k]) * 0.5);
        if (i % 2) org[k] = floorf(org[k]), dir[k] = (float)((int)(random_bits(r) % 3) - 1);
    }
    if (dir[0] == 0 && dir[1] == 0 && dir[2] == 0) dir[2] = -1;
    if (i % 4 == 1) ray.t_near = 2, ray.t_far = 9;
    if (i % 64 == 2) ray.dir = scale_f32(0x1p-120f, ray.dir); /* t beyond float's range */
    return ray;
}

UNIT_TEST(it_finds_what_asking_everything_finds) {
    fixture *f = *state;
    random_state r = {2};
    search_result result = {0};
    int hits = 0, ties = 0;
    for (int i = 0; i < 200; ++i) {
        oracle_ray ray = ray_of(&r, i);
        brute all = try_all(f->world, &ray);
        assert_true(search_closest(f->search, &ray, &result));
        if (result.ties.count != (size_t)all.ties) {
            fail_msg("ray %d: %zu ties, expected %d (t %.17g)", i, result.ties.count, all.ties,
                     (double)all.best.answer.t);
        }
        for (size_t k = 0; k < result.ties.count; ++k) {
            const search_hit *hit = &result.ties.items[k];
            oracle_pair pair = {search_primitive(f->world, hit->geometry, hit->primitive, hit->instance),
                                hit->answer};
            assert_int_equal(0, oracle_compare(&ray, &pair, &all.best));
        }
        hits += all.hit, ties += all.ties > 1;
        assert_true(search_shadow(f->search, &ray, &result));
        assert_int_equal(result.ties.count > 0, all.shadow);
    }
    assert_true(hits > 80 && ties > 20);
    print_message("200 rays, closest and any: %d hits, %d with ties\n", hits, ties);
    search_result_free(&result);
}

/* The reference tracer answers in float: it must be one of the ties, or off by no more than float is. */
UNIT_TEST(the_reference_tracer_finds_it_too) {
    fixture *f = *state;
    trace_options options = {.words = "reference"};
    trace_tracer *tracer;
    assert_ok(f->context, trace_create(f->context, f->world, &options, &tracer));
    random_state r = {3};
    search_result result = {0};
    int same = 0, hits = 0;
    for (int i = 0; i < 2000; ++i) {
        oracle_ray ray = ray_of(&r, 4 * i);
        static trace_block block;
        block.rays.org_x[0] = ray.org.x, block.rays.org_y[0] = ray.org.y, block.rays.org_z[0] = ray.org.z;
        block.rays.dir_x[0] = ray.dir.x, block.rays.dir_y[0] = ray.dir.y, block.rays.dir_z[0] = ray.dir.z;
        block.rays.t_near[0] = ray.t_near, block.rays.t_far[0] = ray.t_far;
        trace_closest(tracer, &block, 1, TRACE_INCOHERENT);
        assert_true(search_closest(f->search, &ray, &result));
        const trace_hits *h = &block.hits;
        bool found = result.ties.count == 0 && h->geometry[0] == FATHOM_NONE;
        for (size_t k = 0; k < result.ties.count; ++k) {
            const search_hit *hit = &result.ties.items[k];
            found |= hit->geometry == h->geometry[0] && hit->primitive == h->primitive[0];
        }
        same += found, hits += result.ties.count > 0;
    }
    assert_true(hits > 1000);
    /* Rays at random come within 2^-20 of an edge, a silhouette or another surface once in thousands. */
    assert_in_range(same, 1990, 2000);
    search_result_free(&result);
    trace_destroy(tracer);
}

int main(void) { return unit_main(set_up, NULL); }
