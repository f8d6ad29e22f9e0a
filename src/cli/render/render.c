#include "cli/command.h"
#include "cli/interrupt.h"
#include "cli/provenance.h"
#include "cli/render/brightness.h"
#include "cli/render/left_out.h"
#include "cli/render/outputs.h"
#include "cli/render/partial.h"
#include "cli/render/progress.h"
#include "cli/render/rescue.h"
#include "cli/render/saving.h"
#include "cli/render/stats.h"
#include "cli/render/time_left.h"
#include "cli/standard_output.h"

#include "base/clock.h"
#include "base/file.h"
#include "base/status.h"
#include "image/image.h"
#include "job/render.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

static bool writes_stats_file(const render_options *options) {
    return options->stats && !standard_output_is_named(options->stats);
}

static fathom_status check_outputs(fathom_context *context, render_options *options) {
    const char *all[ARGS_LIST_MAX + 2];
    size_t count = 0;
    fathom_status status = standard_output_begin(context, &options->outputs, &options->stats, 1);
    if (status != FATHOM_OK) return status;
    for (; count < options->outputs.count; ++count) all[count] = options->outputs.items[count];
    if (writes_stats_file(options)) all[count++] = options->stats;
    if (options->checkpoint) all[count++] = options->checkpoint;
    status = outputs_check_distinct(context, all, count, options->scene);
    if (status == FATHOM_OK) status = partial_check(context, &options->outputs, all, count);
    for (size_t i = 0; i < options->outputs.count && status == FATHOM_OK; ++i) {
        status = image_check(context, options->outputs.items[i], &options->write);
    }
    if (status == FATHOM_OK && writes_stats_file(options))
        status = file_check_writable(context, options->stats);
    if (status == FATHOM_OK) status = saving_check(context, options);
    for (size_t i = 0; i < count && status == FATHOM_OK; ++i) file_remove_left_over(all[i]);
    for (size_t i = 0; i < options->outputs.count && status == FATHOM_OK; ++i) {
        char partial[PATH_MAX];
        if (partial_name(options->outputs.items[i], partial)) file_remove_left_over(partial);
    }
    return status;
}

static fathom_status check_sizes(fathom_context *context, const render_options *options) {
    const settings_region region = settings_region_of(&options->settings);
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < options->outputs.count && status == FATHOM_OK; ++i)
        status = image_check_size(context, options->outputs.items[i], region.width, region.height);
    return status;
}

/* The command line over what the scene's file asked for. What the two make of each other (a crop outside the
 * scene's image, …) is wrong usage: the scene by itself has been checked. */
static fathom_status merge_settings(fathom_context *context, const fathom_scene *scene,
                                    render_options *options) {
    fathom_settings settings;
    args_problem problem;
    fathom_scene_settings(scene, &settings);
    if (!render_options_finish(options, &settings, &problem))
        return fail(context, FATHOM_BAD_USAGE, "%s", problem.text);
    if (settings.aovs & ~options->settings.aovs && !render_options_give(options, "aovs"))
        warn(context, "%s: asks for AOVs that only .exr holds; they are left out", options->scene);
    if (render_options_give(options, "min_spp") &&
        !(options->settings.target_error > 0 || options->settings.max_time > 0))
        return fail(context, FATHOM_BAD_USAGE, "--min-spp: only with --target-error E or --max-time SECONDS");
    if (scene_check_settings(context, &options->settings) != FATHOM_OK) return FATHOM_BAD_USAGE;
    return check_sizes(context, options);
}

/* A message that names all outputs. */
#define SAID 8192

typedef struct watched {
    fathom_context *context;
    render_report *report;
    saving saving;
    fathom_status outlook; /* of writing the image */
} watched;

static bool on_progress(void *user, const fathom_progress *progress) {
    watched *w = user;
    if (progress->phase == FATHOM_PHASE_RENDER) {
        w->report->finished = progress->fraction;
        interrupt_keep_work(true);
    }
    saving_tick(&w->saving);
    progress_update(progress);
    w->outlook = image_prefetch_status(w->context);
    return !interrupt_asked() && w->outlook == FATHOM_OK;
}

static bool holds_all(const char *path) {
    char extension[16];
    file_extension(path, extension);
    return strcmp(extension, "exr") == 0;
}

static bool needs_image_module(const render_options *options) {
    for (size_t i = 0; i < options->outputs.count; ++i) {
        if (image_needs_module(options->outputs.items[i], &options->write)) return true;
    }
    return false;
}

static fathom_status list_left_out(fathom_context *context, const fathom_film *film,
                                   const render_options *options, left_out_list *out) {
    const fathom_left_out *items;
    const uint32_t count = fathom_film_left_out(film, &items);
    bool fine = true;
    for (uint32_t i = 0; i < count && fine; ++i) fine = left_out_tell(out, items[i].what, items[i].why);
    if (fine && !needs_image_module(options)) fine = left_out_image_module(out);
    return fine ? FATHOM_OK : fail_memory(context, count * sizeof *items);
}

