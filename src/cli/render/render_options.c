#include "cli/render/render_options.h"

#include "cli/command.h"
#include "cli/outputs.h"

#include "base/parameter.h"

#include <fathom/trace.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool take_exposure(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_options *options = field;
    options->exposure = strcmp(value, "auto") == 0 ? EXPOSURE_AUTO : EXPOSURE_GIVEN;
    options->write.exposure = 0;
    return options->exposure == EXPOSURE_AUTO || take_f32(option, value, &options->write.exposure, problem);
}

/* Textures take the config from there. */
static bool take_config(const args_option *option, const char *value, void *field, args_problem *problem) {
    return take_text(option, value, field, problem) && setenv("OCIO", value, 1) == 0;
}

static bool take_rgb(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_background *background = field;
    const fathom_parameter p = {.type = FATHOM_PARAMETER_F32,
                                .offset = offsetof(render_background, rgb),
                                .low = option->least,
                                .high = option->most,
                                .unit = option->value,
                                .count = 3};
    background->given = take_parameter(&p, value, background, problem);
    return background->given;
}

#define FRAME_MOST 999999u

/* "1-24" or "7". */
static bool take_frames(const args_option *option, const char *value, void *field, args_problem *problem) {
    const char *text = value;
    uint64_t first = 0, last;
    bool fine = text_read_u64(&text, strchr(value, '-') ? '-' : '\0', &first);
    last = first;
    if (fine && strchr(value, '-')) fine = text_read_u64(&text, '\0', &last);
    if (!fine || first > last || last > FRAME_MOST)
        return args_wrong(problem, "expected %s with FIRST <= LAST <= %u, such as 1-24, found \"%.60s\"",
                          option->value, FRAME_MOST, value);
    render_frames *frames = field;
    frames->first = (uint32_t)first, frames->last = (uint32_t)last;
    return true;
}

/* "3/16". */
static bool take_part(const args_option *option, const char *value, void *field, args_problem *problem) {
    fathom_part *part = field;
    char end;
    if (strspn(value, "0123456789/") == strlen(value) &&
        sscanf(value, "%9u/%9u%c", &part->index, &part->count, &end) == 2 && part->index &&
        part->index <= part->count && part->count <= 65536)
        return true;
    return args_wrong(problem, "expected %s with 1 <= K <= N <= 65536, such as 3/16, found \"%.60s\"",
                      option->value, value);
}

/* ---- settings ---- */

static parameter_table settings_table(void) {
    parameter_table table;
    table.rows = fathom_settings_parameters(&table.count);
    return table;
}

static size_t index_of(const char *name) {
    return (size_t)(parameter_find(settings_table(), name) - settings_table().rows);
}

_Static_assert(sizeof(fathom_settings) / sizeof(uint32_t) < 64,
               "render_options.given has a bit for each setting");

bool render_options_give(const render_options *options, const char *name) {
    return options->given >> index_of(name) & 1;
}

static bool set(render_options *options, size_t index, const char *value, args_problem *problem) {
    const fathom_parameter *p = &settings_table().rows[index];
    options->given |= (uint64_t)1 << index;
    if (value) return take_parameter(p, value, &options->asked, problem);
    parameter_set_number(p, &options->asked, 0, p->fallback == 0);
    return true;
}

/* option->least: the setting's index in the table. The option of a bool takes no value and inverts the
 * default. */
static bool take_setting(const args_option *option, const char *value, void *field, args_problem *problem) {
    return set(field, (size_t)option->least, value, problem);
}

/* Later lists add to earlier ones; "none" removes them. */
static bool take_aovs(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option;
    render_options *options = field;
    const unsigned before = render_options_give(options, "aovs") ? options->asked.aovs : 0;
    if (!set(options, index_of("aovs"), value, problem)) return false;
    if (options->asked.aovs) options->asked.aovs |= before;
    return true;
}

