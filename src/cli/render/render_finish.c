/* Combines the options of `fathom render` with the scene's settings, and checks that they fit together. */
#include "cli/outputs.h"
#include "cli/render/render_options.h"

#include "base/file_name.h"
#include "base/parameter.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The AOVs that at least one of the outputs can hold: all in .exr, alpha in .png and .tif, none in .jpg. */
static unsigned held_aovs(const args_list *outputs) {
    unsigned held = outputs_count_exr(outputs) ? ~0u : 0;
    for (size_t i = 0; i < outputs->count; ++i)
        if (!file_ends_in(outputs->items[i], "jpg|jpeg")) held |= FATHOM_AOV_ALPHA;
    return held;
}

/* True if the scene's sampling settings are the defaults of its integrator. */
static bool is_preset(const fathom_settings *scene) {
    fathom_settings preset = *scene;
    fathom_settings_set_integrator(&preset, scene->integrator);
    return scene->target_error == preset.target_error && scene->spp == preset.spp && !(scene->max_time > 0);
}

/* If the command line gives a target or a time, and the file has none of its own, the file's pattern and spp
 * are meant for uniform sampling, so they are replaced. */
static bool finish_adaptive(render_options *options, const fathom_settings *scene, args_problem *problem) {
    fathom_settings *s = &options->settings;
    options->max_time = s->max_time;
    if (!(s->target_error > 0 || s->max_time > 0)) return true;
    if (render_options_give(options, "pattern") && s->pattern != FATHOM_PATTERN_SOBOL) {
        return args_wrong(problem, "--pattern: --target-error and --max-time need --pattern sobol, the only "
                                   "one that can add samples");
    }
    const bool asked =
        render_options_give(options, "target_error") || render_options_give(options, "max_time");
    if (!asked || ((scene->target_error > 0 || scene->max_time > 0) && !is_preset(scene))) return true;
    s->pattern = FATHOM_PATTERN_SOBOL;
    if (!render_options_give(options, "spp")) s->spp = 65536;
    return true;
}

/* 8bit needs the built-in view: only there is it known how a loss is displayed. */
static bool finish_loss(render_options *options, args_problem *problem) {
    if (options->loss == FATHOM_LOSS_8BIT && !fathom_write_is_srgb(&options->write)) {
        return args_wrong(problem, "--leave-out-below 8bit: works only with the built-in sRGB view; expected "
                                   "no --ocio, --display, --view and no $OCIO");
    }
    if (options->loss == FATHOM_LOSS_8BIT && options->exposure == EXPOSURE_AUTO)
        return args_wrong(problem, "--leave-out-below 8bit: needs the exposure before rendering; expected "
                                   "--exposure STOPS rather than auto");
    if (options->loss == FATHOM_LOSS_8BIT) options->exposure = EXPOSURE_GIVEN;
    fathom_settings_set_loss(&options->settings, options->loss, options->write.exposure);
    return true;
}

/* Overrides the scene's settings with those of the command line. */
static bool merge(render_options *options, const fathom_settings *scene, args_problem *problem) {
    fathom_settings *s = &options->settings;
    *s = *scene;
    /* --spp or a pattern other than Sobol means uniform sampling; a time alone means the best image in that
     * time. Both drop a target error that the command line does not give. */
    const bool grid =
        render_options_give(options, "pattern") && options->asked.pattern != FATHOM_PATTERN_SOBOL;
    if ((render_options_give(options, "spp") || grid) && s->integrator != FATHOM_INTEGRATOR_CLASSIC)
        s->target_error = 0;
    if (render_options_give(options, "max_time") && is_preset(scene)) s->target_error = 0;
    size_t count;
    const fathom_parameter *rows = fathom_settings_parameters(&count);
    for (size_t i = 0; i < count; ++i) {
        if (options->given >> i & 1) parameter_copy(&rows[i], &options->asked, s);
    }
    if (options->size.width) s->width = options->size.width, s->height = options->size.height;
    const bool whole = !(s->crop[0] || s->crop[1] || s->crop[2] || s->crop[3]);
    if (render_options_give(options, "crop") && !whole &&
        (s->crop[0] >= s->crop[2] || s->crop[1] >= s->crop[3]))
        return args_wrong(problem, "--crop: expected X0 < X1 and Y0 < Y1, found \"%u,%u,%u,%u\"", s->crop[0],
                          s->crop[1], s->crop[2], s->crop[3]);
    return true;
}