/* Every output is tried: a full disk under one leaves the others worth having. */
static fathom_status write_images(fathom_context *context, const fathom_film *film,
                                  const render_options *options) {
    fathom_status result = FATHOM_OK;
    const char *failed = NULL;
    bool kept = false;
    for (size_t i = 0; i < options->outputs.count; ++i) {
        const char *path = options->outputs.items[i];
        fathom_status status = fathom_film_write(context, film, path, &options->write);
        if (status == FATHOM_OK) status = standard_output_deliver(context, i, path);
        say_status(&command_render, context, status);
        kept |= status == FATHOM_OK && holds_all(path);
        if (status != FATHOM_OK && !failed)
            result = status, failed = standard_output_shown(&options->outputs, i);
    }
    if (failed && !kept) rescue_film(context, film, failed, "the pixels");
    return result;
}

/* What memory is needed for comes first: an image that is there with an exit code that says it is not helps
 * nobody. */
static fathom_status write_all(fathom_context *context, const fathom_film *film,
                               const render_options *options, render_report *report, double start) {
    progress_phase(FATHOM_PHASE_WRITE);
    if (say_status(&command_render, context, list_left_out(context, film, options, &report->left_out)) !=
        FATHOM_OK) {
        rescue_film(context, film, standard_output_shown(&options->outputs, 0), "the pixels");
        return FATHOM_OUT_OF_RESOURCES;
    }
    double begin = clock_seconds();
    fathom_status status = write_images(context, film, options);
    double end = clock_seconds();
    report->write_seconds = end - begin;
    report->total_seconds = end - start;
    fathom_film_size(film, &report->width, &report->height);
    progress_clear_line();
    if (options->stats) {
        fathom_status stats = say_status(&command_render, context, stats_write(context, report, options));
        if (status == FATHOM_OK) status = stats;
    }
    if (status == FATHOM_OK) stats_print(report, options);
    return status;
}

static void tell_interrupted(const render_options *options) {
    char text[SAID];
    int used = snprintf(text, sizeof text, "interrupted; the image is written as far as it got, to ");
    for (size_t i = 0; i < options->outputs.count && used >= 0 && used < SAID; ++i) {
        used += snprintf(text + used, (size_t)(SAID - used), "%s%s", i ? ", " : "",
                         standard_output_shown(&options->outputs, i));
    }
    if (options->checkpoint && used >= 0 && used < SAID)
        snprintf(text + used, (size_t)(SAID - used), "; --resume continues");
    say_error(text);
}

/* The image of a render that ended with `status`, and what is to be said of it. */
static fathom_status finish(fathom_context *context, const fathom_scene *scene, const fathom_film *film,
                            render_options *options, render_report *report, const saving *kept,
                            double start) {
    const bool interrupted = report->interrupted;
    partial_names *room = NULL;
    fathom_status status = interrupted ? partial_rename(context, &options->outputs, &room) : FATHOM_OK;
    brightness_expose(film, options);
    if (!interrupted) brightness_warn(context, scene, film, options);
    if (status == FATHOM_OK)
        status = write_all(context, film, options, report, start);
    else
        rescue_film(context, film, standard_output_shown(&options->outputs, 0), "the pixels");
    status = saving_end(kept, interrupted, status);
    if (status == FATHOM_OK && interrupted) {
        tell_interrupted(options);
        status = FATHOM_INTERRUPTED;
    }
    free(room);
    return status;
}

#define DOUBTFUL "the pixels rendered until then, of which some may be wrong,"

static fathom_status render_scene(fathom_context *context, fathom_scene *scene, render_options *options,
                                  render_report *report, double start) {
    if (options->background.given) {
        fathom_status status = fathom_scene_set_background(scene, options->background.rgb);
        if (status != FATHOM_OK) return say_status(&command_render, context, status);
    }
    fathom_status status = time_left(context, clock_seconds() - start, options);
    if (status != FATHOM_OK) return say_status(&command_render, context, status);
    fathom_film *film;
    watched w = {.context = context, .report = report, .outlook = FATHOM_OK};
    const time_outputs outputs = {context, options};
    const job_reserve writing = time_to_write(&outputs);
    saving_begin(options, &w.saving);
    status = render_to_time(context, scene, &options->settings, &writing, saving_request(&w.saving),
                            on_progress, &w, &report->stats, &film);
    if (w.outlook != FATHOM_OK) {
        fathom_film_destroy(film);
        return say_status(&command_render, context, image_prefetch_status(context));
    }
    /* Errors that no reader could find, such as how the scene's parts fit together, name no file yet. */
    if ((status == FATHOM_BAD_INPUT || status == FATHOM_OUT_OF_RESOURCES) &&
        !*fathom_context_error(context)->place->file)
        fail_within(context, status, &(fathom_place){.file = options->scene});
    if (status != FATHOM_OK && status != FATHOM_INTERRUPTED) {
        say_status(&command_render, context, status);
        if (film) rescue_film(context, film, standard_output_shown(&options->outputs, 0), DOUBTFUL);
        fathom_film_destroy(film);
        return status;
    }
    interrupt_keep_work(true);
    report->interrupted = status == FATHOM_INTERRUPTED;
    report->finished = report->stats.finished;
    report->scene = scene->name;
    status = finish(context, scene, film, options, report, &w.saving, start);
    fathom_film_destroy(film);
    return status;
}

