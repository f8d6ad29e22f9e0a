#include "cli/command.h"
#include "cli/fail.h"
#include "cli/interrupt.h"
#include "cli/outputs.h"
#include "cli/provenance.h"
#include "cli/render/brightness.h"
#include "cli/render/images.h"
#include "cli/render/progress.h"
#include "cli/render/saving.h"
#include "cli/render/stats.h"

#include "base/clock.h"

#include <fathom/file.h>
#include <fathom/ranks.h>
#include <fathom/session.h>
#include <fathom/survey.h>
#include <stdlib.h>

/* One run of the command. */
typedef struct task {
    fathom_context *context;
    double start; /* start of the command */
    render_options options;
    fathom_scene *scene;
    fathom_film *film;
    render_report report;
    saving saving;
    fathom_ranks ranks;     /* a single one without --mpi */
    char *fetched;          /* folder of files received from rank 0; NULL: none */
    fathom_framing framing; /* of all frames, if the reader creates the camera */
    warning_list *said;     /* by earlier frames, which is not said again; NULL: there are no frames */
} task;

/* True for a rank of an MPI job that only renders; rank 0 does everything else. */
static bool is_other(const task *s) { return s->ranks.rank; }

static fathom_status say(const task *s, fathom_status status) {
    return say_status(&command_render, s->context, status);
}

/* ---- before rendering ---- */

static fathom_status check_outputs(task *s) {
    render_options *o = &s->options;
    const bool stats_file = o->stats && !outputs_is_standard(o->stats);
    const char *all[ARGS_LIST_MAX + 2];
    size_t count = 0;
    fathom_status status = standard_output_begin(s->context, &o->outputs, &o->stats, 1);
    if (status != FATHOM_OK) return status;
    for (; count < o->outputs.count; ++count) all[count] = o->outputs.items[count];
    if (stats_file) all[count++] = o->stats;
    if (o->checkpoint) all[count++] = o->checkpoint;
    if (o->part.path) all[count++] = o->part.path;
    status = outputs_check_distinct(s->context, all, count, o->scene);
    if (status == FATHOM_OK) status = images_check_partial(s->context, &o->outputs, all, count);
    if (status == FATHOM_OK && o->settings.fireflies == FATHOM_FIREFLIES_REWEIGHT)
        status = images_check_reweighted(s->context, &o->outputs, all, count);
    for (size_t i = 0; i < o->outputs.count && status == FATHOM_OK; ++i)
        status = fathom_write_check(s->context, o->outputs.items[i], &o->write);
    if (status == FATHOM_OK && stats_file) status = fathom_file_check(s->context, o->stats);
    if (status == FATHOM_OK && o->part.path) status = fathom_file_check(s->context, o->part.path);
    if (status == FATHOM_OK) status = saving_check(s->context, o);
    for (size_t i = 0; i < count && status == FATHOM_OK; ++i) fathom_file_remove_left_over(all[i]);
    if (status == FATHOM_OK) images_remove_left_over(&o->outputs);
    return status;
}

static fathom_status read_scene(task *s) {
    const render_options *o = &s->options;
    fathom_read_options read = command_read_options(&o->model);
    read.without_uvs = true;
    read.floor = !o->no_floor && !o->background.given && !(o->settings.aovs & FATHOM_AOV_ALPHA);
    read.environment = o->environment;
    read.environment_rotation = o->environment_rotation * (3.14159265358979323846 / 180);
    read.width = o->size.width, read.height = o->size.height;
    read.framing = &s->framing;
    read.choose_integrator = render_options_give(o, "integrator"), read.integrator = o->asked.integrator;
    read.own_spp = render_options_give(o, "spp");
    const double began = clock_seconds();
    fathom_status status = o->mpi ? fathom_ranks_read(s->context, &s->ranks, o->scene, &read, interrupt_asked,
                                                      &s->scene, &s->fetched)
                                  : fathom_scene_read_with(s->context, o->scene, &read, &s->scene);
    s->report.read_seconds = clock_seconds() - began;
    fathom_status free_again = fathom_file_protect(s->context, NULL, 0); /* to read the checkpoint */
    return status == FATHOM_OK ? free_again : status;
}

