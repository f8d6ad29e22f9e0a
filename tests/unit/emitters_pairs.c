/* Two triangles that are a quad send light as the quad does. */
#include "light/emitters_inner.h"
#include "unit_light.h"

static fathom_id glow(void) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_e[c] = 2;
    return new_material(scene, NULL, &m);
}

/* A second light, so that there is a choice. */
static void add_ball(void) {
    fathom_sphere s = default_sphere();
    s.center[0] = 3, s.center[2] = 2, s.radius = 0.5, s.material = glow();
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &s, NULL));
}

static void add_mesh(fathom_id group, const float *positions, uint32_t vertices, const uint32_t *indices,
                     uint32_t triangles) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = positions, mesh.vertex_count = vertices;
    mesh.indices = indices, mesh.triangle_count = triangles, mesh.material = glow();
    assert_ok(context, fathom_scene_add_mesh(scene, group, &mesh, NULL));
}

/* ---- samples ---- */

static void fill_points(random_state *r, emitter_query *q) {
    memset(q, 0, sizeof *q);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) q->p[c][i] = (float)random_in(r, -1, 1);
    }
}

enum { BLOCKS = 50 };

static void sample_all(emitter_sample out[BLOCKS]) {
    random_state r = {7};
    emitter_query q;
    lanes3 u;
    for (int b = 0; b < BLOCKS; ++b) {
        fill_points(&r, &q), fill_numbers(&r, u);
        memset(&out[b], 0, sizeof out[b]);
        emitters_sample(e, &q, u, &out[b]);
    }
}

static const uint32_t split[6] = {0, 1, 3, 2, 3, 1};

static void sample_square(bool mesh, bool alone, emitter_sample out[BLOCKS]) {
    fathom_quad q;
    float corners[4][3];
    fathom_quad_from_axes((double[]){0, 0.5, 2}, (double[]){1, 0, 0.25}, (double[]){0, 0.5, 0}, &q);
    q.material = glow();
    for (int k = 0; k < 12; ++k) corners[k / 3][k % 3] = (float)q.corners[k / 3][k % 3];
    if (mesh)
        add_mesh(FATHOM_ROOT, corners[0], 4, split, 2);
    else
        assert_ok(context, fathom_scene_add_quad(scene, FATHOM_ROOT, &q, NULL));
    if (!alone) add_ball();
    open_light();
    sample_all(out);
}

static void compare_squares(bool alone) {
    static emitter_sample mesh[BLOCKS], quad[BLOCKS];
    sample_square(true, alone, mesh);
    assert_int_equal(e->finite_count, alone ? 1 : 2);
    begin_light(NULL);
    sample_square(false, alone, quad);
    assert_memory_equal(mesh, quad, sizeof mesh);
}

UNIT_TEST(two_triangles_are_sampled_as_their_quad) { compare_squares(false); }
UNIT_TEST(a_single_light_of_two_triangles_is_sampled_as_a_quad) { compare_squares(true); }

