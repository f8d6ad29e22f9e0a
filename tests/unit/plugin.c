/* Tracers from shared libraries: one that is right, some with bugs, and some that do not keep the contract.
 */
#include "stage.h"

#define LIBRARY(name) PLUGIN_FOLDER "/" name ".so"

/* Hits and shadows of a library against the reference's in double: how many rays differ. */
static size_t differ(stage *s, const char *library, const ray_set *set) {
    trace_tracer *theirs = stage_spec(s, library), *ours = stage_spec(s, "linear:f64");
    ray_set t = traced(theirs, set, TRACE_COHERENT), o = traced(ours, set, TRACE_COHERENT);
    unsigned char *ta = occluded(theirs, set, TRACE_COHERENT), *oa = occluded(ours, set, TRACE_COHERENT);
    size_t count = 0;
    for (size_t i = 0; i < set->count; ++i) count += !same_hit(&t, &o, i) || ta[i] != oa[i];
    return count;
}

static void open_meshes(stage *s) {
    *s = stage_open();
    add_ball(s, FATHOM_ROOT, 10, 0.05, 1, 0, 0);
    add_ball(s, FATHOM_ROOT, 6, 0, 0.5, 2, FATHOM_CASTS_NO_SHADOW);
    add_ball(s, FATHOM_ROOT, 8, 0.1, 0.7, -2, 0);
    add_plane(s, -3, 0);
    stage_spec(s, "linear");
}

/* Random rays come within double's reach of an edge once in 10^12. */
UNIT_TEST(a_right_one_agrees) {
    stage s;
    open_meshes(&s);
    ray_set set = random_rays(5003);
    assert_int_equal(differ(&s, LIBRARY("correct"), &set), 0);
    trace_tracer *tracer = stage_spec(&s, LIBRARY("correct"));
    assert_string_equal(trace_name(tracer), "example: correct");
    assert_true(trace_unit(tracer) == 0x1p-53);
}

/* t in double arrives as it is; planes are answered in float beside it. */
UNIT_TEST(double_precision_arrives) {
    stage s;
    open_meshes(&s);
    ray_set set = random_rays(1600);
    trace_tracer *theirs = stage_spec(&s, LIBRARY("correct")), *ours = stage_spec(&s, "linear:f64");
    ray_set t = rays_copy(&set), o = rays_copy(&set);
    trace_fine *tf = unit_memory(100 * sizeof *tf), *of = unit_memory(100 * sizeof *of);
    trace_closest_fine(theirs, t.blocks, tf, 1600, TRACE_COHERENT);
    trace_closest_fine(ours, o.blocks, of, 1600, TRACE_COHERENT);
    size_t meshes = 0;
    for (size_t i = 0; i < 1600; ++i) {
        uint32_t geometry = o.blocks[i / 16].hits.geometry[i % 16];
        if (geometry == FATHOM_NONE) continue;
        double a = tf[i / 16].t[i % 16], b = of[i / 16].t[i % 16];
        /* 2^12 units are reached where the cosine is below 2^-9 (8 units over it): once in 2^18 rays. */
        assert_near(a, b, (geometry == TRACE_PLANE ? 0x1p-20 : 0x1p-41) * b);
        meshes += geometry != TRACE_PLANE;
    }
    assert_true(meshes > 300);
}

UNIT_TEST(bugs_show) {
    stage s;
    open_meshes(&s);
    /* From inside, half of all rays. */
    ray_set inside = rays_new(1000);
    for (size_t i = 0; i < inside.count; ++i) {
        const double org[3] = {0.1, 0.1, 0.1}, dir[3] = {between(-1, 1), between(-1, 1), between(-1, 1)};
        ray_set_to(&inside, i, org, dir, INFINITY);
    }
    size_t culls = differ(&s, LIBRARY("culls"), &inside);
    ray_set edges = edge_rays(s.world, 4000), random = random_rays(4000);
    assert_in_range(culls, 900, 1000);
    /* Rays aimed at edges in float pass within a millionth of them more often than not; random ones hardly.
     */
    assert_true(differ(&s, LIBRARY("gap"), &edges) > 400);
    assert_in_range(differ(&s, LIBRARY("gap"), &random), 0, 4);
}