static fathom_status check_sizes(const task *s) {
    const fathom_settings *settings = &s->options.settings;
    const uint32_t *crop = settings->crop, width = crop[2] ? crop[2] - crop[0] : settings->width,
                   height = crop[2] ? crop[3] - crop[1] : settings->height;
    const args_list *outputs = &s->options.outputs;
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < outputs->count && status == FATHOM_OK; ++i)
        status = fathom_write_check_size(s->context, outputs->items[i], width, height);
    return status;
}

/* Overrides the settings of the scene's file with those of the command line. Errors of the combination, such
 * as a crop outside the scene's image, are wrong usage, because the scene itself has already been checked. */
static fathom_status merge_settings(task *s) {
    fathom_settings settings;
    args_problem problem;
    render_options *o = &s->options;
    fathom_scene_settings(s->scene, &settings);
    if (!render_options_finish(o, &settings, &problem))
        return cli_fail(s->context, FATHOM_BAD_USAGE, "%s", problem.text);
    if (settings.aovs & ~o->settings.aovs && !render_options_give(o, "aovs"))
        warnings_tell(&s->report.warnings, "%s: asks for AOVs that only .exr holds; they are left out",
                      o->scene);
    if (render_options_give(o, "min_spp") && !(o->settings.target_error > 0 || o->settings.max_time > 0))
        return cli_fail(s->context, FATHOM_BAD_USAGE,
                        "--min-spp: only with --target-error E or --max-time SECONDS");
    if (render_options_give(o, "min_weight") && o->settings.integrator != FATHOM_INTEGRATOR_CLASSIC)
        return cli_fail(s->context, FATHOM_BAD_USAGE, "--min-weight: only with --integrator classic");
    if (fathom_settings_check(s->context, &o->settings) != FATHOM_OK) return FATHOM_BAD_USAGE;
    return check_sizes(s);
}

/* Sets the time to the part of --max-time that is left for rendering and writing. */
static fathom_status set_time_left(task *s) {
    const double elapsed = clock_seconds() - s->start;
    render_options *o = &s->options;
    if (!(o->max_time > 0)) return FATHOM_OK;
    o->settings.max_time = o->max_time - elapsed;
    if (o->settings.max_time > 0) return FATHOM_OK;
    return cli_fail(s->context, FATHOM_BAD_USAGE,
                    "--max-time: %g s are too short: reading alone took %.2f s; give more time", o->max_time,
                    elapsed);
}

/* ---- writing ---- */

static void rescue(const task *s, const char *which) {
    images_rescue(s->context, s->film, standard_output_shown(&s->options.outputs, 0), which);
}

static void list_left_out(task *s) {
    left_out_list *list = &s->report.left_out;
    list->count = fathom_film_left_out(s->film, &list->items);
    list->no_helper = !images_need_helper(&s->options);
}

/* Call after writing. began: the time at which writing began. */
static fathom_status tell_stats(task *s, double began, fathom_status status) {
    const double end = clock_seconds();
    s->report.write_seconds = end - began;
    s->report.total_seconds = end - s->start;
    fathom_film_size(s->film, &s->report.width, &s->report.height);
    progress_clear_line();
    if (s->options.stats) {
        fathom_status stats = say(s, stats_write(s->context, &s->report, &s->options));
        if (status == FATHOM_OK) status = stats;
    }
    if (status == FATHOM_OK) stats_print(&s->report, &s->options);
    return status;
}

static fathom_status write_all(task *s) {
    progress_phase(FATHOM_PHASE_WRITE);
    list_left_out(s);
    const double began = clock_seconds();
    return tell_stats(s, began, images_write(s->context, s->film, &s->options));
}