/* Checks the tracer before the scene is read, which can take long. */
static bool take_tracer(const args_option *option, const char *value, void *field, args_problem *problem) {
    fathom_context *context;
    if (!take_setting(option, value, field, problem)) return false;
    if (fathom_tracer_check(NULL, value) == FATHOM_OK) return true;
    /* Parses again to get the message, so that a valid value needs no memory. */
    if (fathom_context_create(&context) != FATHOM_OK)
        return args_wrong(problem, "expected %s, found \"%.60s\"", option->value, value);
    fathom_tracer_check(context, value);
    args_wrong(problem, "%s", fathom_context_message(context));
    fathom_context_destroy(context);
    return false;
}

#define FIELD(name) offsetof(render_options, name)

/* Options that `fathom merge` shares. */
#define OUTPUT_OPTION                                                                                        \
    ARGS_ROW("output", 'o', "IMAGE", take_output, FIELD(outputs), 0, 0,                                      \
             ".exr (scene-linear), .png, .jpg or .tif (8 bit, for the display); - writes PNG to standard "   \
             "output, exr:- EXR, and so on. Give the option again for more images of the same render")
#define FLOAT_OPTION                                                                                         \
    ARGS_ROW("exr-float", 0, NULL, take_true, FIELD(write.float_color), 0, 0,                                \
             "write colours into the .exr as 32-bit float instead of half")
#define COLOUR_OPTIONS(exposure_more, ocio_also)                                                             \
    ARGS_ROW("exposure", 0, "STOPS|auto", take_exposure, 0, -64, 64,                                         \
             "exposure in stops; +1 doubles the brightness. auto: 99 % of the lit pixels are at most "       \
             "white. Default: 0, but auto if most pixels would be white or nearly black; -0.5 to 0 in the "  \
             "built-in studio. " exposure_more),                                                             \
        ARGS_ROW("display", 0, "NAME", take_text, FIELD(write.display), 0, 0,                                \
                 "a display of the OpenColorIO config (its default)"),                                       \
        ARGS_ROW("view", 0, "NAME", take_text, FIELD(write.view), 0, 0,                                      \
                 "a view of the display (its default)"),                                                     \
        ARGS_ROW("ocio", 0, "FILE", take_config, FIELD(write.ocio), 0, 0,                                    \
                 "OpenColorIO config" ocio_also " ($OCIO, else a built-in one)")

