/* The rays that tracers are measured with, and that all of them are asked of each. No time is judged. */
#include "stage.h"

#include "measure/trace_time.h"
#include "told.h"

static void open_scene(stage *s) {
    *s = stage_open();
    add_ball(s, FATHOM_ROOT, 24, 0.05, 0.7, 0, 0);
    add_grid(s, 8, -0.9);
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0.3, 0.2, 5}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7, &camera);
    assert_ok(s->context, fathom_scene_set_camera(s->scene, &camera));
    fathom_light light = default_light();
    light.position[0] = 2, light.position[2] = 5;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
}

UNIT_TEST(sets) {
    stage s;
    open_scene(&s);
    trace_tracer *tracer = stage_spec(&s, "bvh");
    trace_sets sets;
    assert_ok(s.context, trace_sets_create(s.context, s.world, tracer, 5000, &sets));
    size_t rays = sets.items[TRACE_SET_CAMERA].count * LANES;
    /* Rows and columns of whole squares: each side is off by half a square at most. */
    assert_near(rays, 5000, 5000 * 0.06);
    /* The aspect is the image's, and neighbours in a block are neighbours in the image: all directions of a
     * square of 4 x 4 of some 94 x 53 pixels of 0.7 rad up lie within √2 · 4 · 0.7 / 53 of each other. */
    for (size_t b = 0; b < sets.items[TRACE_SET_CAMERA].count; ++b) {
        const trace_rays *r = &sets.items[TRACE_SET_CAMERA].blocks[b];
        for (int k = 1; k < 16; ++k) {
            double x = (double)(r->dir_x[k] - r->dir_x[0]), y = (double)(r->dir_y[k] - r->dir_y[0]);
            assert_true(hypot(x, y) < 0.075);
        }
    }
    /* The others leave from hits: each of them lies on the ball, which is within 0.7 · 1.05 of the middle, or
     * on the grid, whose corners are 1.42 from its own. */
    for (int k = TRACE_SET_CAMERA + 1; k < TRACE_SETS; ++k) {
        assert_int_equal(sets.items[k].count, sets.items[TRACE_SET_SHADOW].count);
        for (size_t i = 0; i < sets.items[k].count * LANES; ++i) {
            const trace_rays *r = &sets.items[k].blocks[i / 16];
            size_t l = i % 16;
            double d[3] = {(double)r->dir_x[l], (double)r->dir_y[l], (double)r->dir_z[l]};
            double o[3] = {(double)r->org_x[l], (double)r->org_y[l], (double)r->org_z[l]};
            assert_true(hypot(hypot(o[0], o[1]), o[2]) < 1.7);
            assert_near(hypot(hypot(d[0], d[1]), d[2]), 1,
                        1e-6); /* unit up to float's rounding, 2^-24 each */
            assert_true(r->t_near[l] > 0 && r->t_near[l] <= r->t_far[l]);
        }
    }
    /* Shadow rays end at the light. */
    const trace_rays *r = &sets.items[TRACE_SET_SHADOW].blocks[0];
    assert_near(r->org_x[0] + r->t_far[0] * r->dir_x[0] + (float)s.world->origin.x, 2, 1e-5);
    trace_sets_free(&sets);
}

UNIT_TEST(blind) {
    stage s;
    open_scene(&s);
    fathom_camera away;
    fathom_camera_look_at((double[3]){0, 0, 5}, (double[3]){0, 0, 9}, (double[3]){0, 1, 0}, 0.7, &away);
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &away));
    trace_tracer *tracer = stage_spec(&s, "bvh");
    trace_sets sets;
    assert_fails(s.context, trace_sets_create(s.context, s.world, tracer, 500, &sets), FATHOM_BAD_INPUT,
                 "the camera sees nothing");
    trace_sets_free(&sets);
}

/* With time enough every tracer is asked all rays, on any number of threads, and meets the same of them. */
UNIT_TEST(whole) {
    stage s;
    open_scene(&s);
    static const char *const words[] = {"embree:16", "embree:1", "bvh", "linear"};
    trace_tracer *made[4];
    for (int i = 0; i < 4; ++i) made[i] = stage_spec(&s, words[i]);
    trace_sets sets;
    assert_ok(s.context, trace_sets_create(s.context, s.world, made[0], 5000, &sets));
    for (unsigned threads = 1; threads < 4; threads += 2) {
        told far;
        const bench_watch watch = told_watch(&far);
        trace_time_options options = {.repeats = 2, .threads = threads, .seconds = 1e6, .watch = &watch};
        static trace_rate rates[4][TRACE_SETS];
        assert_ok(s.context, trace_time_measure(s.context, made, 4, &sets, &options, rates));
        told_all(&far, 3 * 4 * TRACE_SETS);
        for (int k = 0; k < TRACE_SETS; ++k) {
            for (int i = 0; i < 4; ++i) {
                assert_int_equal(rates[i][k].rays, sets.items[k].count * LANES);
                assert_int_equal(rates[i][k].met, rates[0][k].met);
                assert_true(rates[i][k].per_cpu_second.low <= rates[i][k].per_cpu_second.high);
            }
            assert_true(rates[0][k].met > 0 && rates[0][k].met < rates[0][k].rays);
        }
    }
    /* With none, one block. */
    trace_time_options options = {.repeats = 1, .threads = 1, .seconds = 1e-12};
    static trace_rate rates[4][TRACE_SETS];
    assert_ok(s.context, trace_time_measure(s.context, made, 4, &sets, &options, rates));
    assert_int_equal(rates[3][0].rays, LANES);
    trace_sets_free(&sets);
}

int main(void) { return unit_main(NULL, NULL); }