static void refused(stage *s, const char *library, fathom_status status, const char *message) {
    stage_world(s);
    trace_spec spec;
    assert_ok(s->context, trace_spec_parse(s->context, library, &spec));
    trace_options options = {.spec = &spec, .threads = 1};
    trace_tracer *tracer = NULL;
    assert_fails(s->context, trace_create(s->context, s->world, &options, &tracer), status, message);
    assert_null(tracer);
}

UNIT_TEST(what_does_not_fit_is_refused) {
    stage s;
    open_meshes(&s);
    refused(&s, "no-such-file.so", FATHOM_BAD_INPUT, "tracer ./no-such-file.so: cannot be loaded");
    refused(&s, LIBRARY("empty"), FATHOM_BAD_INPUT, "has no function fathom_plugin_get()");
    refused(&s, LIBRARY("faulty"), FATHOM_BAD_INPUT, "is of version 0; expected 1");
    setenv("FATHOM_TEST_PLUGIN", "next", 1);
    refused(&s, LIBRARY("faulty"), FATHOM_BAD_INPUT, "is of version 2; expected 1");
    for (char hole[] = "no 0"; hole[3] <= '6'; ++hole[3]) {
        setenv("FATHOM_TEST_PLUGIN", hole, 1);
        refused(&s, LIBRARY("faulty"), FATHOM_BAD_INPUT, "its table is not complete");
    }
    setenv("FATHOM_TEST_PLUGIN", "mute", 1);
    refused(&s, LIBRARY("faulty"), FATHOM_BAD_INPUT, "tracer mute: cannot build: it gave no reason");
    setenv("FATHOM_TEST_PLUGIN", "fails", 1);
    refused(&s, LIBRARY("faulty"), FATHOM_BAD_INPUT, "tracer fails: cannot build: not today");
}

UNIT_TEST(other_shapes_are_refused) {
    static const char *const names[] = {"spheres", "quads", "instances", "points"};
    for (int i = 0; i < 4; ++i) {
        stage s = stage_open();
        add_ball(&s, FATHOM_ROOT, 6, 0, 1, 0, 0);
        const double c[3] = {0, 0, 0}, u[3] = {1, 0, 0}, v[3] = {0, 1, 0};
        const double move[12] = {1, 0, 0, 4, 0, 1, 0, 0, 0, 0, -1, 0};
        const fathom_id group = new_group(s.scene, "group");
        add_ball(&s, group, 6, 0, 1, 0, 0);
        if (i == 0) add_sphere(&s, FATHOM_ROOT, 0, 0, 0, 1, 0);
        if (i == 1) add_quad(&s, FATHOM_ROOT, c, u, v, 0);
        if (i == 2) add_instance(&s, group, move);
        fathom_mesh cloud = default_mesh();
        cloud.positions = (const float[]){0, 0, 0, 0, 0, 0, 0}, cloud.vertex_count = 1,
        cloud.point_radius = 1;
        if (i == 3) assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &cloud, NULL));
        refused(&s, LIBRARY("correct"), FATHOM_BAD_USAGE,
                unit_text("takes only triangles, and the scene has %s", names[i]));
    }
}

/* A triangle that does not exist is a miss, and lanes past the count stay. */
UNIT_TEST(wild_answers_do_no_harm) {
    stage s;
    open_meshes(&s);
    setenv("FATHOM_TEST_PLUGIN", "wild", 1);
    trace_tracer *tracer = stage_spec(&s, LIBRARY("faulty"));
    ray_set set = rays_new(16);
    memset(set.blocks, 0x5a, sizeof *set.blocks);
    const double org[3] = {0, 0, -2}, dir[3] = {0, 0, 1};
    for (size_t i = 0; i < 5; ++i) ray_set_to(&set, i, org, dir, INFINITY);
    set.blocks->rays.org_x[1] = NAN;
    trace_rays shadows = set.blocks->rays;
    trace_closest(tracer, set.blocks, 5, TRACE_COHERENT);
    trace_any(tracer, &shadows, 5, TRACE_COHERENT);
    for (size_t i = 0; i < 16; ++i) {
        assert_int_equal(set.blocks->hits.geometry[i], i < 5 ? FATHOM_NONE : 0x5a5a5a5a);
        if (i < 5) assert_true(shadows.t_far[i] == INFINITY);
    }
}

int main(void) { return unit_main(NULL, NULL); }