/* Settings with an option are listed after these, at the end of their group. */
static const args_option own_options[] = {
    {.help = "Output"},
    OUTPUT_OPTION,
    {"aov", 0, "LIST", take_aovs, 0, 0, 0, "by aov_help()"},
    FLOAT_OPTION,
    {"stats", 0, "FILE.json", take_text, FIELD(stats), 0, 0,
     "write counts, times, rays and memory as JSON, with the command line and the scene's fingerprint; - is "
     "standard output"},

    {.help = "Image"},
    COMMAND_MODEL(render_options),
    COMMAND_VIEW(render_options),
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536,
     "size in pixels (the scene's; else the aspect ratio of its camera with 1280 on the longer "
     "side; else 1280x720)"},
    {"background", 0, "R,G,B", take_rgb, FIELD(background), 0, 1e9,
     "linear Rec.709 colour of rays that hit nothing (the scene's)"},
    {"environment", 0, "FILE", take_text, FIELD(environment), 0, 0,
     "light the scene with an image of a sky, such as .hdr or .exr: equirectangular, a cross or "
     "strip of a cube's faces, or six files, sky_<FACE>.hdr. It replaces the background and "
     "environments of SCENE, and the built-in studio; its top is the up axis of --up. Path "
     "tracing only"},
    {"environment-rotation", 0, "DEGREES", take_f64, FIELD(environment_rotation), -1e6, 1e6,
     "turn the --environment about the up axis, counter-clockwise from above (0)"},
    {"no-studio", 0, NULL, take_true, FIELD(no_studio), 0, 0,
     "add no lights to a scene without any, such as a room that is lit only by an image on a "
     "screen"},
    {"no-floor", 0, NULL, take_true, FIELD(no_floor), 0, 0,
     "do not add the floor that a model gets with the automatic camera and the built-in studio or "
     "--environment; there is never one with --background or the AOV alpha, nor above the camera"},

    {.help = "Sampling to an error or a time (with the pattern sobol)"},

    {.help = "Checkpoints"},
    {"checkpoint", 0, "FILE", take_text, FIELD(checkpoint), 0, 0,
     "save the unfinished render to FILE at intervals, on Ctrl-C and SIGTERM, and on SIGUSR1 "
     "(which does not stop it). FILE is removed once the image is written. A FILE of another "
     "render is an error"},
    {"checkpoint-every", 0, "SECONDS", take_f64, FIELD(checkpoint_every), 0, 1e9,
     "time from the end of one save to the next (60)"},
    {"resume", 0, NULL, take_true, FIELD(resume), 0, 0,
     "continue from the checkpoint, or start if there is none. The image has the same bits, on any number of "
     "threads. Without --resume, an existing FILE is an error. With --frames, keeps the frames that an "
     "earlier run finished, if their files, scene and options are the same"},

    {.help = "Frames of an animation"},
    {"frames", 0, "FIRST-LAST", take_frames, FIELD(frames), 0, 0,
     "render one image per frame: frame N shows the time N / fps after --time. The names of all "
     "output files have ####, which becomes the frame's number; if there are several, the last does"},
    {"fps", 0, "N", take_f64, FIELD(frames.fps), 1e-3, 1e6, "frames per second (24)"},

    {.help = "A part of the image (-o FILE.part), for fathom merge"},
    {"part", 0, "K/N", take_part, FIELD(part), 0, 0,
     "render part K of N, from 1 to N, to FILE.part; after a kill, run the same command again. "
     "Default: task and count of a Slurm array, from $SLURM_ARRAY_TASK_ID and the like"},
    {"split", 0, "auto|samples|tiles", take_choice, FIELD(part.split), 0, 0,
     "what a part holds: some samples of all pixels, or all samples of some tiles. auto: samples, but tiles "
     "with fewer than 4 samples per part or with a target error (auto)"},

    {.help = "Many processes at the same time"},
    {"mpi", 0, NULL, take_true, FIELD(mpi), 0, 0,
     "render together with all processes that mpirun started; rank 0 writes the image and the checkpoint"},

    {.help = "Light transport"},
    {"leave-out-below", 0, "none|8bit|half", take_choice, FIELD(loss), 0, 0,
     "skip shadow rays whose light would be invisible. 8bit: a pixel of a .png or .tif changes by at most "
     "one of 255 levels. half: a pixel of an .exr changes by at most one unit in the last place (none)"},

    {.help = "Colour of .png, .jpg and .tif"},
    COLOUR_OPTIONS("With --frames, the exposure of frame 0 is that of all", ", also for textures"),

    {.help = "Running"},
    COMMAND_THREADS,
    COMMAND_ALLOW_OUTSIDE,
    COMMAND_QUIET("only errors and warnings"),
    {"verbose", 'v', NULL, take_true, FIELD(verbose), 0, 0,
     "print what was traced and how long each step took"},
    {.help = NULL},
};

const args_option merge_option_table[] = {
    {.help = "Options"},
    OUTPUT_OPTION,
    FLOAT_OPTION,
    {.help = "Colour of .png, .jpg and .tif"},
    COLOUR_OPTIONS("Parts of a sequence keep that of frame 0", ""),
    {.help = "Running"},
    COMMAND_QUIET("only errors and warnings"),
    {.help = NULL},
};

/* ---- the whole table ---- */

enum { OPTIONS_MAX = 96, SETTINGS_MAX = 32, HELP_MAX = 1024 };

/* Buffers for the texts of the options that set settings. */
static struct setting_texts { char name[PARAMETER_NAME + 3], help[HELP_MAX]; } texts[SETTINGS_MAX];

/* Prints a name in backquotes: as an option if it is the JSON name of a setting, otherwise unchanged. Returns
 * the position of the closing backquote. */