/* The first pair of the mesh has no area in float, so the second is the only light. */
UNIT_TEST(the_only_pair_with_an_area_is_the_light) {
    static const float p[8][3] = {{0, 0, 2},       {1e-24f, 0, 2}, {1e-24f, 1e-24f, 2}, {0, 1e-24f, 2},
                                  {-1, -0.25f, 2}, {1, -0.25f, 2}, {1, 0.25f, 2},       {-1, 0.25f, 2}};
    static const uint32_t pairs[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
    static emitter_sample both[BLOCKS], one[BLOCKS];
    add_mesh(FATHOM_ROOT, p[0], 8, pairs, 4);
    open_light();
    sample_all(both);
    begin_light(NULL);
    add_mesh(FATHOM_ROOT, p[4], 4, pairs, 2);
    open_light();
    sample_all(one);
    for (int b = 0; b < BLOCKS; ++b) {
        assert_memory_equal(both[b].direction, one[b].direction, sizeof one[b].direction);
        assert_memory_equal(both[b].density, one[b].density, sizeof one[b].density);
    }
}

/* ---- densities ---- */

/* Two squares in one plane, and a place that turns, shears and stretches them. */
static const float squares[8][3] = {{-1, -1, 0},  {0, -1, 0}, {0, 0, 0}, {-1, 0, 0},
                                    {0.5f, 0, 0}, {1, 0, 0},  {1, 1, 0}, {0.5f, 1, 0}};
static const uint32_t halves[12] = {0, 1, 2, 0, 2, 3, 4, 5, 6, 4, 6, 7};
static const double map[12] = {0.6, -0.8, 0.1, 0.2, 0.8, 0.6, 0, 0.3, 0, 0.3, 2, 2.5};

static vec3_f64 placed(const float p[3]) {
    double at[3];
    for (int k = 0; k < 3; ++k)
        at[k] = map[4 * k] * (double)p[0] + map[4 * k + 1] * (double)p[1] + map[4 * k + 2] * (double)p[2] +
                map[4 * k + 3];
    return sub_f64(load_f64(at), w->origin);
}

/* The triangle that a ray hits well inside; 4: none. */
static uint32_t triangle_hit(vec3_f64 p, vec3_f64 to) {
    uint32_t found = 4;
    for (uint32_t k = 0; k < 4; ++k) {
        vec3_f64 c[3];
        for (int i = 0; i < 3; ++i) c[i] = sub_f64(placed(squares[halves[3 * k + (uint32_t)i]]), p);
        double least = INFINITY;
        const double way = dot_f64(c[0], cross_f64(c[1], c[2])) > 0 ? 1 : -1;
        for (int i = 0; i < 3; ++i) least = fmin(least, way * dot_f64(to, cross_f64(c[i], c[(i + 1) % 3])));
        if (least > 1e-4) found = k;
    }
    return found;
}

UNIT_TEST(hits_on_either_triangle_have_the_density_of_samples) {
    random_state r = {3};
    unsigned found[5] = {0};
    fathom_instance instance = default_instance();
    const fathom_id group = new_group(scene, NULL);
    add_mesh(group, squares[0], 8, halves, 4);
    instance.group = group;
    memcpy(instance.transform, map, sizeof map);
    assert_ok(context, fathom_scene_add_instance(scene, &instance, NULL));
    open_light();
    assert_int_equal(e->finite_count, 2);
    const emitter_run *run = emitters_run_of(e, 0);
    for (int b = 0; b < BLOCKS; ++b) {
        emitter_query q;
        emitter_sample s;
        lanes3 u;
        fill_points(&r, &q), fill_numbers(&r, u);
        emitters_sample(e, &q, u, &s);
        for (unsigned i = 0; i < LANES; ++i) {
            const vec3_f32 p = lane_f32(q.p, i), to = lane_f32(s.direction, i), none = {0, 0, 0};
            const uint32_t half = triangle_hit(widen(p), widen(to));
            ++found[half];
            if (half == 4) continue;
            const emitter_hit hit = {run->geometry, half, run->instance, 0, false};
            /* Both are products of a density and a chance, each rounded to float. */
            assert_near(emitters_hit_density(e, p, none, to, &hit), s.density[i],
                        4e-7 * (double)s.density[i]);
        }
    }
    for (int k = 0; k < 4; ++k) assert_true(found[k] > BLOCKS);
}

/* ---- what is a pair ---- */

typedef struct shape {
    const char *name;
    uint32_t vertices, triangles, emitters;
    float positions[6][3];
    uint32_t indices[12];
} shape;

static const shape shapes[] = {
    {"a quad", 4, 2, 1, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, {0, 1, 2, 0, 2, 3}},
    {"of opposite windings", 4, 2, 1, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}, {0, 1, 2, 0, 3, 2}},
    {"with vertices of their own",
     6,
     2,
     1,
     {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 0, 1}, {1, 1, 1}, {0, 1, 1}},
     {0, 1, 2, 3, 4, 5}},
    {"two quads",
     6,
     4,
     2,
     {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {2, 0, 1}, {2, 1, 1}},
     {0, 1, 2, 0, 2, 3, 1, 4, 5, 1, 5, 2}},
    {"folded", 4, 2, 2, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1.01f}}, {0, 1, 2, 0, 2, 3}},
    {"one on the other", 4, 2, 2, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0.9f, 0.5f, 1}}, {0, 1, 2, 0, 2, 3}},
    {"apart",
     6,
     2,
     2,
     {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {3, 0, 1}, {4, 1, 1}, {3, 1, 1}},
     {0, 1, 2, 3, 4, 5}},
    {"one of no area", 4, 2, 1, {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0.5f, 0.5f, 1}}, {0, 1, 2, 0, 2, 3}},
    {"a quad and a triangle",
     5,
     3,
     3,
     {{0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}, {2, 2, 1}},
     {0, 1, 2, 0, 2, 3, 2, 4, 3}},
};

UNIT_TEST(only_flat_quads_are_pairs) {
    for (size_t k = 0; k < sizeof shapes / sizeof *shapes; ++k) {
        const shape *s = &shapes[k];
        if (k) begin_light(NULL);
        add_mesh(FATHOM_ROOT, s->positions[0], s->vertices, s->indices, s->triangles);
        open_light();
        if (e->finite_count != s->emitters)
            fail_msg("%s: %u emitters, not %u", s->name, e->finite_count, s->emitters);
    }
}

int main(void) { return unit_main_each(begin_light, NULL); }
