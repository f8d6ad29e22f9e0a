/* `fathom bench error`: image error against run time, for each antialiasing pattern. */
#include "cli/bench/bench.h"

#include "base/status.h"
#include "cli/interrupt.h"
#include "image/compare/flip.h"
#include "measure/converge.h"
#include "measure/coverage.h"

#include <math.h>
#include <string.h>

typedef struct bench_error_settings {
    bench_settings all;
    uint32_t seeds, max_spp, half_spp; /* half_spp 0: four times max_spp */
    uint64_t seed;
    double ppd;
    bool adaptive;
} bench_error_settings;

/* ---- the object ---- */

static void add_seconds(json_t *object, const bench_seconds *s) {
    json_add(object, JSON("cpuSeconds", s->by[BENCH_CPU]), JSON("seconds", s->by[BENCH_WALL]));
}

static json_t *add_errors(json_t *object, const double errors[CONVERGE_METRICS]) {
    for (converge_metric m = 0; m < CONVERGE_METRICS; ++m)
        json_add(object, JSON(converge_metric_name(m), errors[m]));
    return object;
}

static json_t *pack_reference(const converge_reference *r) {
    json_t *object =
        json_of(JSON("pattern", "sobol"), JSON("halves", 2), JSON("sppOfEach", r->spp),
                JSON("ownError", add_errors(json_object(), r->own)),
                JSON("betweenHalves", add_errors(json_object(), r->halves)), JSON("notFinite", r->nonfinite));
    add_seconds(object, &r->seconds);
    return object;
}

static json_t *pack_run(const converge_run *run, uint64_t seed) {
    json_t *object =
        json_of(JSON("pattern", converge_pattern_name(run->pattern)), JSON("spp", 1u << (2 * run->step)),
                JSON("seed", seed + run->round), JSON("rays", run->rays), JSON("notFinite", run->nonfinite));
    add_seconds(object, &run->seconds);
    return add_errors(object, run->errors);
}

static json_t *pack_point(const converge_point *point) {
    json_t *below = json_array();
    for (converge_metric m = 0; m < CONVERGE_METRICS; ++m)
        if (point->below[m]) json_array_append_new(below, json_string(converge_metric_name(m)));
    json_t *object = json_of(JSON("spp", point->spp), JSON("belowReference", below));
    add_seconds(object, &point->seconds);
    return add_errors(object, point->errors);
}

static json_t *pack_slopes(const converge_slope slopes[BENCH_CLOCKS]) {
    json_t *object = json_object();
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        const converge_slope *s = &slopes[c];
        json_t *slope = json_of(JSON("slope", s->slope.mean), JSON("half", s->slope.half),
                                JSON("scale", s->scale), JSON("points", s->points));
        json_add(object, JSON(bench_clock_names[c], slope));
    }
    return object;
}

static json_t *pack_curve(const converge_result *result, const converge_curve *curve) {
    json_t *points = json_array(), *slopes = json_object();
    for (unsigned step = 0; step < result->steps; ++step)
        json_array_append_new(points, pack_point(&curve->points[step]));
    for (converge_metric m = 0; m < CONVERGE_METRICS; ++m)
        json_add(slopes, JSON(converge_metric_name(m), pack_slopes(curve->slopes[m])));
    return json_of(JSON("pattern", converge_pattern_name(curve->pattern)), JSON("points", points),
                   JSON("slopes", slopes));
}

static json_t *pack_rows(const converge_row *rows, size_t count, const char *at) {
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) {
        json_t *row = json_of(JSON(at, rows[i].at));
        for (fathom_pattern p = 0; p < CONVERGE_PATTERNS; ++p)
            json_add(row, JSON(converge_pattern_name(p), rows[i].values[p]));
        json_array_append_new(list, row);
    }
    return list;
}

static void add_tables(json_t *root, const converge_result *result) {
    json_t *time = json_object(), *error = json_object();
    converge_row rows[CONVERGE_ROWS];
    for (converge_metric m = 0; m < CONVERGE_METRICS; ++m) {
        const char *name = converge_metric_name(m);
        size_t count = converge_equal(result, m, false, rows);
        json_add(time, JSON(name, pack_rows(rows, count, "cpuSeconds")));
        count = converge_equal(result, m, true, rows);
        json_add(error, JSON(name, pack_rows(rows, count, "error")));
    }
    json_add(root, JSON("equalTime", time), JSON("equalError", error));
}

