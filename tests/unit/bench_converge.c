/* Error against time: fits and tables from made-up images, and a small scene measured. */
#include "measure/converge.h"
#include "unit_context.h"

#define STEPS 5
#define ROUNDS 3

/* Pattern p takes seconds[p] a sample, and round r has scale[r] · samples^slope[r] as its error. */
static const double seconds[CONVERGE_PATTERNS] = {1, 1.5, 2};
static const double slopes[ROUNDS] = {-0.5, -0.6, -0.7}, scales[ROUNDS] = {1, 1, 1};

static void make_runs(converge_result *r, double reference) {
    *r = (converge_result){.rounds = ROUNDS, .steps = STEPS};
    for (int m = 0; m < CONVERGE_METRICS; ++m) r->reference.halves[m] = reference;
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        for (unsigned round = 0; round < ROUNDS; ++round) {
            for (unsigned step = 0; step < STEPS; ++step) {
                converge_run run = {.round = round, .step = step, .pattern = (fathom_pattern)p};
                double samples = pow(4, step);
                run.seconds.by[BENCH_CPU] = seconds[p] * samples;
                run.seconds.by[BENCH_WALL] = seconds[p] * samples * samples;
                for (int m = 0; m < CONVERGE_METRICS; ++m)
                    run.errors[m] = scales[round] * pow(samples, slopes[round]);
                assert_true(array_push(&r->runs, run));
            }
        }
    }
    converge_summarise(r);
}

/* The slopes are those put in; over the clock, which here goes with the square of the samples, half of them.
 * Of -0.5, -0.6, -0.7 the mean is -0.6 and the deviation 0.1. Logarithms and their sums round by some 2^-50.
 */
UNIT_TEST(slopes_come_back) {
    converge_result r;
    make_runs(&r, 0);
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        const converge_slope *s = r.curves[p].slopes[CONVERGE_RELMSE];
        assert_near(s[BENCH_CPU].slope.mean, -0.6, 1e-14);
        assert_near(s[BENCH_CPU].slope.half, student_95(2) * 0.1 / sqrt(3), 1e-13);
        assert_near(s[BENCH_WALL].slope.mean, -0.3, 1e-14);
        assert_int_equal(s[BENCH_CPU].points, STEPS);
        /* At one sample all errors are 1. */
        assert_near(s[BENCH_CPU].scale * pow(seconds[p], -0.6), 1, 1e-13);
    }
    converge_free(&r);
}

/* Geometric means of the errors are samples^-0.6, at any place on the line. */
UNIT_TEST(equal_time) {
    converge_result r;
    converge_row rows[CONVERGE_ROWS];
    make_runs(&r, 0);
    assert_int_equal(converge_equal(&r, CONVERGE_FLIP, false, rows), CONVERGE_ROWS);
    /* The slowest begins at 2 seconds, and the fastest ends at 256. */
    assert_near(rows[0].at, 2 * pow(128, 0.1), 1e-12);
    assert_near(rows[4].at, 2 * pow(128, 0.9), 1e-12);
    for (int i = 0; i < CONVERGE_ROWS; ++i) {
        for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
            assert_near(rows[i].values[p], pow(rows[i].at / seconds[p], -0.6), 1e-13);
    }
    assert_int_equal(converge_equal(&r, CONVERGE_FLIP, true, rows), CONVERGE_ROWS);
    assert_true(rows[0].at > rows[1].at);
    for (int i = 0; i < CONVERGE_ROWS; ++i) {
        for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
            assert_near(rows[i].values[p] / (seconds[p] * pow(rows[i].at, -1 / 0.6)), 1, 1e-12);
    }
    converge_free(&r);
}

/* What is closer to the reference than its halves are to each other is marked and counts for nothing: with
 * 0.1 that is 256 samples, whose mean error is 4^(-4 · 0.6) = 0.036, and 64, of 0.083. */
UNIT_TEST(below_the_reference) {
    converge_result r;
    make_runs(&r, 0.1);
    const converge_curve *c = &r.curves[0];
    for (unsigned step = 0; step < STEPS; ++step)
        assert_true(c->points[step].below[CONVERGE_RMSE] == (step >= 3));
    assert_int_equal(c->slopes[CONVERGE_RMSE][BENCH_CPU].points, 3);
    assert_near(c->slopes[CONVERGE_RMSE][BENCH_CPU].slope.mean, -0.6, 1e-14);
    converge_free(&r);
    /* Nothing is left to fit or to compare. */
    converge_row rows[CONVERGE_ROWS];
    make_runs(&r, 2);
    assert_true(isnan(r.curves[0].slopes[CONVERGE_RMSE][BENCH_CPU].slope.mean));
    assert_int_equal(converge_equal(&r, CONVERGE_RMSE, false, rows), 0);
    assert_int_equal(converge_equal(&r, CONVERGE_RMSE, true, rows), 0);
    converge_free(&r);
}

