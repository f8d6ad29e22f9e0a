/* What Embree builds and how calls behave at their edges: masks, empty and damaged geometry, interruption,
 * intervals, lanes, and that no call hangs. */
#include "stage.h"
#include "trace/embree/embree_limits.h"

#include <signal.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

static const unsigned widths[] = {1, 4, 8, 16};

/* Rays from which on the build is better than low: more rays never ask for less. */
static uint64_t rays_worth_more(const world *w) {
    uint64_t rays = 1;
    while (trace_quality_auto(rays, w) == TRACE_QUALITY_LOW && rays < UINT64_C(1) << 50) rays += rays / 2 + 1;
    for (uint64_t more = rays; more < UINT64_C(1) << 60; more *= 2)
        assert_int_equal(trace_quality_auto(more, w), TRACE_QUALITY_MEDIUM);
    return rays;
}

/* The more there is to build, the more rays it takes. */
UNIT_TEST(quality_follows_the_rays) {
    uint64_t before = 1;
    for (uint32_t count = 100; count <= 100000000; count *= 10) {
        world_geometry mesh = {.kind = WORLD_MESH, .count = count};
        const world w = {.geometries = {&mesh, 1, 1}};
        uint64_t rays = rays_worth_more(&w);
        assert_true(rays > before);
        assert_int_equal(trace_quality_auto(0, &w), TRACE_QUALITY_MEDIUM);
        before = rays;
    }
}

/* One ray from (x, y, 5) down z. */
static ray_set ray_down(double x, double y) {
    ray_set set = rays_new(1);
    const double org[3] = {x, y, 5}, dir[3] = {0, 0, -1};
    ray_set_to(&set, 0, org, dir, INFINITY);
    return set;
}

static bool blocked(const trace_tracer *tracer, double x, double y) {
    ray_set set = ray_down(x, y);
    unsigned char *any = occluded(tracer, &set, TRACE_COHERENT);
    bool met = any[0];
    return met;
}

/* The t of the closest hit, or infinity. */
static float depth(const trace_tracer *tracer, double x, double y) {
    ray_set set = ray_down(x, y), got = traced(tracer, &set, TRACE_COHERENT);
    float t = hit_t(&got, 0);
    return t;
}

/* A ray along the normal meets Embree's triangle at t up to 8 units of roundoff: its reciprocal starts from
 * an estimate off by 1.5 2^-12, so a Newton step leaves 2.25 units and rounds three times, and the products
 * for t round twice more. Some instruction sets do better, none has to. */
static bool triangle_at(float t, float expected) { return fabsf(t - expected) <= 0x1p-21f * expected; }

UNIT_TEST(shadows_pass_what_casts_none) {
    stage s = stage_open();
    add_shadow_columns(&s);
    for (size_t i = 0; i < 4; ++i) {
        trace_tracer *tracer = stage_embree(&s, widths[i]);
        assert_true(!blocked(tracer, 0, 0) && depth(tracer, 0, 0) == 4);
        assert_true(blocked(tracer, 0, 3) && depth(tracer, 0, 3) == 4);
        assert_true(!blocked(tracer, 4, 0) && depth(tracer, 4, 0) == 4);
        assert_true(blocked(tracer, 4, 3) && depth(tracer, 4, 3) == 4);
        assert_true(!blocked(tracer, -4, 0.1) && depth(tracer, -4, 0.1) < 4.5f);
        assert_true(!blocked(tracer, 9, 9) && depth(tracer, 9, 9) == 15);
    }
}