static const char *put_name(const char *name, FILE *to) {
    const char *end = strchr(name, '`');
    char found[PARAMETER_NAME];
    snprintf(found, sizeof found, "%.*s", (int)(end - name), name);
    for (size_t i = 0; i < settings_table().count; ++i) {
        char other[PARAMETER_NAME];
        parameter_name(&settings_table().rows[i], 0, other);
        if (strcmp(found, other) != 0) continue;
        parameter_name(&settings_table().rows[i], '-', found);
        fputs("--", to);
        break;
    }
    fputs(found, to);
    return end;
}

/* The help text with the names of the command line, such as its word for 0, and with the default. */
static void put_help(const fathom_parameter *p, char out[HELP_MAX]) {
    fathom_settings defaults;
    char value[PARAMETER_TEXT];
    FILE *to = fmemopen(out, HELP_MAX, "w");
    out[0] = '\0';
    if (!to) return;
    if (p->type == FATHOM_PARAMETER_BOOL && p->fallback != 0) fputs("Turns off: ", to);
    for (const char *c = p->help; *c; ++c) {
        if (p->zero && strncmp(c, " 0:", 3) == 0)
            fprintf(to, " %s", p->zero), ++c;
        else if (*c == '`')
            c = put_name(c + 1, to);
        else
            fputc(*c, to);
    }
    fathom_settings_default(&defaults);
    parameter_print(p, &defaults, value, sizeof value);
    if (p->type == FATHOM_PARAMETER_U64 && p->fallback >= 1e9)
        snprintf(value, sizeof value, "%.0fG", 1e-9 * p->fallback);
    if (*value && p->type != FATHOM_PARAMETER_BOOL && !p->count) fprintf(to, " (%s)", value);
    fclose(to);
}

/* The help of --aov: that of its setting, and the list of words. */
static const char *aov_help(void) {
    static char help[HELP_MAX];
    const fathom_parameter *p = &settings_table().rows[index_of("aovs")];
    put_help(p, help);
    FILE *to = fmemopen(help + strlen(help), sizeof help - strlen(help), "w");
    if (!to) return help;
    fputs(" Some of ", to);
    for (const char *c = p->words; *c; ++c) *c == '|' ? fputs(", ", to) : fputc(*c, to);
    fputs("; all, without alpha and error; or none. Given again, the option adds more. alpha makes the "
          "background transparent; the others need an .exr.",
          to);
    fclose(to);
    return help;
}

static args_option option_of(size_t index) {
    const fathom_parameter *p = &settings_table().rows[index];
    const bool text = p->type == FATHOM_PARAMETER_TEXT, flag = p->type == FATHOM_PARAMETER_BOOL;
    char name[PARAMETER_NAME];
    parameter_name(p, '-', name);
    snprintf(texts[index].name, sizeof texts[index].name, "%s%s", flag && p->fallback != 0 ? "no-" : "",
             name);
    put_help(p, texts[index].help);
    return (args_option){.name = texts[index].name,
                         .value = flag       ? NULL
                                  : p->words ? p->words
                                             : p->unit,
                         .take = text ? take_tracer : take_setting,
                         .least = (double)index,
                         .help = texts[index].help};
}

static args_option *add_settings(args_option *to, const char *group) {
    for (size_t i = 0; i < settings_table().count; ++i) {
        const fathom_parameter *p = &settings_table().rows[i];
        if (p->flags & FATHOM_PARAMETER_COMMAND && strcmp(p->group, group) == 0) *to++ = option_of(i);
    }
    return to;
}

const args_option *render_option_table(void) {
    static args_option all[OPTIONS_MAX];
    args_option *to = all;
    if (all[0].help) return all;
    const char *group = "";
    for (const args_option *o = own_options; o->help; ++o) {
        if (!o->name) to = add_settings(to, group), group = o->help;
        *to = *o;
        if (o->take == take_aovs) to->help = aov_help();
        ++to;
    }
    add_settings(to, group);
    return all;
}

void render_options_default(render_options *options) {
    *options = (render_options){.checkpoint_every = -1, .frames = FRAMES_NONE};
    fathom_settings_default(&options->asked);
    fathom_write_options_default(&options->write);
    fathom_part_default(&options->part);
}