/* ---- a part: --part and --split, or the task of a Slurm array ---- */

static bool number_of(const char *variable, uint32_t *out) {
    const char *text = getenv(variable);
    char end;
    return text && sscanf(text, "%9u%c", out, &end) == 1;
}

/* Finds the position of this task among the tasks least, least + step, …. */
static bool take_slurm(fathom_part *part, args_problem *problem) {
    uint32_t task, least = 0, step = 1;
    if (!number_of("SLURM_ARRAY_TASK_ID", &task) || !number_of("SLURM_ARRAY_TASK_COUNT", &part->count))
        return args_wrong(problem,
                          "-o %.300s: --part K/N is missing, and there is no SLURM_ARRAY_TASK_ID with "
                          "SLURM_ARRAY_TASK_COUNT",
                          part->path);
    number_of("SLURM_ARRAY_TASK_MIN", &least);
    number_of("SLURM_ARRAY_TASK_STEP", &step);
    part->index = step && task >= least ? (task - least) / step + 1 : 0;
    if (part->index && part->index <= part->count && part->count <= 65536 && (task - least) % step == 0)
        return true;
    return args_wrong(problem,
                      "-o %.300s: task %u is none of an array of %u tasks from %u on in steps of %u; "
                      "expected such an array, or --part K/N",
                      part->path, task, part->count, least, step);
}

/* Turns an output whose name ends in .part into the part's file. */
static bool finish_part(render_options *options, args_problem *problem) {
    fathom_part *part = &options->part;
    args_list *outputs = &options->outputs;
    if (part->path) return true;
    size_t i = 0;
    while (i < outputs->count && !file_ends_in(outputs->items[i], "part")) ++i;
    if (i == outputs->count) {
        return (!part->count && part->split == FATHOM_SPLIT_AUTO) ||
               args_wrong(problem, "--%s: only with -o FILE.part", part->count ? "part" : "split");
    }
    if (outputs->count > 1)
        return args_wrong(problem,
                          "-o %.300s: a part must be the only output; fathom merge writes the images",
                          outputs->items[i]);
    if (options->mpi)
        return args_wrong(problem,
                          "--mpi: one process renders a part; expected either --mpi or -o FILE.part");
    if (options->checkpoint)
        return args_wrong(problem, "--checkpoint: a part is its own checkpoint; leave this option out");
    part->path = outputs->items[i];
    outputs->count = 0;
    return part->count || take_slurm(part, problem);
}

/* ---- frames ---- */

#define FPS 24.0

/* In seconds. */
static double frames_time(const render_frames *frames, uint32_t frame) {
    return frame / (frames->fps > 0 ? frames->fps : FPS);
}

bool frames_name(const char *path, uint32_t frame, char out[PATH_MAX]) {
    const char *begin = strrchr(path, '#');
    if (!begin) return false;
    const char *end = begin + 1;
    while (begin > path && begin[-1] == '#') --begin;
    const int length =
        snprintf(out, PATH_MAX, "%.*s%0*u%s", (int)(begin - path), path, (int)(end - begin), frame, end);
    return length >= 0 && length < PATH_MAX;
}

/* Number of files that are written in addition to the outputs. */
enum { OTHERS = 3 };
bool render_options_frame(render_options *options, uint32_t frame, frame_names *room, args_problem *problem) {
    const char **others[OTHERS] = {&options->stats, &options->checkpoint, &options->part.path};
    for (size_t i = 0; i < options->outputs.count + OTHERS; ++i) {
        const char **path = i < OTHERS ? others[i] : &options->outputs.items[i - OTHERS];
        if (!*path) continue;
        if (outputs_is_standard(*path))
            return args_wrong(problem,
                              "--frames: standard output is one file; expected a name with #### for the "
                              "number");
        if (!frames_name(*path, frame, room->names[i]))
            return args_wrong(problem,
                              "--frames: expected a name with #### for the number, found \"%.300s\"%s", *path,
                              strchr(*path, '#') ? ", which is too long" : "");
        *path = room->names[i];
    }
    options->model.time =
        (args_f64){.given = true, .value = options->model.time.value + frames_time(&options->frames, frame)};
    return true;
}

