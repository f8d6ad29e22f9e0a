#include "cli/command.h"
#include "cli/interrupt.h"
#include "cli/outputs.h"
#include "cli/progress.h"
#include "cli/stats.h"
#include "cli/time_left.h"

#include "base/clock.h"
#include "base/file.h"
#include "base/status.h"
#include "image/image.h"
#include "render/render.h"
#include "scene/scene.h"

static fathom_status check_outputs(fathom_context *context, const render_options *options) {
    const char *all[ARGS_LIST_MAX + 1];
    size_t count = 0;
    for (; count < options->outputs.count; ++count) all[count] = options->outputs.items[count];
    if (options->stats) all[count++] = options->stats;
    fathom_status status = outputs_check_distinct(context, all, count, options->scene);
    for (size_t i = 0; i < options->outputs.count && status == FATHOM_OK; ++i) {
        status = image_check(context, options->outputs.items[i], &options->write);
    }
    if (status == FATHOM_OK && options->stats) status = file_check_writable(context, options->stats);
    return status;
}

/* The command line once more, over what the scene's file asked for. What the two make of each other (a crop
 * outside the scene's image, …) is wrong usage: the scene by itself has been checked. */
static fathom_status merge_settings(fathom_context *context, const fathom_scene *scene, int argc, char **argv,
                                    render_options *options) {
    fathom_settings settings;
    args_problem problem;
    fathom_scene_settings(scene, &settings);
    render_options_default(options, &settings);
    if (args_parse(&command_render.args, argc, argv, options, &problem) != ARGS_READY ||
        !render_options_finish(options, &problem)) {
        return fail(context, FATHOM_INTERNAL, "the command line changed while it was read");
    }
    if (settings.aovs & ~options->settings.aovs && !options->aovs_given)
        warn(context, "%s: asks for AOVs that only .exr holds; they are left out", options->scene);
    if (options->min_spp_given && !(options->settings.target_error > 0 || options->settings.max_time > 0))
        return fail(context, FATHOM_BAD_USAGE, "--min-spp: only with --target-error E or --max-time SECONDS");
    return scene_check_settings(context, &options->settings) == FATHOM_OK ? FATHOM_OK : FATHOM_BAD_USAGE;
}

static bool on_progress(void *user, const fathom_progress *progress) {
    render_report *report = user;
    if (progress->phase == FATHOM_PHASE_RENDER) {
        report->finished = progress->fraction;
        interrupt_keep_work(true);
    }
    progress_update(progress);
    return !interrupt_asked();
}

/* Every output is tried: a full disk under one leaves the others worth having. */
static fathom_status write_images(fathom_context *context, const fathom_film *film,
                                  const render_options *options) {
    fathom_status result = FATHOM_OK;
    for (size_t i = 0; i < options->outputs.count; ++i) {
        fathom_status status = fathom_film_write(context, film, options->outputs.items[i], &options->write);
        say_status(&command_render, context, status);
        if (result == FATHOM_OK) result = status;
    }
    return result;
}

static fathom_status write_all(fathom_context *context, const fathom_film *film,
                               const render_options *options, render_report *report, double start) {
    progress_phase(FATHOM_PHASE_WRITE);
    double begin = clock_seconds();
    fathom_status status = write_images(context, film, options);
    double end = clock_seconds();
    report->write_seconds = end - begin;
    report->total_seconds = end - start;
    fathom_film_size(film, &report->width, &report->height);
    report->left_out_count = fathom_film_left_out(film, &report->left_out);
    progress_clear_line();
    if (options->stats) {
        fathom_status stats = say_status(&command_render, context, stats_write(context, report, options));
        if (status == FATHOM_OK) status = stats;
    }
    if (status == FATHOM_OK) stats_print(report, options);
    return status;
}

static fathom_status render_scene(fathom_context *context, fathom_scene *scene, render_options *options,
                                  render_report *report, double start) {
    if (options->background.given) {
        fathom_status status = fathom_scene_set_background(scene, options->background.rgb);
        if (status != FATHOM_OK) return say_status(&command_render, context, status);
    }
    fathom_status status = time_left(context, clock_seconds() - start, options);
    if (status != FATHOM_OK) return say_status(&command_render, context, status);
    fathom_film *film;
    const time_outputs outputs = {context, options};
    const job_reserve writing = time_to_write(&outputs);
    status = render_to_time(context, scene, &options->settings, &writing, on_progress, report, &report->stats,
                            &film);
    /* What no reader could see: how the scene's parts fit together. */
    if (status == FATHOM_BAD_INPUT) fail_within(context, status, "%s: ", options->scene);
    if (status != FATHOM_OK && status != FATHOM_INTERRUPTED)
        return say_status(&command_render, context, status);
    interrupt_keep_work(true);
    report->interrupted = status == FATHOM_INTERRUPTED;
    report->scene = scene->name;
    fathom_status written = write_all(context, film, options, report, start);
    fathom_film_destroy(film);
    if (written != FATHOM_OK) return written;
    if (status == FATHOM_INTERRUPTED) say_error("interrupted; the image is written as far as it got");
    return status;
}

static fathom_status read_scene(fathom_context *context, const render_options *options, fathom_scene **out) {
    return options->settings.keep & FATHOM_PART_UVS
               ? fathom_scene_read(context, options->scene, out)
               : fathom_scene_read_to_render(context, options->scene, out);
}

static fathom_status read_and_render(fathom_context *context, int argc, char **argv, render_options *options,
                                     double start) {
    interrupt_install();
    fathom_status status = say_status(&command_render, context, check_outputs(context, options));
    if (status != FATHOM_OK) return status;
    fathom_image_prefetch();
    progress_begin(options->quiet);
    progress_phase(FATHOM_PHASE_READ);
    render_report report = {.finished = 0};
    fathom_scene *scene;
    double begin = clock_seconds();
    status = say_status(&command_render, context, read_scene(context, options, &scene));
    if (status != FATHOM_OK) return status;
    report.read_seconds = clock_seconds() - begin;
    status = merge_settings(context, scene, argc, argv, options);
    say_status(&command_render, context, status);
    if (status == FATHOM_OK) status = render_scene(context, scene, options, &report, start);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status run(int argc, char **argv) {
    double start = clock_seconds();
    fathom_settings settings;
    render_options options;
    fathom_status status;
    fathom_settings_default(&settings);
    render_options_default(&options, &settings);
    if (!command_parse(&command_render, argc, argv, &options, &status)) return status;
    args_problem problem;
    if (!render_options_finish(&options, &problem)) return say_usage(&command_render, problem.text);
    fathom_context *context;
    status = command_context(options.threads, &context);
    if (status != FATHOM_OK) return status;
    status = read_and_render(context, argc, argv, &options, start);
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
            "camera or lights gets a camera that frames it, and lights.\n"
            "Ctrl-C stops, keeps what is finished as an image, and exits with code 5.\n",
    .examples = "  fathom render bunny.obj -o bunny.png\n"
                "  fathom render scene.json -o out.exr -o out.png --size 1920x1080 --spp 16\n"
                "  fathom render scene.json -o out.exr --aov Z,N,id --stats out.json\n"
                "  fathom render scene.json -o out.png --target-error 0.01\n"
                "  fathom render scene.json -o out.png --max-time 60\n",
    .args = {render_option_table, operands, operand_offsets, 1},
    .run = run,
};
