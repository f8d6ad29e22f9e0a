#include "cli/bench/bench_run.h"

#include "cli/interrupt.h"
#include "cli/render/progress.h"

#include "base/clock.h"

fathom_status bench_run(const command *c, unsigned threads, bool outside, bench_measure measure,
                        const void *asked) {
    fathom_context *context;
    fathom_status status = command_context(threads, &context);
    if (status != FATHOM_OK) return status;
    fathom_context_allow_outside(context, outside);
    interrupt_install();
    status = measure(context, asked);
    progress_clear_line();
    say_status(c, context, status);
    fathom_context_destroy(context);
    return status;
}

/* ---- progress ---- */

/* An estimate from less than this, of the work or in seconds, would say little. */
#define SURE_FRACTION 0.01
#define SURE_SECONDS 5.0

static struct {
    double began; /* when measuring did; 0: not yet */
    bool estimated;
} state;

void bench_progress_begin(bool quiet) {
    state.began = 0;
    state.estimated = false;
    progress_begin(quiet);
    progress_call("measure");
    progress_phase(FATHOM_PHASE_READ);
}

void bench_progress_tell(void *unused, double fraction) {
    (void)unused;
    if (state.began <= 0) state.began = clock_seconds();
    const double seconds = clock_seconds() - state.began;
    if (!state.estimated && fraction > 0 && (fraction >= SURE_FRACTION || seconds >= SURE_SECONDS)) {
        state.estimated = true;
        progress_estimate(seconds / fraction);
    }
    progress_update(&(fathom_progress){FATHOM_PHASE_RENDER, fraction, 0, seconds});
}

bench_watch bench_progress_part(double from, double to) {
    return (bench_watch){bench_progress_tell, NULL, from, to};
}

/* ---- scenes ---- */

fathom_status bench_open(fathom_context *context, const char *path, args_size size, bench_stage *out) {
    fathom_scene *scene;
    fathom_settings settings;
    *out = (bench_stage){.scene = NULL};
    const fathom_read_options read = {.width = size.width, .height = size.height};
    fathom_status status = fathom_scene_read_with(context, path, &read, &scene);
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &settings);
    settings.spp = 1;
    settings.target_error = settings.max_time = 0;
    if (size.width) settings.width = size.width, settings.height = size.height;
    return stage_open(context, scene, &settings, out);
}

fathom_status bench_sphere(fathom_context *context, uint64_t triangles, fathom_scene **out) {
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.triangles = triangles;
    *out = NULL;
    fathom_status status = fathom_scene_create(context, out);
    return status == FATHOM_OK ? fathom_scene_generate(*out, FATHOM_ROOT, &options) : status;
}