/* One # may be part of a name. */
static bool check_single_frame(const render_options *options, args_problem *problem) {
    if (options->frames.fps > 0) return args_wrong(problem, "--fps: only with --frames FIRST-LAST");
    for (size_t i = 0; i < options->outputs.count; ++i)
        if (strstr(options->outputs.items[i], "##"))
            return args_wrong(problem,
                              "-o %.300s: #### stands for a frame's number; expected --frames FIRST-LAST",
                              options->outputs.items[i]);
    return true;
}

static bool check_frames(const render_options *options, args_problem *problem) {
    if (!frames_asked(&options->frames)) return check_single_frame(options, problem);
    return !options->mpi || args_wrong(problem, "--mpi: renders one image; expected no --frames");
}

static bool check_environment(const render_options *options, args_problem *problem) {
    if (!options->environment)
        return options->environment_rotation == 0 ||
               args_wrong(problem, "--environment-rotation: only with --environment FILE");
    if (options->background.given)
        return args_wrong(problem, "--environment and --background exclude each other");
    return options->settings.integrator != FATHOM_INTEGRATOR_CLASSIC ||
           args_wrong(problem, "--environment: the classic integrator has no light from images; expected "
                               "path tracing, by --integrator path");
}

static const char *color_option(const fathom_write_options *write) {
    return write->display ? "display" : write->view ? "view" : NULL;
}

/* The part keeps an exposure for its image. */
static bool check_part(const render_options *options, args_problem *problem) {
    const char *lost = options->write.float_color           ? "exr-float"
                       : options->exposure == EXPOSURE_AUTO ? "exposure auto"
                                                            : color_option(&options->write);
    return !lost || args_wrong(problem,
                               "--%s: is for the image, which fathom merge writes; give it to fathom merge "
                               "instead of with -o FILE.part",
                               lost);
}

bool render_options_check_images(const render_options *options, args_problem *problem) {
    const char *color = color_option(&options->write);
    const size_t exr = outputs_count_exr(&options->outputs);
    if (options->write.float_color && !exr) return args_wrong(problem, "--exr-float: only with -o FILE.exr");
    return exr < options->outputs.count || !color ||
           args_wrong(problem, "--%s: only with an image for the display, such as -o FILE.png", color);
}

bool render_options_finish(render_options *options, const fathom_settings *scene, args_problem *problem) {
    if (!check_frames(options, problem) || !finish_part(options, problem)) return false;
    if (!options->outputs.count && !options->part.path) return args_wrong(problem, "-o IMAGE is missing");
    if (!(options->part.path ? check_part : render_options_check_images)(options, problem)) return false;
    if (!merge(options, scene, problem) || !check_environment(options, problem)) return false;
    if (options->common.quiet && options->verbose)
        return args_wrong(problem, "--quiet and --verbose exclude each other");
    if (!options->checkpoint && (options->resume || options->checkpoint_every >= 0)) {
        return args_wrong(problem, "--%s: only with --checkpoint FILE",
                          options->resume ? "resume" : "checkpoint-every");
    }
    if (!finish_adaptive(options, scene, problem) || !finish_loss(options, problem)) return false;
    if (options->exposure == EXPOSURE_GIVEN) options->part.exposure = &options->write.exposure;
    unsigned held = options->part.path ? ~0u : held_aovs(&options->outputs);
    const unsigned lost = options->settings.aovs & ~held;
    if (render_options_give(options, "aovs") && lost)
        return args_wrong(problem,
                          lost == FATHOM_AOV_ALPHA
                              ? "--aov: .jpg holds no alpha; expected one more -o FILE.png, .tif or .exr"
                              : "--aov: only .exr holds these channels; expected one more -o FILE.exr");
    options->settings.aovs &= held;
    return true;
}
