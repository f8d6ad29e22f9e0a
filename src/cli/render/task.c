#include "cli/render/task.h"

#include "cli/fail.h"
#include "cli/interrupt.h"
#include "cli/log.h"
#include "cli/outputs.h"
#include "cli/provenance.h"
#include "cli/render/brightness.h"
#include "cli/render/images.h"
#include "cli/render/progress.h"

#include "base/clock.h"
#include "base/text.h"

#include <fathom/file.h>
#include <fathom/survey.h>
#include <stdlib.h>

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
    if (status == FATHOM_OK) images_remove_left_over(&o->outputs);
    return status;
}

static void warn_of_scene(void *user, const char *message) {
    task *s = user;
    warnings_keep(&s->report.warnings, message);
    if (!is_other(s)) (s->said ? warnings_say_once : warnings_say)(s->said, message);
}

static void warn_of_options(task *s, const char *text) {
    char line[LOG_LENGTH];
    snprintf(line, sizeof line, "%s: %s", s->options.scene, text);
    text_disarm(line);
    warn_of_scene(s, line);
}

fathom_status task_read(task *s) {
    const render_options *o = &s->options;
    fathom_read_options read = command_read_options(&o->model);
    read.without_uvs = true;
    read.floor = !o->no_floor && !o->background.given && !(o->settings.aovs & FATHOM_AOV_ALPHA);
    read.no_studio = o->no_studio;
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
    fathom_framing framing = {.size = sizeof framing};
    if (o->no_floor && status == FATHOM_OK && fathom_scene_framing(s->scene, &framing) == FATHOM_OK &&
        !framing.made)
        warn_of_options(s, "has its own camera, so --no-floor has no effect");
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
        warn_of_options(s, "asks for AOVs that no -o FILE holds, as .exr does; they are left out");
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
    char name_room[PATH_MAX];
    const char *name;
    const int room = sizeof text;
    int used = snprintf(text, sizeof text, "interrupted; the unfinished image is written to ");
    for (size_t i = 0; used >= 0 && used < room && (name = images_shown(options, i, name_room)); ++i)
        used += snprintf(text + used, (size_t)(room - used), "%s%s", i ? ", " : "", name);
    if (options->checkpoint && used >= 0 && used < room)
        snprintf(text + used, (size_t)(room - used), "; --resume continues");
    log_line(LOG_ERROR, text);
}

/* Writes the film, finished or not, with its warnings. */
static fathom_status finish(task *s) {
    const bool interrupted = s->report.interrupted;
    image_names *room = NULL;
    fathom_status status = interrupted ? images_rename(s->context, &s->options.outputs, &room) : FATHOM_OK;
    /* An unfinished film may still be black. */
    s->exposed = brightness_settle(&s->report.warnings, interrupted ? NULL : s->scene, s->options.scene,
                                   s->film, &s->options);
    if (status == FATHOM_OK)
        status = write_all(s);
    else
        rescue(s, "the pixels");
    if (status == FATHOM_OK && !interrupted && s->report.stats.resumed_seconds > 0)
        images_remove_partial(&s->options.outputs);
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
    log_say(LOG_ERROR, "interrupted; what is finished is in %s; run the same command again to continue",
            s->options.part.path);
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
    if (s->film) rescue(s, "the pixels rendered so far, some of which may be wrong,");
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

/* The frames of an animation share a camera, which depends on the scene. So the scene is read once to find
 * it, and then again with it. */
fathom_status task_read_framed(task *s) {
    double span[2];
    fathom_status status = task_read(s);
    if (status != FATHOM_OK || !s->frame_all || !fathom_scene_framed_times(s->scene, span)) return status;
    fathom_scene_destroy(s->scene);
    s->scene = NULL;
    warnings_free(&s->report.warnings);
    s->frame_all(s, span);
    return task_read(s);
}

static fathom_status prepare(task *s) {
    fathom_status status = join_ranks(s);
    if (status == FATHOM_OK && !is_other(s)) status = check_outputs(s);
    if (status != FATHOM_OK) return status;
    if (!is_other(s) && images_need_helper(&s->options)) fathom_image_prefetch();
    progress_begin(s->options.common.quiet || is_other(s), "render");
    progress_phase(FATHOM_PHASE_READ);
    fathom_context_on_warning(s->context, warn_of_scene, s);
    status = task_read_framed(s);
    if (status == FATHOM_OK) status = merge_settings(s);
    if (status == FATHOM_OK && s->options.background.given)
        status = fathom_scene_set_background(s->scene, s->options.background.rgb);
    return status == FATHOM_OK ? set_time_left(s) : status;
}

static void tell_kept(const render_options *options) {
    progress_clear_line();
    for (size_t i = 0; i < options->outputs.count && !options->common.quiet; ++i) {
        print_name(stdout, options->outputs.items[i]);
        puts(": is kept, as an earlier run finished it");
    }
}

fathom_status task_run(task *s) {
    fathom_status status = command_context(&s->options.common, &s->context);
    if (status != FATHOM_OK) return status;
    s->options.write.command = provenance_command();
    interrupt_install();
    interrupt_install_save();
    status = prepare(s);
    bool finished = false;
    if (status == FATHOM_OK) status = saving_find(s->context, s->scene, &s->options, &finished);
    say(s, status);
    s->exposed = finished && s->options.write.exposure != 0; /* a black image has 0 */
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
