#include "cli/render/sequence.h"

#include "cli/interrupt.h"
#include "cli/render/brightness.h"
#include "cli/render/trial.h"

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
    if (!s.options.quiet && s.options.write.exposure != 0)
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
