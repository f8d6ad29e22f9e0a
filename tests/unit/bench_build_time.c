/* Build quality against time: ranges and totals from made-up medians. */
#include "measure/build_time.h"
#include "told.h"
#include "unit.h"

static fathom_context *context;
static bench_stage stage;

static int begin(void **state) {
    (void)state;
    fathom_scene *scene;
    fathom_settings settings;
    if (fathom_context_create(&context) != FATHOM_OK) return -1;
    if (fathom_scene_read(context, SOURCE_DIR "/scenes/tour/22-mesh-file.json", &scene) != FATHOM_OK)
        return -1;
    fathom_scene_settings(scene, &settings);
    settings.width = 32, settings.height = 32, settings.spp = 1;
    return stage_open(context, scene, &settings, &stage) == FATHOM_OK ? 0 : -1;
}
static int end(void **state) {
    (void)state;
    stage_close(&stage);
    fathom_context_destroy(context);
    return 0;
}

static build_time made_up(const double build[3], const double sample[3]) {
    build_time t = {.totals = {{.spp = 0}}};
    for (int q = 0; q < BUILD_QUALITIES; ++q) {
        for (int c = 0; c < BENCH_CLOCKS; ++c)
            t.qualities[q].build[c].median = build[q], t.qualities[q].sample[c].median = sample[q];
    }
    build_time_summarise(&stage, &t);
    return t;
}

/* 1 + 4n, 5 + 2n, 20 + n: the first two cross at 2, the last two at 15, and 1 + 4n = 20 + n at 19/3 lies
 * above the second. */
static void ranges(void **state) {
    (void)state;
    build_time t = made_up((const double[]){1, 5, 20}, (const double[]){4, 2, 1});
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        assert_true(t.qualities[0].from[c] == 0 && t.qualities[0].to[c] == 2);
        assert_true(t.qualities[1].from[c] == 2 && t.qualities[1].to[c] == 15);
        assert_true(t.qualities[2].from[c] == 15 && isinf(t.qualities[2].to[c]));
        assert_int_equal(t.totals[0].best[c], 0);
        assert_int_equal(t.totals[1].best[c], 1);
        assert_int_equal(t.totals[2].best[c], 2);
    }
    assert_true(t.totals[2].spp == 16 && t.totals[2].seconds[1][BENCH_WALL] == 37);
    /* So few rays that the automatic choice is low: 65 seconds instead of 36. */
    assert_int_equal(t.totals[2].automatic, 0);
    assert_true(t.totals[2].behind[BENCH_CPU] == 65.0 / 36 - 1);
}

/* What costs more and saves nothing is never best. */
static void never(void **state) {
    (void)state;
    build_time t = made_up((const double[]){1, 2, 3}, (const double[]){1, 1, 2});
    assert_true(t.qualities[0].from[0] == 0 && isinf(t.qualities[0].to[0]));
    assert_true(t.qualities[1].from[0] >= t.qualities[1].to[0]);
    assert_true(t.qualities[2].from[0] >= t.qualities[2].to[0]);
}

static void measured(void **state) {
    (void)state;
    build_time t;
    told far;
    const bench_watch watch = told_watch(&far);
    assert_ok(context, build_time_measure(context, &stage, "embree:default", 2, 4, &watch, &t));
    told_all(&far, 3);
    for (int q = 0; q < BUILD_QUALITIES; ++q) {
        assert_true(t.qualities[q].build[BENCH_WALL].median > 0);
        assert_true(t.qualities[q].sample[BENCH_WALL].median > 0);
        assert_true(t.qualities[q].bvh_bytes > 0);
        assert_true(t.qualities[q].peak_bytes >= t.qualities[q].bvh_bytes);
        assert_true(t.qualities[q].rays == t.qualities[0].rays && t.qualities[q].rays >= 32 * 32);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(ranges), cmocka_unit_test(never),
                                       cmocka_unit_test(measured)};
    return cmocka_run_group_tests(tests, begin, end);
}