static void tell_interrupted(const render_options *options) {
    char text[8192];
    const int room = sizeof text;
    int used = snprintf(text, sizeof text, "interrupted; the image is written as far as it got, to ");
    for (size_t i = 0; i < options->outputs.count && used >= 0 && used < room; ++i) {
        used += snprintf(text + used, (size_t)(room - used), "%s%s", i ? ", " : "",
                         standard_output_shown(&options->outputs, i));
    }
    if (options->checkpoint && used >= 0 && used < room)
        snprintf(text + used, (size_t)(room - used), "; --resume continues");
    say_error(text);
}

/* Writes the film, finished or not, with its warnings. */
static fathom_status finish(task *s) {
    const bool interrupted = s->report.interrupted;
    image_names *room = NULL;
    fathom_status status = interrupted ? images_rename(s->context, &s->options.outputs, &room) : FATHOM_OK;
    /* An unfinished film may still be black. */
    brightness_settle(&s->report.warnings, interrupted ? NULL : s->scene, s->options.scene, s->film,
                      &s->options);
    if (status == FATHOM_OK)
        status = write_all(s);
    else
        rescue(s, "the pixels");
    if (status == FATHOM_OK && !interrupted && s->saving.sequence && s->options.checkpoint)
        status = say(s, saving_keep(s->context, s->film, &s->options));
    status = saving_end(&s->saving, interrupted, status);
    if (status == FATHOM_OK && interrupted) {
        tell_interrupted(&s->options);
        status = FATHOM_INTERRUPTED;
    }
    free(room);
    return status;
}

static fathom_status finish_part(task *s) {
    list_left_out(s);
    fathom_status status = tell_stats(s, clock_seconds(), FATHOM_OK);
    if (!s->report.interrupted || status != FATHOM_OK) return status;
    char text[8192];
    snprintf(text, sizeof text,
             "interrupted; what is finished is in %s, and the same command goes on from it",
             s->options.part.path);
    say_error(text);
    return FATHOM_INTERRUPTED;
}

/* ---- rendering ---- */

static bool on_progress(void *user, const fathom_progress *progress) {
    task *s = user;
    if (progress->phase == FATHOM_PHASE_RENDER) {
        s->report.finished = progress->fraction;
        interrupt_keep_work(true);
    }
    saving_tick(&s->saving);
    progress_update(progress);
    return !interrupt_asked();
}

/* Reports why there is no image. Some errors name no file yet, for example errors in how the scene's parts
 * fit together. */
static fathom_status say_failure(task *s, fathom_status status) {
    if (status == FATHOM_BAD_INPUT || status == FATHOM_OUT_OF_RESOURCES)
        cli_fail_within(s->context, s->options.scene);
    say(s, status);
    if (s->film) rescue(s, "the pixels rendered until then, of which some may be wrong,");
    return status;
}

static fathom_status render(task *s) {
    const render_options *o = &s->options;
    saving_begin(o, &s->saving);
    const fathom_session_options options = {.size = sizeof options,
                                            .progress = on_progress,
                                            .user = s,
                                            .checkpoint = saving_request(&s->saving),
                                            .outputs = o->outputs.items,
                                            .output_count = is_other(s) ? 0 : o->outputs.count,
                                            .write = &o->write,
                                            .part = o->part.path ? &o->part : NULL,
                                            .ranks = o->mpi ? &s->ranks : NULL,
                                            .keep_changed = !o->part.path && !is_other(s)};
    s->report.stats.size = sizeof s->report.stats;
    fathom_status status =
        fathom_session_run(s->context, s->scene, &o->settings, &options, &s->report.stats, &s->film);
    if (status != FATHOM_OK && status != FATHOM_INTERRUPTED) return say_failure(s, status);
    if (is_other(s)) return status;
    interrupt_keep_work(true);
    s->report.interrupted = status == FATHOM_INTERRUPTED;
    s->report.finished = s->report.stats.finished;
    s->report.scene = fathom_scene_name(s->scene);
    return o->part.path ? finish_part(s) : finish(s);
}