static void pack(const bench_error_settings *asked, const bench_stage *stage, const converge_result *result,
                 bool interrupted, json_t *root) {
    json_t *runs = json_array(), *curves = json_array(), *built = json_object();
    bench_add_tracer(root, trace_name(stage->tracer));
    add_seconds(built, &stage->build);
    for (size_t i = 0; i < result->runs.count; ++i)
        json_array_append_new(runs, pack_run(&result->runs.items[i], asked->seed));
    for (fathom_pattern p = 0; p < CONVERGE_PATTERNS; ++p)
        json_array_append_new(curves, pack_curve(result, &result->curves[p]));
    json_add(root, JSON("scene", asked->all.scene), JSON("tracer", trace_name(stage->tracer)),
             JSON("width", stage->settings.width), JSON("height", stage->settings.height),
             JSON("seeds", result->rounds), JSON("ppd", asked->ppd), JSON("build", built),
             JSON("reference", pack_reference(&result->reference)), JSON("runs", runs),
             JSON("curves", curves), JSON("interrupted", interrupted));
    add_tables(root, result);
}

static const bench_csv csv = {.rows = "runs",
                              .columns = "pattern, spp, seed, cpu_seconds=cpuSeconds, seconds, rays, rmse, "
                                         "relmse, flip, not_finite=notFinite"};

/* ---- the tables ---- */

static const char *const titles[CONVERGE_METRICS] = {"RMSE", "relMSE", "FLIP"};

static void print_head(const json_t *root) {
    size_t i;
    json_t *run;
    double broken = json_number_at(root, "reference.notFinite");
    json_array_foreach(json_object_get(root, "runs"), i, run) broken += json_number_at(run, "notFinite");
    print_name(stdout, json_text_at(root, "scene"));
    json_print(root,
               ", {width:.0f}x{height:.0f}, {tracer:s}\n"
               "rendering alone is timed; the build took {build.cpuSeconds:.3f} s of CPU time, "
               "{build.seconds:.3f} s by the clock\n"
               "reference: two halves of {reference.sppOfEach:.0f} samples a pixel, sobol; its own RMSE "
               "{reference.ownError.rmse:.3g}, relMSE {reference.ownError.relmse:.3g}, FLIP at most "
               "{reference.ownError.flip:.3g}\n");
    printf("pixels that are not finite: %.0f\n", broken);
}

static bool is_below(const json_t *point, const char *metric) {
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(point, "belowReference"), i, name) {
        if (strcmp(json_string_value(name), metric) == 0) return true;
    }
    return false;
}

static bool print_point(const char *pattern, const json_t *point) {
    bool marked = false;
    printf("%-10s ", pattern);
    json_print(point, "{spp:6.0f} {cpuSeconds:10.4g} {seconds:10.4g}");
    for (converge_metric m = 0; m < CONVERGE_METRICS; ++m) {
        const char *name = converge_metric_name(m);
        const bool below = is_below(point, name);
        printf("  %9.3g%c", json_number_at(point, name), below ? '*' : ' ');
        marked |= below;
    }
    putchar('\n');
    return marked;
}

static void print_points(const json_t *root) {
    size_t i, k;
    json_t *curve, *point;
    bool marked = false;
    json_print(root,
               "\nseeds: {seeds:.0f}; of these, the median of times and the geometric mean of errors\n");
    printf("%-10s %6s %10s %10s  %10s  %10s  %10s\n", "pattern", "spp", "cpu s", "clock s", titles[0],
           titles[1], titles[2]);
    json_array_foreach(json_object_get(root, "curves"), i, curve) {
        json_array_foreach(json_object_get(curve, "points"), k, point) marked |=
            print_point(json_text_at(curve, "pattern"), point);
    }
    if (marked)
        puts("* closer to the reference than its halves are to each other: in no slope or table below");
}

