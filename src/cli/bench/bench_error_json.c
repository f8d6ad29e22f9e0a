#include "cli/bench/bench_error.h"

#include "cli/json_text.h"

#include <math.h>

static const char *const clock_names[BENCH_CLOCKS] = {"cpu", "wall"};

/* JSON has no infinity and no NaN. */
static json_t *real(double x) { return isfinite(x) ? json_real(x) : json_null(); }

static void set_seconds(json_t *object, const bench_seconds *s) {
    json_object_set_new(object, "cpuSeconds", real(s->by[BENCH_CPU]));
    json_object_set_new(object, "seconds", real(s->by[BENCH_WALL]));
}

static void set_errors(json_t *object, const double errors[CONVERGE_METRICS]) {
    for (int m = 0; m < CONVERGE_METRICS; ++m)
        json_object_set_new(object, converge_metric_name((converge_metric)m), real(errors[m]));
}

static json_t *pack_errors(const double errors[CONVERGE_METRICS]) {
    json_t *object = json_object();
    set_errors(object, errors);
    return object;
}

static json_t *pack_reference(const converge_reference *r) {
    json_t *object = json_pack("{s:s, s:i, s:o, s:o, s:o, s:o}", "pattern", "sobol", "halves", 2, "sppOfEach",
                               json_count(r->spp), "ownError", pack_errors(r->own), "betweenHalves",
                               pack_errors(r->halves), "notFinite", json_count(r->nonfinite));
    set_seconds(object, &r->seconds);
    return object;
}

static json_t *pack_run(const converge_run *run, uint64_t seed) {
    json_t *object =
        json_pack("{s:s, s:o, s:o, s:o, s:o}", "pattern", converge_pattern_name(run->pattern), "spp",
                  json_count((uint64_t)1 << (2 * run->step)), "seed", json_count(seed + run->round), "rays",
                  json_count(run->rays), "notFinite", json_count(run->nonfinite));
    set_seconds(object, &run->seconds);
    set_errors(object, run->errors);
    return object;
}

static json_t *pack_point(const converge_point *point) {
    json_t *below = json_array();
    for (int m = 0; m < CONVERGE_METRICS; ++m) {
        if (point->below[m])
            json_array_append_new(below, json_string(converge_metric_name((converge_metric)m)));
    }
    json_t *object = json_pack("{s:o, s:o}", "spp", json_count(point->spp), "belowReference", below);
    set_seconds(object, &point->seconds);
    set_errors(object, point->errors);
    return object;
}

static json_t *pack_slopes(const converge_slope slopes[BENCH_CLOCKS]) {
    json_t *object = json_object();
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        const converge_slope *s = &slopes[c];
        json_object_set_new(object, clock_names[c],
                            json_pack("{s:o, s:o, s:o, s:o}", "slope", real(s->slope.mean), "half",
                                      real(s->slope.half), "scale", real(s->scale), "points",
                                      json_count(s->points)));
    }
    return object;
}

static json_t *pack_curve(const converge_result *result, const converge_curve *curve) {
    json_t *points = json_array(), *slopes = json_object();
    for (unsigned step = 0; step < result->steps; ++step)
        json_array_append_new(points, pack_point(&curve->points[step]));
    for (int m = 0; m < CONVERGE_METRICS; ++m)
        json_object_set_new(slopes, converge_metric_name((converge_metric)m), pack_slopes(curve->slopes[m]));
    return json_pack("{s:s, s:o, s:o}", "pattern", converge_pattern_name(curve->pattern), "points", points,
                     "slopes", slopes);
}

static json_t *pack_rows(const converge_row *rows, size_t count, const char *at) {
    json_t *list = json_array();
    for (size_t i = 0; i < count; ++i) {
        json_t *row = json_pack("{s:o}", at, real(rows[i].at));
        for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
            json_object_set_new(row, converge_pattern_name((fathom_pattern)p), real(rows[i].values[p]));
        json_array_append_new(list, row);
    }
    return list;
}

static void set_tables(json_t *root, const converge_result *result) {
    json_t *time = json_object(), *error = json_object();
    converge_row rows[CONVERGE_ROWS];
    for (int m = 0; m < CONVERGE_METRICS; ++m) {
        const char *name = converge_metric_name((converge_metric)m);
        size_t count = converge_equal_time(result, (converge_metric)m, rows);
        json_object_set_new(time, name, pack_rows(rows, count, "cpuSeconds"));
        count = converge_equal_error(result, (converge_metric)m, rows);
        json_object_set_new(error, name, pack_rows(rows, count, "error"));
    }
    json_object_set_new(root, "equalTime", time);
    json_object_set_new(root, "equalError", error);
}

json_t *bench_error_json(const bench_error_settings *asked, const bench_stage *stage,
                         const converge_result *result) {
    json_t *root = bench_head("error"), *runs = json_array(), *curves = json_array(), *built = json_object();
    bench_head_tracer(root, trace_name(stage->tracer));
    set_seconds(built, &stage->build);
    for (size_t i = 0; i < result->runs.count; ++i)
        json_array_append_new(runs, pack_run(&result->runs.items[i], asked->seed));
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
        json_array_append_new(curves, pack_curve(result, &result->curves[p]));
    json_object_set_new(root, "scene", json_text(asked->scene));
    json_object_set_new(root, "tracer", json_text(trace_name(stage->tracer)));
    json_object_set_new(root, "width", json_count(stage->settings.width));
    json_object_set_new(root, "height", json_count(stage->settings.height));
    json_object_set_new(root, "seeds", json_count(result->rounds));
    json_object_set_new(root, "ppd", real(asked->ppd));
    json_object_set_new(root, "build", built);
    json_object_set_new(root, "reference", pack_reference(&result->reference));
    json_object_set_new(root, "runs", runs);
    json_object_set_new(root, "curves", curves);
    set_tables(root, result);
    return root;
}

/* An error that is not finite is "inf": it must not look like one that was not measured. */
static void put_value(FILE *out, const json_t *run, const char *key) {
    double x = bench_number(run, key, NULL);
    fprintf(out, isnan(x) ? ",inf" : ",%.9g", x);
}

void bench_error_csv(FILE *out, const json_t *root) {
    fputs("pattern,spp,seed,cpu_seconds,seconds,rays,rmse,relmse,flip,not_finite\n", out);
    static const char *const keys[] = {"spp",  "seed",   "cpuSeconds", "seconds",  "rays",
                                       "rmse", "relmse", "flip",       "notFinite"};
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(root, "runs"), i, run) {
        fputs(json_string_value(json_object_get(run, "pattern")), out);
        for (size_t k = 0; k < sizeof keys / sizeof *keys; ++k) put_value(out, run, keys[k]);
        fputc('\n', out);
    }
}