static fathom_status join_ranks(task *s) {
    fathom_ranks_default(&s->ranks);
    return s->options.mpi ? fathom_mpi_open(s->context, &s->ranks) : FATHOM_OK;
}

static void warn_of_scene(void *user, const char *message) {
    task *s = user;
    warnings_keep(&s->report.warnings, message);
    if (!is_other(s)) (s->said ? warnings_say_once : warnings_say)(s->said, message);
}

static fathom_status prepare(task *s) {
    fathom_status status = join_ranks(s);
    if (status == FATHOM_OK && !is_other(s)) status = check_outputs(s);
    if (status != FATHOM_OK) return status;
    if (!is_other(s) && images_need_helper(&s->options)) fathom_image_prefetch();
    progress_begin(s->options.quiet || is_other(s));
    progress_phase(FATHOM_PHASE_READ);
    fathom_context_on_warning(s->context, warn_of_scene, s);
    status = read_scene(s);
    if (status == FATHOM_OK) status = merge_settings(s);
    if (status == FATHOM_OK && s->options.background.given)
        status = fathom_scene_set_background(s->scene, s->options.background.rgb);
    return status == FATHOM_OK ? set_time_left(s) : status;
}

static void tell_kept(const render_options *options) {
    progress_clear_line();
    for (size_t i = 0; i < options->outputs.count && !options->quiet; ++i) {
        print_name(stdout, options->outputs.items[i]);
        puts(": is kept, as an earlier run finished it");
    }
}