static void print_slopes(const json_t *root) {
    static const char *const clocks[BENCH_CLOCKS] = {"cpu", "clock"};
    size_t i;
    json_t *curve;
    printf("\nslope of ln error over ln seconds, and its 95 %% interval over seeds\n%-10s %6s  %18s  %18s  "
           "%18s\n",
           "pattern", "time", titles[0], titles[1], titles[2]);
    json_array_foreach(json_object_get(root, "curves"), i, curve) {
        for (int c = 0; c < BENCH_CLOCKS; ++c) {
            printf("%-10s %6s", json_text_at(curve, "pattern"), clocks[c]);
            for (converge_metric m = 0; m < CONVERGE_METRICS; ++m) {
                const json_t *of = json_at(json_at(curve, "slopes"), converge_metric_name(m));
                of = json_at(of, bench_clock_names[c]);
                bench_print_slope(json_at(of, "slope"), json_at(of, "half"), 18);
            }
            putchar('\n');
        }
    }
}

static void print_rows(const char *title, const char *at, const json_t *rows) {
    size_t i;
    json_t *row, *value;
    const char *key;
    if (!json_array_size(rows)) {
        printf("\n%s: the patterns have nothing in common here\n", title);
        return;
    }
    printf("\n%s\n%12s", title, at);
    for (fathom_pattern p = 0; p < CONVERGE_PATTERNS; ++p) printf(" %11s", converge_pattern_name(p));
    putchar('\n');
    json_array_foreach(rows, i, row) {
        const char *space = "";
        json_object_foreach(row, key, value) {
            printf("%s%*.3g", space, *space ? 11 : 12, json_number_value(value));
            space = " ";
        }
        putchar('\n');
    }
}

static void print(const json_t *root) {
    print_head(root);
    print_points(root);
    print_slopes(root);
    for (converge_metric m = 0; m < CONVERGE_METRICS; ++m) {
        const char *name = converge_metric_name(m);
        char title[80];
        snprintf(title, sizeof title, "%s in equal time", titles[m]);
        print_rows(title, "cpu s", json_at(json_at(root, "equalTime"), name));
        snprintf(title, sizeof title, "seconds of CPU time for equal %s", titles[m]);
        print_rows(title, titles[m], json_at(json_at(root, "equalError"), name));
    }
}

/* ---- stated errors ---- */

static json_t *pack_count(const coverage_count *c) {
    return json_of(JSON("values", c->values), JSON("held", c->held));
}

static void pack_coverage(const bench_error_settings *asked, const fathom_settings *settings,
                          const coverage_row *rows, unsigned count, uint32_t reference_spp, bool interrupted,
                          json_t *root) {
    json_t *list = json_array();
    for (unsigned i = 0; i < count; ++i) {
        const coverage_row *r = &rows[i];
        json_array_append_new(
            list, json_of(JSON("targetError", r->target), JSON("spp", r->spp), JSON("meanSpp", r->mean_spp),
                          JSON("seeds", r->seeds), JSON("light", r->light), JSON("t", r->t),
                          JSON("trusted", pack_count(&r->trusted)),
                          JSON("doubtful", pack_count(&r->doubtful)), JSON("alike", pack_count(&r->alike))));
    }
    json_add(root, JSON("scene", asked->all.scene), JSON("width", settings->width),
             JSON("height", settings->height), JSON("seed", asked->seed), JSON("referenceSpp", reference_spp),
             JSON("coverage", list), JSON("interrupted", interrupted));
}

static void print_part(double part, double of) {
    if (of > 0)
        printf(" %7.2f %%", 100 * part / of);
    else
        printf(" %9s", "-");
}

/* Pixels whose samples are all alike have no real interval, so they are listed separately. */
static void print_shares(const json_t *row) {
    const double trusted = json_number_at(row, "trusted.values"),
                 trusted_held = json_number_at(row, "trusted.held"),
                 doubtful = json_number_at(row, "doubtful.values"),
                 doubtful_held = json_number_at(row, "doubtful.held"),
                 alike = json_number_at(row, "alike.values"), all = trusted + doubtful;
    print_part(trusted_held + doubtful_held, all);
    print_part(trusted_held, trusted);
    print_part(doubtful, all);
    print_part(doubtful - doubtful_held, doubtful);
    print_part(alike, all + alike);
    print_part(json_number_at(row, "alike.held"), alike);
    putchar('\n');
}