/* ---- a scene ---- */

static void open_example(bench_stage *stage) {
    fathom_scene *scene;
    fathom_settings settings;
    assert_ok(context, fathom_scene_read(context, SOURCE_DIR "/scenes/tour/26-antialiasing.json", &scene));
    fathom_scene_settings(scene, &settings);
    settings.width = 48, settings.height = 32;
    assert_ok(context, stage_open(context, scene, &settings, stage));
    assert_ok(context, stage_build(context, stage));
}

/* The stage's images are those of fathom_render(). */
UNIT_TEST(same_image) {
    bench_stage stage;
    open_example(&stage);
    fathom_settings settings = stage.settings;
    settings.pattern = FATHOM_PATTERN_SOBOL, settings.spp = 5, settings.seed = 9;
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    assert_ok(context, fathom_render(context, stage.scene, &settings, NULL, NULL, &stats, &film));
    const stage_shot shot = {FATHOM_PATTERN_SOBOL, 5, 9};
    static float rgb[3][48 * 32];
    stage_cost cost;
    assert_ok(context, stage_render(context, &stage, &shot, NULL, NULL, rgb[0], &cost));
    static const char *const names[3] = {"R", "G", "B"};
    for (size_t c = 0; c < 3; ++c)
        assert_memory_equal(rgb[c], fathom_film_channel(film, names[c]), sizeof rgb[c]);
    assert_int_equal(cost.rays.camera, stats.camera_rays);
    assert_int_equal(cost.rays.shadow, stats.shadow_rays);
    assert_int_equal(cost.rays.reflection, stats.reflection_rays);
    assert_int_equal(cost.rays.refraction, stats.refraction_rays);
    fathom_film_destroy(film);
    stage_close(&stage);
}

static bool on_progress(void *user, double fraction) {
    double *last = user;
    assert_true(fraction >= *last - 1e-9 && fraction <= 1 + 1e-9);
    *last = fraction;
    return true;
}

/* More samples are closer, Sobol's most of all; the grid has no seed, so its rounds are alike. */
UNIT_TEST(measured) {
    bench_stage stage;
    open_example(&stage);
    double last = 0;
    converge_options options = {.rounds = 2,
                                .max_spp = 16,
                                .half_spp = 256,
                                .seed = 1,
                                .ppd = 67,
                                .progress = on_progress,
                                .user = &last};
    converge_result r;
    assert_ok(context, converge_measure(context, &stage, &options, &r));
    assert_int_equal(r.steps, 3);
    assert_int_equal(r.runs.count, 2 * 3 * 3);
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        const converge_point *points = r.curves[p].points;
        for (int m = 0; m < CONVERGE_METRICS; ++m) {
            assert_true(points[0].errors[m] > points[1].errors[m] &&
                        points[1].errors[m] > points[2].errors[m]);
            assert_true(r.reference.own[m] > 0 && r.reference.own[m] < points[2].errors[m]);
        }
        assert_true(r.curves[p].slopes[CONVERGE_RMSE][BENCH_CPU].slope.mean < 0);
    }
    for (size_t i = 0; i < r.runs.count; ++i) {
        const converge_run *a = &r.runs.items[i];
        assert_true(a->nonfinite == 0 && a->rays >= 48 * 32);
        for (size_t k = 0; k < i; ++k) {
            const converge_run *b = &r.runs.items[k];
            if (a->pattern != b->pattern || a->step != b->step) continue;
            assert_true((a->errors[CONVERGE_RMSE] == b->errors[CONVERGE_RMSE]) ==
                        (a->pattern == FATHOM_PATTERN_GRID));
        }
    }
    converge_free(&r);
    stage_close(&stage);
}

static bool stop(void *user, double fraction) {
    (void)user, (void)fraction;
    return false;
}

UNIT_TEST(interrupted) {
    bench_stage stage;
    open_example(&stage);
    converge_options options = {.rounds = 1, .max_spp = 1, .half_spp = 4096, .ppd = 67, .progress = stop};
    converge_result r;
    assert_int_equal(converge_measure(context, &stage, &options, &r), FATHOM_INTERRUPTED);
    converge_free(&r);
    stage_close(&stage);
}

int main(void) { return unit_main(open_context, NULL); }