UNIT_TEST(nothing_to_hit) {
    stage s = stage_open();
    const fathom_id group = new_group(s.scene, "empty");
    const double identity[12] = {2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    add_instance(&s, group, identity);
    for (size_t i = 0; i < 4; ++i) {
        trace_tracer *tracer = stage_embree(&s, widths[i]);
        assert_true(depth(tracer, 0, 0) == INFINITY && !blocked(tracer, 0, 0));
    }
    add_plane(&s, 1, 0);
    s.world = NULL;
    trace_tracer *tracer = stage_embree(&s, 16);
    assert_true(depth(tracer, 0, 0) == 4 && blocked(tracer, 0, 0));
}

/* Triangles 0 and 1 are good, the others hold a NaN, an infinity, a number too large for Embree, or no area.
 */
UNIT_TEST(damaged_triangles_are_left_out) {
    static float p[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, 0, 0,
                        1,  0,  0, 2, 0,  0, 3, 0, 0, 0,  0, 0, 0, 0};
    static const uint32_t t[] = {0, 1, 2, 2, 3, 0, 0, 1, 4, 1, 2, 5, 2, 3, 6, 0, 0, 1, 0, 2, 0};
    stage s = stage_open();
    fathom_mesh mesh = default_mesh();
    mesh.positions = p, mesh.vertex_count = 7, mesh.indices = t, mesh.triangle_count = 7;
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
    p[3 * 4] = NAN, p[3 * 5 + 1] = INFINITY, p[3 * 6 + 2] = 1e30f;
    for (size_t i = 0; i < 4; ++i) {
        trace_tracer *tracer = stage_embree(&s, widths[i]);
        assert_true(triangle_at(depth(tracer, 0.5, 0.25), 5) && triangle_at(depth(tracer, -0.5, 0.25), 5));
        assert_true(depth(tracer, 3, 3) == INFINITY);
    }
    /* Nothing but damage is an empty scene, not a failure. */
    s = stage_open();
    mesh.indices = t + 6, mesh.triangle_count = 3;
    p[3 * 4] = 0, p[3 * 5 + 1] = 0, p[3 * 6 + 2] = 3;
    assert_ok(s.context, fathom_scene_add_mesh_shared(s.scene, FATHOM_ROOT, &mesh, NULL));
    p[3 * 4] = NAN, p[3 * 5 + 1] = INFINITY, p[3 * 6 + 2] = 1e30f;
    trace_tracer *tracer = stage_embree(&s, 16);
    assert_true(depth(tracer, 0.5, 0.25) == INFINITY);
}

/* Beyond 1.8e18 Embree would abort, in the space of an instance too: a ray from there meets nothing. */
UNIT_TEST(far_rays_are_harmless) {
    stage s = stage_open();
    const fathom_id group = new_group(s.scene, "small");
    add_sphere(&s, group, 0, 0, 0, 1e8, 0);
    add_sphere(&s, FATHOM_ROOT, 0, 0, 0, 0.5, 0);
    add_instance(&s, group, (double[12]){1e-8, 0, 0, 0, 0, 1e-8, 0, 0, 0, 0, 1e-8, 0});
    for (size_t i = 0; i < 4; ++i) {
        trace_tracer *tracer = stage_embree(&s, widths[i]);
        assert_true(depth(tracer, 0, 0) < 5);
        assert_true(depth(tracer, 1e12, 0) == INFINITY && depth(tracer, 1e20, 0) == INFINITY);
    }
}

/* A group at the origin beside a sphere in the root, by a frame that scales and moves it along x. */
static void fill_scaled(stage *s, double radius, double scale, double shift) {
    const fathom_id group = new_group(s->scene, "scaled");
    add_sphere(s, group, 0, 0, 0, radius, 0);
    add_sphere(s, FATHOM_ROOT, 0, 0, 0, 0.1, 0);
    add_instance(s, group, (double[12]){scale, 0, 0, shift, 0, scale, 0, 0, 0, 0, scale, 0});
    const vec3_f64 origin = {0, 0, 0};
    assert_ok(s->context, world_create_from(s->scene, &origin, &s->world));
    own_world(s->world);
}

/* Told before anything is built, and by building in the same words. Embree inverts frames in float: of
 * 1e-16, it would make one of NaN, and abort. */
UNIT_TEST(frames_beyond_float_are_refused) {
    static const struct {
        double radius, scale, shift;
        const char *message;
    } cases[] = {{1, 1e-16, 0, "instance 0, of \"scaled\": it scales its group so far"},
                 {1, 1e-30, 0, "instance 0, of \"scaled\": it shrinks its group so far"},
                 {1, 1e-18, 0, "instance 0, of \"scaled\": it shrinks its group so far"},
                 {1, 1, 1e18, "instance 0, of \"scaled\": it moves its group so far away"},
                 {1e14, 1e-14, 0, "instance 0, of \"scaled\": it scales its group so far"},
                 {1e11, 1e-11, 0, "instance 0, of \"scaled\": it scales its group so far"},
                 {1e-11, 1e11, 0, "instance 0, of \"scaled\": it scales its group so far"},
                 {1e-14, 1e14, 0, "instance 0, of \"scaled\": it scales its group so far"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        stage s = stage_open();
        fill_scaled(&s, cases[i].radius, cases[i].scale, cases[i].shift);
        assert_fails(s.context, reach_check(s.context, s.world), FATHOM_BAD_INPUT, cases[i].message);
        const char *message = unit_text("%s", fathom_context_message(s.context));
        trace_options options = {.words = "embree", .width = 16, .threads = 1};
        trace_tracer *tracer;
        assert_fails(s.context, trace_create(s.context, s.world, &options, &tracer), FATHOM_BAD_INPUT,
                     cases[i].message);
        assert_string_equal(fathom_context_message(s.context), message);
    }
}

/* It has a frame of its own, which the message does not call an instance. */
UNIT_TEST(a_mesh_too_far_away_is_named) {
    static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    static const uint32_t indices[3] = {0, 1, 2};
    stage s = stage_open();
    add_sphere(&s, FATHOM_ROOT, 0, 0, 0, 1, 0);
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 3, mesh.indices = indices, mesh.triangle_count = 1;
    mesh.origin[0] = 1e19;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
    const vec3_f64 origin = {0, 0, 0};
    assert_ok(s.context, world_create_from(s.scene, &origin, &s.world));
    own_world(s.world);
    assert_fails(s.context, reach_check(s.context, s.world), FATHOM_BAD_INPUT,
                 "object 1: it lies so far away that coordinates of the scene");
}

UNIT_TEST(frames_of_every_shape) {
    static const struct {
        double scale[3];
        bool fits;
    } cases[] = {{{1, 1, 1}, true},           {{1.3e-10, 1.3e-10, 1.3e-10}, true},
                 {{3e10, -3e10, 3e10}, true}, {{1.1e-10, 1.1e-10, 1.1e-10}, false},
                 {{1, 4e10, 1}, false},       {{1, 1, 1e-20}, true},
                 {{1, 1, 1e-31}, false},      {{1e10, 1e-16, 1e-16}, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        world_instance instance;
        affine_f64 map = affine_scaling(load_f64(cases[i].scale));
        assert_true(world_instance_set(&instance, &map));
        assert_int_equal(world_instance_fits_float(&instance), cases[i].fits);
    }
}

/* Up to there they answer. */
UNIT_TEST(frames_within_float_are_met) {
    static const double scales[] = {2e-10, 1e-6, 1e6, 3e10};
    for (size_t i = 0; i < 4 * 4; ++i) {
        stage s = stage_open();
        fill_scaled(&s, 1 / scales[i / 4], scales[i / 4], 0);
        assert_ok(s.context, reach_check(s.context, s.world));
        trace_tracer *tracer = stage_embree(&s, widths[i % 4]);
        assert_in_range(fabsf(depth(tracer, 0, 0) - 4) * 0x1p20f, 0, 4);
        assert_in_range(fabsf(depth(tracer, 0.6, 0) - 4.2f) * 0x1p20f, 0, 4);
        assert_true(depth(tracer, 1.01, 0) == INFINITY);
    }
}

static void count_warning(void *user, const char *message) {
    unsigned *count = user;
    *count += strstr(message, "instances beyond 1e+18 from the origin, which Embree leaves out: 1") != NULL;
}

/* Too far out for Embree, which says nothing: so we do. */
UNIT_TEST(instances_out_of_reach_are_told) {
    unsigned count = 0;
    stage s = stage_open();
    fathom_context_on_warning(s.context, count_warning, &count);
    fill_scaled(&s, 1e10, 1e9, 0);
    assert_ok(s.context, reach_check(s.context, s.world));
    assert_int_equal(count, 1);
    s = stage_open();
    fathom_context_on_warning(s.context, count_warning, &count);
    fill_scaled(&s, 1e8, 1e9, 0);
    assert_ok(s.context, reach_check(s.context, s.world));
    assert_int_equal(count, 1);
}

typedef struct watched {
    size_t calls;
    double highest;
    double stop_at;
} watched;

static bool watch(void *user, double fraction) {
    watched *w = user;
    ++w->calls;
    w->highest = fmax(w->highest, fraction);
    return fraction < w->stop_at;
}

UNIT_TEST(building_can_be_stopped) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 150, 0.05, 1, 0, 0);
    stage_world(&s);
    watched all = {.stop_at = 2}, at_once = {.stop_at = -1}, half = {.stop_at = 0.3};
    trace_options options = {.width = 16, .threads = 1, .progress = watch, .user = &all};
    trace_tracer *tracer = NULL;
    assert_ok(s.context, trace_create(s.context, s.world, &options, &tracer));
    assert_true(all.calls > 1 && all.highest <= 1 && all.highest > 0.5);
    trace_destroy(tracer);
    options.user = &at_once;
    assert_fails(s.context, trace_create(s.context, s.world, &options, &tracer), FATHOM_INTERRUPTED,
                 "stopped");
    assert_null(tracer);
    options.user = &half;
    assert_fails(s.context, trace_create(s.context, s.world, &options, &tracer), FATHOM_INTERRUPTED,
                 "stopped");
    assert_null(tracer);
}

UNIT_TEST(tells_what_it_is) {
    stage s = stage_open();
    add_ball(&s, FATHOM_ROOT, 50, 0.05, 1, 0, 0);
    trace_tracer *tracer = stage_embree(&s, 16);
    assert_true(strncmp(trace_name(tracer), "Embree ", 7) == 0 && strstr(trace_name(tracer), ", "));
    /* A robust leaf holds 4 triangles in at least 4 * (9 + 2) * 4 bytes. */
    assert_true(trace_bvh_bytes(tracer) >= 44 * 4 * 50 * 49);
}

/* The t of the closest hit within an interval, or infinity; any: whether any hit says that there is one. */
static float depth_within(const trace_tracer *tracer, trace_coherence coherence, float t_near, float t_far,
                          bool *any) {
    ray_set set = ray_down(0.3, 0.2);
    set.blocks[0].rays.t_near[0] = t_near, set.blocks[0].rays.t_far[0] = t_far;
    ray_set got = traced(tracer, &set, coherence);
    unsigned char *blocked_by = occluded(tracer, &set, coherence);
    bool met = got.blocks[0].hits.geometry[0] != FATHOM_NONE;
    float t = hit_t(&got, 0);
    *any = blocked_by[0];
    assert_true(met ? t > t_near && t < t_far : t == t_far);
    assert_true(got.blocks[0].rays.t_near[0] == t_near);
    return met ? t : INFINITY;
}

/* Where a surface is told to be: behind the first and before the last, and maybe at those between. */
typedef struct place {
    float before, first, last, after;
} place;

static place exactly_at(float t) { return (place){nextafterf(t, 0), t, t, nextafterf(t, INFINITY)}; }
static place about_at(float t) {
    float low = t * (1 - 0x1p-21f), high = t * (1 + 0x1p-21f);
    return (place){low, low, high, high};
}

/* The surface is alone in (low, high). */
static void open_around(const trace_tracer *tracer, trace_coherence coherence, float low, float high,
                        place at) {
    const struct {
        float t_near, t_far;
        bool met;
    } cases[] = {{low, high, true},           {low, at.first, false}, {low, at.after, true},
                 {at.before, high, true},     {at.last, high, false}, {at.before, at.after, true},
                 {at.first, at.first, false}, {at.after, low, false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        bool any;
        float t = depth_within(tracer, coherence, cases[i].t_near, cases[i].t_far, &any);
        assert_true(any == cases[i].met && (t < INFINITY) == cases[i].met);
    }
}

/* Shapes of our own are in or out to the last bit, Embree's triangles within the units that it is off by.
 * Coherent packets skip boxes that begin, rounded, at the end of the interval, so the t that is reported does
 * not decide either. */
UNIT_TEST(intervals_are_open) {
    static const char *const specs[] = {"linear",   "embree:1",  "embree:4",
                                        "embree:8", "embree:16", "embree:user"};
    stage s = stage_open();
    const double origin[3] = {0, 0, 0}, u[3] = {1, 0, 0}, v[3] = {0, 1, 0};
    add_quad(&s, FATHOM_ROOT, origin, u, v, 0);
    add_grid(&s, 4, -3);
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i) {
        trace_tracer *tracer = stage_spec(&s, specs[i]);
        for (trace_coherence c = TRACE_INCOHERENT; c <= TRACE_COHERENT; ++c) {
            bool any, exact = i == 0 || i == 5;
            assert_true(triangle_at(depth_within(tracer, c, 5.5f, 9, &any), 8));
            open_around(tracer, c, 5.5f, 9, exact ? exactly_at(8) : about_at(8));
            open_around(tracer, c, 6, INFINITY, exact ? exactly_at(8) : about_at(8));
            open_around(tracer, c, 0, 6, exact ? exactly_at(5) : about_at(5));
            open_around(tracer, c, 0x1p-140f, 6, exact ? exactly_at(5) : about_at(5));
        }
    }
}

/* Wherever it ends, for Embree's own shapes too, and scenes that decide by products and report quotients. */
UNIT_TEST(no_hit_lies_outside_its_interval) {
    static const char *const specs[] = {
        "embree", "embree:raw", "embree:default", "embree:default:1", "embree:default:raw", "embree:compact",
    };
    stage s = stage_open();
    const double origin[3] = {0, 0, 0}, u[3] = {1, 0, 0.1}, v[3] = {0.2, 1, 0};
    add_quad(&s, FATHOM_ROOT, origin, u, v, 0);
    add_ball(&s, FATHOM_ROOT, 9, 0.05, 0.9, 0, 0);
    add_sphere(&s, FATHOM_ROOT, 0, 0, -4, 1, 0);
    for (size_t i = 0; i < sizeof specs / sizeof *specs; ++i) {
        trace_tracer *tracer = stage_spec(&s, specs[i]);
        bool any;
        for (float t = 0; (t = depth_within(tracer, TRACE_COHERENT, t, INFINITY, &any)) < INFINITY;) {
            float end = t * (1 - 0x1p-21f);
            for (int k = 0; k < 32; ++k, end = nextafterf(end, INFINITY)) {
                depth_within(tracer, TRACE_COHERENT, 0, end, &any);
                depth_within(tracer, TRACE_COHERENT, end, INFINITY, &any);
            }
        }
    }
}

UNIT_TEST(threads_get_their_mode_back) {
#if defined(__SSE2__)
    unsigned before = _mm_getcsr(), saved = trace_thread_begin();
    volatile float tiny = 0x1p-140f;
    assert_true(tiny * 1.0f == 0); /* denormals are zero in between */
    trace_thread_end(saved);
    assert_int_equal(_mm_getcsr(), before);
    assert_true(tiny * 1.0f > 0);
#endif
}

/* Hit or miss is decided by the intersector, so no box may stand in the way. */
UNIT_TEST(boxes_hide_no_sphere) {
    stage s = stage_open();
    ray_set set = silhouette_rays(&s, 40, -2, 40000, 0.1, 2);
    trace_tracer *embree = stage_embree(&s, 16), *linear = stage_trace(&s, "reference", 16, 0, 1);
    ray_set e = traced(embree, &set, TRACE_COHERENT), l = traced(linear, &set, TRACE_COHERENT);
    unsigned char *eo = occluded(embree, &set, TRACE_COHERENT), *lo = occluded(linear, &set, TRACE_COHERENT);
    for (size_t i = 0; i < set.count; ++i) {
        assert_true(same_hit(&e, &l, i) && hit_t(&e, i) == hit_t(&l, i));
        assert_int_equal(eo[i], lo[i]);
    }
}

int main(void) { return unit_main(NULL, NULL); }