static void print_coverage(const json_t *root) {
    size_t i;
    json_t *row;
    print_name(stdout, json_text_at(root, "scene"));
    json_print(
        root,
        ", reference of {referenceSpp:.0f} samples a pixel\nhow often the stated 95 % interval of a pixel's "
        "value holds the truth: of all, and of those that error.doubt\ntrusts; the fraction that it marks, "
        "and how often these fail; pixels whose samples are all equal (alike) are separate\n");
    printf("%8s %8s %6s %8s %7s %9s %9s %9s %9s %9s %9s\n", "target", "spp", "seeds", "light", "t", "all",
           "trusted", "doubtful", "of it fail", "alike", "of it hold");
    json_array_foreach(json_object_get(root, "coverage"), i, row) {
        json_print(row, "{targetError:8.2g} {meanSpp:8.1f} {seeds:6.0f} {light:8.4f} {t:7.2f}");
        print_shares(row);
    }
}

static bool on_progress(void *user, double fraction) {
    bench_progress_tell(user, fmin(fraction, 1));
    return !interrupt_asked();
}

static fathom_status open_stage(fathom_context *context, const bench_settings *asked, bench_stage *stage) {
    fathom_status status = asked->tracer ? fathom_tracer_check(context, asked->tracer) : FATHOM_OK;
    if (status == FATHOM_OK) status = bench_open(context, asked, false, stage);
    if (status == FATHOM_OK && asked->tracer) stage->settings.tracer = asked->tracer;
    return status;
}

static uint32_t half_spp(const bench_error_settings *asked) {
    if (asked->half_spp) return asked->half_spp;
    return asked->max_spp < 65536 / 4 ? 4 * asked->max_spp : 65536;
}

static fathom_status converge(fathom_context *context, const bench_error_settings *asked,
                              const bench_stage *stage, converge_result *result) {
    const converge_options options = {.rounds = asked->seeds,
                                      .max_spp = asked->max_spp,
                                      .half_spp = half_spp(asked),
                                      .seed = asked->seed,
                                      .ppd = asked->ppd,
                                      .progress = on_progress};
    interrupt_keep_work(true);
    fathom_status status = converge_measure(context, stage, &options, result);
    interrupt_keep_work(false);
    progress_clear_line();
    return status;
}

static fathom_status measure_coverage(fathom_context *context, const bench_error_settings *asked,
                                      json_t *root) {
    bench_stage stage = {.scene = NULL};
    coverage_row rows[COVERAGE_ROWS];
    unsigned count = 0;
    const coverage_options options = {.seeds = asked->seeds,
                                      .max_spp = asked->max_spp,
                                      .reference_spp = half_spp(asked),
                                      .seed = asked->seed,
                                      .progress = on_progress};
    if (asked->all.csv || asked->all.report || asked->ppd != FLIP_PPD)
        return fail(context, FATHOM_BAD_USAGE, "--adaptive: no --csv, --report or --ppd; expected --json");
    fathom_status status = open_stage(context, &asked->all, &stage);
    interrupt_keep_work(true);
    if (status == FATHOM_OK) status = coverage_measure(context, &stage, &options, rows, &count);
    interrupt_keep_work(false);
    progress_clear_line();
    if (status == FATHOM_OK || (status == FATHOM_INTERRUPTED && count)) {
        pack_coverage(asked, &stage.settings, rows, count, options.reference_spp,
                      status == FATHOM_INTERRUPTED, root);
        if (!asked->all.common.quiet) print_coverage(root);
    }
    stage_close(&stage);
    return status;
}

static fathom_status measure(fathom_context *context, const void *settings, json_t *root) {
    const bench_error_settings *asked = settings;
    if (asked->adaptive) return measure_coverage(context, asked, root);
    bench_stage stage = {.scene = NULL};
    converge_result result = {.rounds = 0};
    fathom_status status = open_stage(context, &asked->all, &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage);
    if (status == FATHOM_OK) status = converge(context, asked, &stage, &result);
    if (status == FATHOM_OK) status = fathom_scene_check_files(stage.scene);
    const bool interrupted = status == FATHOM_INTERRUPTED && result.runs.count;
    if (status == FATHOM_OK || interrupted) {
        pack(asked, &stage, &result, interrupted, root);
        if (!asked->all.common.quiet) print(root);
    }
    if (interrupted)
        status = fail(context, FATHOM_INTERRUPTED,
                      "interrupted; the results are of %u of %u seeds, to %u samples a pixel", result.rounds,
                      asked->seeds, 1u << (2 * (result.steps - 1)));
    converge_free(&result);
    stage_close(&stage);
    return status;
}

