#include "measure/phases.h"

#include "integrate/plan.h"

#include <stdio.h>

typedef struct samples {
    double by[BENCH_CLOCKS][RENDER_TIME_REPEATS_MAX];
    unsigned count;
    bool warm;
} samples;

/* The first run is not counted: a virtual machine may get its memory only at first use, which takes seconds
 * per gigabyte. */
static void add(samples *s, const bench_seconds *start) {
    const bench_seconds cost = bench_since(start);
    for (int c = 0; c < BENCH_CLOCKS && s->warm; ++c) s->by[c][s->count] = cost.by[c];
    s->count += s->warm;
    s->warm = true;
}

/* True if the phase must run again. */
static bool again(const samples *s, const render_time_options *options) {
    double spent = 0;
    for (unsigned i = 0; i < s->count; ++i) spent += s->by[BENCH_WALL][i];
    return s->count == 0 || (s->count < options->repeats && spent < options->seconds);
}

static void finish(samples *s, quartiles out[BENCH_CLOCKS]) {
    for (int c = 0; c < BENCH_CLOCKS; ++c) out[c] = quartiles_of(s->by[c], s->count);
}

fathom_status phases_read(fathom_context *context, const char *path, const fathom_read_options *read,
                          const render_time_options *options, fathom_scene **scene,
                          quartiles out[BENCH_CLOCKS]) {
    samples s = {.count = 0};
    fathom_status status = FATHOM_OK;
    for (*scene = NULL; status == FATHOM_OK && again(&s, options);) {
        fathom_scene_destroy(*scene);
        *scene = NULL;
        const bench_seconds start = bench_now();
        status = fathom_scene_read_with(context, path, read, scene);
        add(&s, &start);
    }
    finish(&s, out);
    return status;
}

static fathom_status build_once(fathom_context *context, const fathom_scene *scene,
                                const fathom_settings *settings, const char *words, world **w,
                                trace_tracer **tracer) {
    const trace_options options = {.words = words,
                                   .timed = settings->integrator != FATHOM_INTEGRATOR_CLASSIC,
                                   .width = settings->block_width,
                                   .expected_rays = plan_expected_rays(scene, settings)};
    trace_destroy(*tracer);
    world_destroy(*w);
    *tracer = NULL, *w = NULL;
    fathom_status status = world_create(scene, w);
    if (status == FATHOM_OK) status = world_check(*w);
    return status == FATHOM_OK ? trace_create(context, *w, &options, tracer) : status;
}

/* Approximate fraction of the time that building takes. */
#define BUILT_UNTIL 0.3

fathom_status phases_measure(fathom_context *context, const fathom_scene *scene,
                             const fathom_settings *settings, const char *words,
                             const render_time_options *options, phases *out) {
    const bench_watch building = bench_watch_part(options->watch, 0, BUILT_UNTIL),
                      rendering = bench_watch_part(options->watch, BUILT_UNTIL, 1);
    render_time_options render = *options;
    render.watch = &rendering;
    samples s = {.count = 0};
    world *w = NULL;
    trace_tracer *tracer = NULL;
    fathom_status status = FATHOM_OK;
    fathom_context_set_threads(context, 0);
    while (status == FATHOM_OK && again(&s, options)) {
        const bench_seconds start = bench_now();
        status = build_once(context, scene, settings, words, &w, &tracer);
        add(&s, &start);
        bench_watch_tell(&building, s.count + s.warm, options->repeats + 1);
    }
    finish(&s, out->build);
    if (status == FATHOM_OK) {
        out->bvh_bytes = trace_bvh_bytes(tracer), out->peak_bytes = trace_peak_bytes(tracer);
        snprintf(out->tracer, sizeof out->tracer, "%s", trace_name(tracer));
        status = render_time_measure(context, w, tracer, settings, &render, &out->time);
    }
    trace_destroy(tracer);
    world_destroy(w);
    return status;
}
