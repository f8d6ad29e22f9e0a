#include "measure/growth.h"

#include "integrate/plan.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

typedef struct samples {
    double by[BENCH_CLOCKS][GROWTH_REPEATS_MAX];
    unsigned count;
    bool warm;
} samples;

/* The first time is left out: a virtual machine's memory may be given to it only when it is first used, at
 * some seconds a gigabyte. */
static void add(samples *s, const bench_seconds *cost) {
    if (!s->warm) {
        s->warm = true;
        return;
    }
    for (int c = 0; c < BENCH_CLOCKS; ++c) s->by[c][s->count] = cost->by[c];
    ++s->count;
}

/* Whether the phase is to be run again. */
static bool again(const samples *s, const growth_options *options) {
    double spent = 0;
    for (unsigned i = 0; i < s->count; ++i) spent += s->by[BENCH_WALL][i];
    return s->count == 0 || (s->count < options->repeats && spent < options->seconds);
}

static void finish(samples *s, quartiles out[BENCH_CLOCKS]) {
    for (int c = 0; c < BENCH_CLOCKS; ++c) out[c] = quartiles_of(s->by[c], s->count);
}

/* Shares of the time, roughly: rendering takes most of a small mesh's, building most of a large one's. */
#define READ_UNTIL 0.1
#define BUILT_UNTIL 0.5

static void tell(const growth_options *options, const samples *s, double from, double to) {
    const bench_watch part = bench_watch_part(options->watch, from, to);
    bench_watch_tell(&part, s->count + s->warm, options->repeats + 1);
}

/* The scene that was read last stays. */
static fathom_status time_reading(fathom_context *context, const char *path, const growth_options *options,
                                  fathom_scene **scene, growth_point *out) {
    samples s = {.count = 0};
    const fathom_read_options read = {.width = options->width, .height = options->height};
    while (again(&s, options)) {
        fathom_scene_destroy(*scene);
        *scene = NULL;
        bench_seconds start = bench_now();
        fathom_status status = fathom_scene_read_with(context, path, &read, scene);
        if (status != FATHOM_OK) return status;
        bench_seconds cost = bench_since(&start);
        add(&s, &cost);
        tell(options, &s, 0, READ_UNTIL);
    }
    finish(&s, out->read);
    return FATHOM_OK;
}

static fathom_status build_once(fathom_context *context, const fathom_scene *scene,
                                const fathom_settings *settings, world **w, trace_tracer **tracer) {
    const trace_options options = {.width = settings->block_width,
                                   .expected_rays = plan_expected_rays(scene, settings)};
    render_plan *plan = NULL;
    fathom_status status = world_create(scene, w);
    if (status == FATHOM_OK) status = world_check(*w);
    if (status == FATHOM_OK) status = trace_create(context, *w, &options, tracer);
    if (status == FATHOM_OK) status = plan_create(context, *w, *tracer, settings, &plan);
    plan_destroy(plan);
    return status;
}

static fathom_status time_building(fathom_context *context, const fathom_scene *scene,
                                   const fathom_settings *settings, const growth_options *options, world **w,
                                   trace_tracer **tracer, growth_point *out) {
    samples s = {.count = 0};
    while (again(&s, options)) {
        trace_destroy(*tracer);
        world_destroy(*w);
        *tracer = NULL, *w = NULL;
        bench_seconds start = bench_now();
        fathom_status status = build_once(context, scene, settings, w, tracer);
        if (status != FATHOM_OK) return status;
        bench_seconds cost = bench_since(&start);
        add(&s, &cost);
        tell(options, &s, READ_UNTIL, BUILT_UNTIL);
    }
    finish(&s, out->build);
    out->bvh_bytes = trace_bvh_bytes(*tracer), out->peak_bytes = trace_peak_bytes(*tracer);
    snprintf(out->tracer, sizeof out->tracer, "%s", trace_name(*tracer));
    return FATHOM_OK;
}

static fathom_status measure_scene(fathom_context *context, const fathom_scene *scene,
                                   const growth_options *options, growth_point *out) {
    const bench_watch rendering = bench_watch_part(options->watch, BUILT_UNTIL, 1);
    const render_time_options times = {options->repeats, {1}, 1, options->record_bytes, &rendering};
    fathom_settings settings;
    world *w = NULL;
    trace_tracer *tracer = NULL;
    fathom_scene_settings(scene, &settings);
    settings.width = options->width, settings.height = options->height, settings.spp = 1;
    out->triangles = scene_triangles(scene);
    fathom_status status = time_building(context, scene, &settings, options, &w, &tracer, out);
    if (status == FATHOM_OK) status = render_time_measure(context, w, tracer, &settings, &times, &out->time);
    trace_destroy(tracer);
    world_destroy(w);
    return status;
}

fathom_status growth_measure(fathom_context *context, const char *path, const growth_options *options,
                             growth_point *out) {
    fathom_scene *scene = NULL;
    struct stat info;
    *out = (growth_point){.file_bytes = stat(path, &info) == 0 ? (uint64_t)info.st_size : 0};
    fathom_context_set_threads(context, 0);
    fathom_status status = time_reading(context, path, options, &scene, out);
    if (status == FATHOM_OK) status = measure_scene(context, scene, options, out);
    fathom_scene_destroy(scene);
    return status;
}

growth_fit growth_fit_of(const double *triangles, const double *seconds, size_t count) {
    double *x = malloc(2 * (count + 1) * sizeof *x);
    growth_fit fit = {(double)NAN, INFINITY, (double)NAN, 0};
    if (!x) return fit;
    double *y = x + count;
    for (size_t i = 0; i < count; ++i) {
        if (!(triangles[i] > 0) || !(seconds[i] > 0)) continue;
        x[fit.count] = log(triangles[i]), y[fit.count++] = log(seconds[i]);
    }
    line_fit line = line_through(x, y, fit.count);
    fit.exponent = line.slope, fit.scale = exp(line.intercept);
    fit.half = line_slope_half(x, y, fit.count);
    free(x);
    return fit;
}