#define FIELD(name) offsetof(bench_error_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    BENCH_SIZE,
    {"seeds", 0, "N", take_u32, FIELD(seeds), 1, CONVERGE_SEEDS_MAX,
     "number of seeds: images of each pattern and spp (3)"},
    {"seed", 0, "N", take_u64, FIELD(seed), 0, HUGE_VAL, "the first seed; the others follow (0)"},
    {"max-spp", 0, "N", take_u32, FIELD(max_spp), 1, 65536,
     "maximum samples per pixel: measures 1, 4, 16 and so on up to it (1024)"},
    {"reference-spp", 0, "N", take_u32, FIELD(half_spp), 1, 65536,
     "samples per pixel of each half of the reference (four times --max-spp)"},
    {"ppd", 0, "N", take_f64, FIELD(ppd), FLIP_PPD_LEAST, FLIP_PPD_MOST,
     "pixels per degree of the viewer's eye, for FLIP (67: a 4K screen 0.7 m wide, from 0.7 m "
     "away)"},
    {"adaptive", 0, NULL, take_true, FIELD(adaptive), 0, 0,
     "check the errors that renders state instead: with a fixed number of samples, and sampling "
     "to an error"},
    {"tracer", 0, "SPEC", take_text, BENCH_FIELD(tracer), 0, 0, "tracer (the scene's, else embree)"},
    COMMAND_THREADS,
    COMMAND_ALLOW_OUTSIDE,
    BENCH_RESULTS,
};

const command command_bench_error = {
    .name = "bench error",
    .usage = "SCENE [options]",
    .summary = "Measure image error against run time.",
    .text = "Renders the scene with each antialiasing pattern (grid, stratified, sobol) at 1,\n"
            "4, 16, ... samples per pixel, and compares each image with a reference:\n"
            "  RMSE    root of the mean squared difference of linear values\n"
            "  relMSE  mean of difference^2 / (reference^2 + 0.01)\n"
            "  FLIP    how visible the difference is when flipping between the two, 0 to 1\n"
            "Pixels that are not finite are counted: they make RMSE and relMSE infinite, and\n"
            "count as 1 in FLIP. The reference is the mean of two independent halves, whose\n"
            "difference gives its error. If an image is closer to the reference than the\n"
            "halves are to each other, it is marked, and is not in slopes and tables.\n"
            "Times are of rendering alone: the scene is read and built once, before. A slope\n"
            "is the mean over the seeds of a least-squares fit of ln error over ln seconds,\n"
            "with Student's t s / sqrt(n) as its interval. With classic and a pinhole, the\n"
            "grid has no seed, so its interval comes from times alone. Tables go by the CPU\n"
            "time of all threads: it is more reliable on a shared machine than elapsed time.\n"
            "With --adaptive, every seed is rendered to errors of 0.1 and 0.05 with at most\n"
            "--max-spp samples per pixel; if SCENE is path-traced, also with 16 and with 64\n"
            "samples in each pixel. The results: how often the stated 95 % interval of a\n"
            "value contains the value of the reference; how often it does not where\n"
            "error.doubt marks the pixel; and how far the mean of all images is from the\n"
            "reference (t: that distance over its standard error, which few seeds estimate\n"
            "badly).\n"
            "Ctrl-C stops and writes the results of the seeds that are complete, or of the\n"
            "samples of the first seed that all patterns have; the exit code is 5.\n",
    .examples = "  fathom bench error scenes/example.json --size 480x270 --report results\n"
                "  fathom bench error forest.glb --seeds 5 --max-spp 256 --csv forest.csv\n",
    .args = {options, {{"SCENE", BENCH_FIELD(scene)}}},
    COMMAND_BODY(bench_run, bench_error_settings,
                 {.all = {.command = &command_bench_error, .measure = measure, .table = &csv},
                  .seeds = 3,
                  .max_spp = 1024,
                  .ppd = FLIP_PPD}),
};
