#include "cli/render/sequence.h"

#include "cli/interrupt.h"

#include "base/clock.h"

#include <stdio.h>

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

static void tell_nobody(void *user, const char *text) { (void)user, (void)text; }

/* Where the automatic camera is at a time; made == false: there is nothing to see, or an error, which is
 * reported when frames are rendered. */
static fathom_framing look_at(const task *frame, double time) {
    fathom_framing framing = {.size = sizeof framing};
    task s = {.options = frame->options, .framing = framing};
    if (command_context(s.options.threads, &s.context) != FATHOM_OK) return framing;
    fathom_context_allow_outside(s.context, s.options.allow_outside);
    fathom_context_on_warning(s.context, tell_nobody, NULL);
    s.options.model.time = (args_f64){.given = true, .value = time};
    if (task_read(&s) == FATHOM_OK) fathom_scene_framing(s.scene, &framing);
    fathom_scene_destroy(s.scene);
    fathom_context_destroy(s.context);
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

/* All frames get the camera and the exposure of the first; another exposure would flicker. */
fathom_status sequence_run(task *all) {
    const render_frames *frames = &all->options.frames;
    frame_names room;
    warning_list said = {.count = 0};
    fathom_status status = FATHOM_OK;
    task s;
    all->said = &said, all->frame_all = frame_all;
    for (uint32_t frame = frames->first; frame <= frames->last && status == FATHOM_OK; ++frame) {
        interrupt_keep_work(false);
        status = begin_frame(all, frame, &room, &s);
        if (status == FATHOM_OK) status = task_run(&s);
        if (status == FATHOM_OK) note_finished(&all->options, frame);
        all->framing = s.framing, all->frame_all = NULL;
        if (s.options.part.path) continue;
        all->options.exposure = EXPOSURE_GIVEN;
        all->options.write.exposure = s.options.write.exposure;
    }
    if (status == FATHOM_OK) saving_forget(&all->options);
    warnings_free(&said);
    return status;
}