static fathom_status run_once(task *s) {
    fathom_status status = command_context(s->options.threads, &s->context);
    if (status != FATHOM_OK) return status;
    fathom_context_allow_outside(s->context, s->options.allow_outside);
    s->options.write.command = provenance_command();
    interrupt_install();
    interrupt_install_save();
    status = prepare(s);
    bool finished = false;
    if (status == FATHOM_OK) status = saving_find(s->context, s->scene, &s->options, &finished);
    say(s, status);
    if (finished)
        tell_kept(&s->options);
    else if (status == FATHOM_OK)
        status = render(s);
    fathom_film_destroy(s->film);
    fathom_mpi_close(status == FATHOM_OK);
    warnings_free(&s->report.warnings);
    fathom_scene_destroy(s->scene);
    fathom_ranks_remove(s->fetched);
    standard_output_end();
    fathom_context_destroy(s->context);
    return status;
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

static void tell_nobody(void *user, const char *text) { (void)user, (void)text; }

/* Reads the scene at a time. *framing: where the automatic camera is; *span: the times that frames should
 * share, equal if there are none. Errors are reported when frames are rendered. */
static void look_at(const task *all, double time, fathom_framing *framing, double span[2]) {
    frame_names room;
    task s;
    *framing = (fathom_framing){.size = sizeof *framing};
    span[0] = span[1] = 0;
    if (begin_frame(all, all->options.frames.first, &room, &s) != FATHOM_OK) return;
    if (command_context(s.options.threads, &s.context) != FATHOM_OK) return;
    fathom_context_allow_outside(s.context, s.options.allow_outside);
    fathom_context_on_warning(s.context, tell_nobody, NULL);
    s.options.model.time = (args_f64){.given = true, .value = time};
    s.framing = *framing; /* what other times need does not count */
    if (read_scene(&s) == FATHOM_OK && fathom_scene_framed_times(s.scene, span))
        fathom_scene_framing(s.scene, framing);
    fathom_scene_destroy(s.scene);
    fathom_context_destroy(s.context);
}

/* Number of times at which the model is read to find how far it moves. */
enum { FRAMED_TIMES = 17 };

/* Finds a camera that sees all of the animation, and a floor below all of it, so that frames rendered by
 * other commands have the same. */
static void frame_them(task *all) {
    fathom_framing framing;
    double span[2], own[2];
    look_at(all, 0, &all->framing, span);
    /* The first time is usually 0, which has just been read. */
    for (int i = span[0] < 0 ? 0 : 1; i < FRAMED_TIMES && span[0] < span[1] && !interrupt_asked(); ++i) {
        look_at(all, span[0] + (span[1] - span[0]) * i / (FRAMED_TIMES - 1), &framing, own);
        if (all->framing.made)
            fathom_framing_unite(&all->framing, &framing);
        else
            all->framing = framing;
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

/* All frames get the exposure of the first, to avoid flicker. */
static fathom_status run_frames(task *all) {
    const render_frames *frames = &all->options.frames;
    frame_names room;
    warning_list said = {.count = 0};
    task s;
    all->said = &said;
    fathom_status status = begin_frame(all, frames->first, &room, &s);
    if (status == FATHOM_OK) frame_them(all);
    for (uint32_t frame = frames->first; frame <= frames->last && status == FATHOM_OK; ++frame) {
        interrupt_keep_work(false);
        status = begin_frame(all, frame, &room, &s);
        if (status == FATHOM_OK) status = run_once(&s);
        if (status == FATHOM_OK) note_finished(&all->options, frame);
        if (s.options.part.path) continue;
        all->options.exposure = EXPOSURE_GIVEN;
        all->options.write.exposure = s.options.write.exposure;
    }
    if (status == FATHOM_OK) saving_forget(&all->options);
    warnings_free(&said);
    return status;
}

static fathom_status run(int argc, char **argv) {
    task s = {.start = clock_seconds(), .framing = {.size = sizeof s.framing}};
    fathom_settings settings;
    fathom_status status;
    args_problem problem;
    fathom_settings_default(&settings);
    render_options_default(&s.options);
    if (!command_parse(&command_render, argc, argv, &s.options, &status)) return status;
    if (frames_asked(&s.options.frames)) return run_frames(&s);
    if (!render_options_finish(&s.options, &settings, &problem))
        return say_usage(&command_render, problem.text);
    return run_once(&s);
}

const command command_render = {
    .name = "render",
    .usage = "SCENE -o IMAGE [-o IMAGE2 ...] [options]",
    .summary = "Render a scene to an image.",
    .text = "SCENE is scene JSON (.json) or a model: .glb, .gltf, .obj, .ply. A model without\n"
            "camera or lights gets a camera that frames it, and lights.\n"
            "Without --spp, path tracing samples each tile until its estimated error is\n"
            "0.02 (--target-error), with at most 1024 samples per pixel.\n"
            "Ctrl-C stops the render, writes the unfinished image to NAME.partial.EXT, keeps\n"
            "an existing NAME.EXT, and exits with code 5. So do SIGTERM, SIGHUP (a closed\n"
            "terminal) and SIGXCPU (ulimit -t).\n"
            "If an image cannot be written, its pixels go to NAME.rescue.exr next to it, or\n"
            "to the working folder, $TMPDIR or /tmp, and a message says where. The same holds\n"
            "for a scene whose files were changed while it was rendered: exit code 3.\n"
            "With --checkpoint FILE, a stopped or killed render can be continued: --resume.\n"
            "-o FILE.part renders a part of the image, on one of many machines. fathom merge\n"
            "joins the parts to an image with the same bits as a render on one machine.\n",
    .examples = "  fathom render bunny.obj -o bunny.png\n"
                "  fathom render scan.ply -o scan.png --up z --size 1080x1920\n"
                "  fathom render scene.json -o out.exr -o out.png --size 1920x1080 --spp 16\n"
                "  fathom render scene.json -o out.exr --aov Z,N,id --stats out.json\n"
                "  fathom render scene.json -o out.png --target-error 0.01\n"
                "  fathom render scene.json -o out.png --max-time 60\n"
                "  fathom render scene.json -o out.exr --checkpoint out.save --resume\n"
                "  fathom render walk.glb -o walk.####.exr --frames 1-48 --fps 24\n"
                "  fathom render scene.json -o p3.part --part 3/16\n"
                "  mpirun -n 8 fathom render scene.json -o out.exr --mpi\n",
    .args = {NULL, {{"SCENE", offsetof(render_options, scene)}}, 0, render_option_table},
    .run = run,
};
