#include "cli/render/trial.h"

#include "cli/command.h"
#include "cli/interrupt.h"
#include "cli/render/brightness.h"
#include "cli/render/progress.h"

#include <string.h>

static void tell_nobody(void *user, const char *text) { (void)user, (void)text; }

bool trial_open(task *s) {
    if (command_context(s->options.threads, &s->context) != FATHOM_OK) return false;
    fathom_context_allow_outside(s->context, s->options.allow_outside);
    fathom_context_on_warning(s->context, tell_nobody, NULL);
    return true;
}

void trial_close(task *s) {
    fathom_film_destroy(s->film);
    warnings_free(&s->report.warnings);
    fathom_scene_destroy(s->scene);
    fathom_context_destroy(s->context);
}

/* ---- exposure ---- */

/* The longer side of the small image in pixels, at most, and its samples. */
enum { SIDE = 160, SAMPLES = 16 };

static void make_small(fathom_settings *s) {
    const uint32_t longer = s->width > s->height ? s->width : s->height, by = (longer + SIDE - 1) / SIDE;
    s->width = (s->width + by - 1) / by, s->height = (s->height + by - 1) / by;
    memset(s->crop, 0, sizeof s->crop);
    s->spp = SAMPLES, s->target_error = 0, s->max_time = 0;
    s->aovs &= FATHOM_AOV_ALPHA, s->fireflies = FATHOM_FIREFLIES_KEEP;
}

static bool go_on(void *user, const fathom_progress *progress) {
    (void)user, (void)progress;
    return !interrupt_asked();
}

static fathom_status render_small(task *s) {
    render_options *o = &s->options;
    fathom_settings settings;
    args_problem problem;
    fathom_scene_settings(s->scene, &settings);
    if (!render_options_finish(o, &settings, &problem)) return FATHOM_BAD_USAGE;
    make_small(&o->settings);
    const fathom_status status =
        o->background.given ? fathom_scene_set_background(s->scene, o->background.rgb) : FATHOM_OK;
    if (status != FATHOM_OK) return status;
    return fathom_render(s->context, s->scene, &o->settings, go_on, NULL, NULL, &s->film);
}

bool trial_exposure(task *s) {
    if (!trial_open(s)) return false;
    interrupt_install();
    interrupt_install_save();
    progress_begin(s->options.quiet);
    progress_phase(FATHOM_PHASE_READ);
    const bool settled = task_read_framed(s) == FATHOM_OK && render_small(s) == FATHOM_OK &&
                         brightness_settle(&s->report.warnings, NULL, s->options.scene, s->film, &s->options);
    trial_close(s);
    progress_clear_line();
    return settled;
}
