/* The frames of an animation, one image each. */
#include "cli/interrupt.h"
#include "cli/render/brightness.h"
#include "cli/render/progress.h"
#include "cli/render/task.h"

#include "base/clock.h"

#include <stdio.h>
#include <string.h>

/* ---- trial runs: they find what all frames share, the camera and the exposure. They report no problems of
 * the scene, because the frames do. ---- */

/* Gives the task of a trial run a context. False: out of memory. */
static bool trial_open(task *s) {
    if (command_context(&s->options.common, &s->context) != FATHOM_OK) return false;
    fathom_context_on_warning(s->context, NULL, NULL);
    return true;
}

/* Destroys all but the options and the framing. */
static void trial_close(task *s) {
    fathom_film_destroy(s->film);
    warnings_free(&s->report.warnings);
    fathom_scene_destroy(s->scene);
    fathom_context_destroy(s->context);
}

/* The longer side of the small image in pixels, at most, and its samples. */
enum { SIDE = 160, SAMPLES = 16 };

static void make_small(fathom_settings *s) {
    const uint32_t longer = s->width > s->height ? s->width : s->height, by = (longer + SIDE - 1) / SIDE;
    s->width = (s->width + by - 1) / by, s->height = (s->height + by - 1) / by;
    memset(s->crop, 0, sizeof s->crop);
    s->spp = SAMPLES, s->target_error = 0, s->max_time = 0;
    s->aovs &= FATHOM_AOV_ALPHA, s->fireflies = FATHOM_FIREFLIES_KEEP;
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
    return fathom_render(s->context, s->scene, &o->settings, interrupt_go_on, NULL, NULL, &s->film);
}

/* Renders a small image to choose the exposure, and sets `framing` as running the task does; then closes
 * the task. Warns if the exposure had to change. False: nothing in view is lit, or an error. */
static bool trial_exposure(task *s) {
    if (!trial_open(s)) return false;
    interrupt_install();
    interrupt_install_save();
    progress_begin(s->options.common.quiet, "render");
    progress_phase(FATHOM_PHASE_READ);
    const bool settled = task_read_framed(s) == FATHOM_OK && render_small(s) == FATHOM_OK &&
                         brightness_settle(&s->report.warnings, NULL, s->options.scene, s->film, &s->options);
    trial_close(s);
    progress_clear_line();
    return settled;
}

/* ---- frames ---- */

static fathom_status begin_frame(const task *all, uint32_t frame, frame_names *room, task *out) {
    fathom_settings settings;
    args_problem problem;
    *out = *all;
    out->start = clock_seconds();
    fathom_settings_default(&settings);
    const bool fine = render_options_frame(&out->options, frame, room, &problem) &&
                      render_options_finish(&out->options, &settings, &problem);
    return fine ? FATHOM_OK : say_usage(&command_render, problem.text);
}

/* Where the automatic camera is at a time; made == false: there is nothing to see, or an error, which is
 * reported when frames are rendered. */
static fathom_framing look_at(const task *frame, double time) {
    fathom_framing framing = {.size = sizeof framing};
    task s = {.options = frame->options, .framing = framing};
    if (!trial_open(&s)) return framing;
    s.options.model.time = (args_f64){.given = true, .value = time};
    if (task_read(&s) == FATHOM_OK) fathom_scene_framing(s.scene, &framing);
    trial_close(&s);
    return framing;
}

/* Number of times at which the model is read to find how far it moves. */
enum { FRAMED_TIMES = 17 };

/* Finds a camera that sees all of the animation, and a floor below all of it, so that frames rendered by
 * other commands have the same. */
static void frame_all(task *s, const double span[2]) {
    for (int i = 0; i < FRAMED_TIMES && !interrupt_asked(); ++i) {
        const fathom_framing framing = look_at(s, span[0] + (span[1] - span[0]) * i / (FRAMED_TIMES - 1));
        if (s->framing.made)
            fathom_framing_unite(&s->framing, &framing);
        else
            s->framing = framing;
    }
}

/* Two texts, because a signal may come while one is written. */
static void note_finished(const render_options *options, uint32_t last) {
    static char texts[2][96];
    char *text = texts[last % 2];
    snprintf(text, sizeof *texts, "interrupted; frames %u to %u are finished%s", options->frames.first, last,
             options->checkpoint ? "; --resume continues" : "");
    interrupt_say(text);
}

static void keep_exposure(const task *of, task *all) {
    if (!brightness_is_open(&all->options)) return;
    all->options.exposure = EXPOSURE_KEPT;
    all->options.write.exposure = of->options.write.exposure;
    all->options.part.exposure = &all->options.write.exposure;
}

/* All frames get the exposure of frame 0, which other commands also find; changes would flicker. */
static fathom_status settle_exposure(task *all, frame_names *room) {
    task s;
    const fathom_status status = begin_frame(all, 0, room, &s);
    if (status != FATHOM_OK || !brightness_is_open(&s.options)) return status;
    if (!trial_exposure(&s)) return FATHOM_OK;
    keep_exposure(&s, all);
    all->framing = s.framing, all->frame_all = NULL;
    if (!s.options.common.quiet && s.options.write.exposure != 0)
        printf("exposure %g, by frame 0\n", (double)s.options.write.exposure);
    return FATHOM_OK;
}

/* All frames get one camera. If frame 0 is black, the first frame that is lit decides on the exposure. */
fathom_status sequence_run(task *all) {
    const render_frames *frames = &all->options.frames;
    frame_names room;
    warning_list said = {.count = 0};
    task s;
    all->said = &said, all->frame_all = frame_all;
    fathom_status status = settle_exposure(all, &room);
    for (uint32_t frame = frames->first; frame <= frames->last && status == FATHOM_OK; ++frame) {
        interrupt_keep_work(false);
        status = begin_frame(all, frame, &room, &s);
        if (status == FATHOM_OK) status = task_run(&s);
        if (status == FATHOM_OK) note_finished(&all->options, frame);
        all->framing = s.framing, all->frame_all = NULL;
        if (s.exposed) keep_exposure(&s, all);
    }
    if (status == FATHOM_OK) saving_forget(&all->options);
    warnings_free(&said);
    return status;
}