static fathom_status read_scene(fathom_context *context, const render_options *options, fathom_scene **out) {
    const fathom_read_options read = {.without_uvs = true,
                                      .camera = options->camera,
                                      .up = options->up,
                                      .width = options->size.width,
                                      .height = options->size.height};
    return fathom_scene_read_with(context, options->scene, &read, out);
}

static fathom_status read_and_render(fathom_context *context, render_options *options, double start) {
    interrupt_install();
    interrupt_install_save();
    fathom_status status = say_status(&command_render, context, check_outputs(context, options));
    if (status != FATHOM_OK) return status;
    if (needs_image_module(options)) fathom_image_prefetch();
    progress_begin(options->quiet);
    progress_phase(FATHOM_PHASE_READ);
    render_report report = {.finished = 0};
    fathom_context_on_warning(context, warnings_say, &report.warnings);
    fathom_scene *scene;
    double begin = clock_seconds();
    status = say_status(&command_render, context, read_scene(context, options, &scene));
    if (status != FATHOM_OK) {
        warnings_free(&report.warnings);
        return status;
    }
    outputs_may_be_read(context); /* the checkpoint, that is */
    report.read_seconds = clock_seconds() - begin;
    status = merge_settings(context, scene, options);
    say_status(&command_render, context, status);
    if (status == FATHOM_OK) status = render_scene(context, scene, options, &report, start);
    array_free(&report.left_out);
    warnings_free(&report.warnings);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status run(int argc, char **argv) {
    double start = clock_seconds();
    fathom_settings settings;
    render_options options;
    fathom_status status;
    fathom_settings_default(&settings);
    render_options_default(&options);
    if (!command_parse(&command_render, argc, argv, &options, &status)) return status;
    args_problem problem;
    if (!render_options_finish(&options, &settings, &problem))
        return say_usage(&command_render, problem.text);
    fathom_context *context;
    status = command_context(options.threads, &context);
    if (status != FATHOM_OK) return status;
    fathom_context_allow_outside(context, options.allow_outside);
    options.write.command = provenance_command();
    status = read_and_render(context, &options, start);
    standard_output_end();
    fathom_context_destroy(context);
    return status;
}

static const char *const operands[] = {"SCENE"};
static const size_t operand_offsets[] = {offsetof(render_options, scene)};

const command command_render = {
    .name = "render",
    .usage = "SCENE -o IMAGE [-o IMAGE2 ...] [options]",
    .summary = "Render a scene to an image.",
    .text = "SCENE is scene JSON (.json) or a model: .glb, .gltf, .obj, .ply. A model without\n"
            "camera or lights gets a camera that frames it, and lights. Models take 16\n"
            "samples a pixel.\n"
            "Ctrl-C stops, writes the image as far as it got to NAME.partial.EXT, leaves a\n"
            "finished NAME.EXT as it was, and exits with code 5. So do SIGTERM, SIGHUP (a\n"
            "terminal that is closed) and SIGXCPU (ulimit -t).\n"
            "If an image cannot be written, its pixels go to NAME.rescue.exr beside it, or to\n"
            "the working folder, $TMPDIR or /tmp, and a message says where. So do those of a\n"
            "scene whose files were changed while it was rendered: exit code 3.\n"
            "With --checkpoint FILE it can be continued, and so can what was killed.\n",
    .examples = "  fathom render bunny.obj -o bunny.png\n"
                "  fathom render scan.ply -o scan.png --up z --size 1080x1920\n"
                "  fathom render scene.json -o out.exr -o out.png --size 1920x1080 --spp 16\n"
                "  fathom render scene.json -o out.exr --aov Z,N,id --stats out.json\n"
                "  fathom render scene.json -o out.png --target-error 0.01\n"
                "  fathom render scene.json -o out.png --max-time 60\n"
                "  fathom render scene.json -o out.exr --checkpoint out.part --resume\n",
    .args = {NULL, operands, operand_offsets, 1, 0, render_option_table},
    .run = run,
};
