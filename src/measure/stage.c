#include "measure/stage.h"

#include "base/clock.h"
#include "job/job.h"
#include "measure/replay.h"

#include <string.h>

bench_seconds bench_now(void) { return (bench_seconds){{clock_process_seconds(), clock_seconds()}}; }

bench_seconds bench_since(const bench_seconds *start) {
    bench_seconds s = bench_now();
    for (int c = 0; c < BENCH_CLOCKS; ++c) s.by[c] -= start->by[c];
    return s;
}

fathom_status stage_open(fathom_context *context, fathom_scene *scene, const fathom_settings *settings,
                         bench_stage *out) {
    *out = (bench_stage){.scene = scene, .settings = *settings};
    out->settings.aovs = 0;
    memset(out->settings.crop, 0, sizeof out->settings.crop);
    fathom_status status = scene_check_settings(context, &out->settings);
    if (status == FATHOM_OK) status = fathom_scene_check(scene);
    if (status == FATHOM_OK) status = world_create(scene, &out->world);
    if (status == FATHOM_OK) status = world_check(out->world);
    return status;
}

fathom_status stage_build(fathom_context *context, bench_stage *stage) {
    const trace_options options = {.words = stage->settings.tracer,
                                   .timed = stage->settings.integrator != FATHOM_INTEGRATOR_CLASSIC,
                                   .width = stage->settings.block_width,
                                   .threads = fathom_context_threads(context)};
    bench_seconds start = bench_now();
    fathom_status status = trace_create(context, stage->world, &options, &stage->tracer);
    stage->build = bench_since(&start);
    return status;
}

void stage_close(bench_stage *stage) {
    trace_destroy(stage->tracer);
    world_destroy(stage->world);
    fathom_scene_destroy(stage->scene);
    memset(stage, 0, sizeof *stage);
}

fathom_status stage_film(fathom_context *context, const world *w, const trace_tracer *tracer,
                         const fathom_settings *settings, const job_options *options, fathom_film *film,
                         record *recorded, stage_cost *cost) {
    render_plan *plan;
    job_result result = {.samples = 0};
    const double began = clock_seconds();
    fathom_status status = plan_create(context, w, tracer, settings, NULL, NULL, &plan);
    if (status != FATHOM_OK) return status;
    if (recorded) record_clear(recorded);
    const bench_seconds start = bench_now();
    status = job_run(context, plan, options, film, &result);
    *cost = (stage_cost){start.by[BENCH_WALL] - began, bench_since(&start), result.rays};
    plan_destroy(plan);
    return status;
}

fathom_status stage_render(fathom_context *context, const bench_stage *stage, const stage_shot *shot,
                           fathom_progress_fn progress, void *user, float *rgb, stage_cost *cost) {
    fathom_settings settings = stage->settings;
    settings.pattern = shot->pattern, settings.spp = shot->spp, settings.seed = shot->seed;
    settings.target_error = settings.max_time = 0; /* the same number of samples everywhere */
    fathom_film *film;
    fathom_status status = scene_check_settings(context, &settings);
    if (status == FATHOM_OK) status = film_create(context, stage->scene, &settings, &film);
    if (status != FATHOM_OK) return status;
    const job_options options = {.progress = progress, .user = user};
    status = stage_film(context, stage->world, stage->tracer, &settings, &options, film, NULL, cost);
    size_t pixels = (size_t)film->width * film->height;
    for (size_t c = 0; c < 3 && rgb; ++c) memcpy(rgb + c * pixels, film->rgb[c], pixels * sizeof *rgb);
    fathom_film_destroy(film);
    return status;
}
