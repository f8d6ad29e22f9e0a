#include "cli/render/render_options.h"

#include "cli/command.h"
#include "cli/outputs.h"

#include "base/file.h"
#include "image/image.h"
#include "trace/spec.h"

#include <string.h>
#include <strings.h>

static bool take_crop(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option;
    uint64_t c[4];
    const char *text = value;
    for (size_t i = 0; i < 4; ++i) {
        if (!args_read_u64(&text, i < 3 ? ',' : '\0', &c[i]) || c[i] > 65536)
            return args_wrong(problem, "expected X0,Y0,X1,Y1 in pixels, such as 0,0,640,360, found \"%.60s\"",
                              value);
    }
    if (c[0] >= c[2] || c[1] >= c[3])
        return args_wrong(problem, "expected X0 < X1 and Y0 < Y1, found \"%.60s\"", value);
    for (size_t i = 0; i < 4; ++i) ((uint32_t *)field)[i] = (uint32_t)c[i];
    return true;
}

static bool take_epsilon(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option;
    double epsilon;
    const char *text = value;
    if (strcmp(value, "auto") == 0) {
        epsilon = 0;
    } else if (!args_read_f64(&text, '\0', &epsilon) || epsilon <= 0) {
        return args_wrong(problem, "expected auto or a number above 0, found \"%.60s\"", value);
    }
    *(double *)field = epsilon;
    return true;
}

static bool take_exposure(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_options *options = field;
    options->exposure_auto = strcmp(value, "auto") == 0;
    options->write.exposure = 0;
    return options->exposure_auto || take_f32(option, value, &options->write.exposure, problem);
}

static bool take_block_width(const args_option *option, const char *value, void *field,
                             args_problem *problem) {
    unsigned place;
    if (!take_choice(option, value, &place, problem)) return false;
    static const unsigned widths[] = {1, 4, 8, 16};
    *(unsigned *)field = widths[place];
    return true;
}

static bool take_tile_size(const args_option *option, const char *value, void *field, args_problem *problem) {
    uint32_t size;
    if (!take_u32(option, value, &size, problem)) return false;
    if (size % 32) return args_wrong(problem, "expected a multiple of 32, found \"%.60s\"", value);
    *(unsigned *)field = size;
    return true;
}

static bool take_rgb(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_background background = {.given = true};
    const char *text = value;
    for (size_t i = 0; i < 3; ++i) {
        double number;
        if (!args_read_f64(&text, i < 2 ? ',' : '\0', &number) || number < option->least ||
            number > option->most) {
            return args_wrong(problem,
                              "expected R,G,B, each from %g to %g, such as 0.5,0.7,1, found \"%.60s\"",
                              option->least, option->most, value);
        }
        background.rgb[i] = (float)number;
    }
    *(render_background *)field = background;
    return true;
}

static bool take_tracer(const args_option *option, const char *value, void *field, args_problem *problem) {
    trace_spec spec;
    fathom_context *context;
    *(const char **)field = value;
    if (trace_spec_parse(NULL, value, &spec) == FATHOM_OK) return true;
    /* Once more, for the words: what is right takes no memory. */
    if (fathom_context_create(&context) != FATHOM_OK)
        return args_wrong(problem, "expected %s, found \"%.60s\"", option->value, value);
    trace_spec_parse(context, value, &spec);
    args_wrong(problem, "%s", fathom_context_message(context));
    fathom_context_destroy(context);
    return false;
}

typedef struct named_bits {
    const char *name; /* NULL ends a table */
    unsigned bits;
} named_bits;

static const named_bits aov_names[] = {{"alpha", FATHOM_AOV_ALPHA},
                                       {"Z", FATHOM_AOV_Z},
                                       {"N", FATHOM_AOV_N},
                                       {"P", FATHOM_AOV_P},
                                       {"albedo", FATHOM_AOV_ALBEDO},
                                       {"id", FATHOM_AOV_ID},
                                       {"samples", FATHOM_AOV_SAMPLES},
                                       {"all", FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ALPHA},
                                       {"none", 0},
                                       {NULL, 0}};

static bool find_bits(const named_bits *table, const char *name, size_t length, unsigned *bits) {
    for (; table->name; ++table) {
        if (strlen(table->name) != length || strncasecmp(table->name, name, length) != 0) continue;
        *bits |= table->bits;
        return true;
    }
    return false;
}

/* Names separated by commas. */
static bool take_bits(const named_bits *table, const char *expected, const char *value, unsigned *out,
                      args_problem *problem) {
    unsigned bits = 0;
    for (const char *name = value;;) {
        size_t length = strcspn(name, ",");
        if (!find_bits(table, name, length, &bits)) {
            return args_wrong(problem, "expected names from %s, found \"%.*s\"", expected,
                              length < 60 ? (int)length : 60, name);
        }
        if (!name[length]) break;
        name += length + 1;
    }
    *out = bits;
    return true;
}

static bool take_aovs(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option;
    render_options *options = field;
    options->aovs_given = true;
    return take_bits(aov_names, "alpha,Z,N,P,albedo,id,samples, or all, or none", value,
                     &options->settings.aovs, problem);
}

static bool take_spp(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_options *options = field;
    options->spp_given = true;
    return take_u32(option, value, &options->settings.spp, problem);
}

static bool take_min_spp(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_options *options = field;
    options->min_spp_given = true;
    return take_u32(option, value, &options->settings.min_spp, problem);
}

static bool take_pattern(const args_option *option, const char *value, void *field, args_problem *problem) {
    render_options *options = field;
    options->pattern_given = true;
    return take_choice(option, value, &options->settings.pattern, problem);
}

static bool take_above_zero(const args_option *option, const char *value, void *field,
                            args_problem *problem) {
    double number;
    const char *text = value;
    if (!args_read_f64(&text, '\0', &number) || number <= 0 || number > option->most) {
        return args_wrong(problem, "expected a number above 0, at most %g, found \"%.60s\"", option->most,
                          value);
    }
    *(double *)field = number;
    return true;
}

#define FIELD(name) offsetof(render_options, name)

const args_option render_option_table[] = {
    {.help = "Output"},
    {"output", 'o', "IMAGE", take_output, FIELD(outputs), 0, 0,
     ".exr (scene-linear), .png, .jpg or .tif (8 bit, for the display); - is PNG to standard output, and "
     "exr:- "
     "another format; give it again for more images of the same render"},
    {"aov", 0, "LIST", take_aovs, 0, 0, 0,
     "further channels: any of alpha,Z,N,P,albedo,id,samples, or none; alpha makes the background "
     "transparent, "
     "and the others need an .exr; all: the others, without alpha"},
    {"exr-float", 0, NULL, take_true, FIELD(write.float_color), 0, 0,
     "colours in the .exr as 32-bit float rather than half"},
    {"stats", 0, "FILE.json", take_text, FIELD(stats), 0, 0,
     "write counts, times, rays and memory as JSON, with the command line and the scene's fingerprint; - is "
     "standard output"},

    {.help = "Image"},
    COMMAND_CAMERA(render_options),
    COMMAND_UP(render_options),
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536,
     "pixels (the scene's, else the shape its camera is made for, 1280 along the longer side, else "
     "1280x720)"},
    {"crop", 0, "X0,Y0,X1,Y1", take_crop, FIELD(settings.crop), 0, 0,
     "only these pixels: from (X0,Y0) up to but without (X1,Y1), counted from the top left"},
    {"spp", 0, "N", take_spp, 0, 1, 65536,
     "samples a pixel (a scene file's, else 1; 16 for models); a square number unless the pattern is sobol"},
    {"pattern", 0, "grid|stratified|sobol", take_pattern, 0, 0, 0,
     "where the samples lie (the scene's, else grid)"},
    {"seed", 0, "N", take_u64, FIELD(settings.seed), 0, 0, "of stratified and sobol samples (0)"},
    {"background", 0, "R,G,B", take_rgb, FIELD(background), 0, 1e9,
     "linear Rec.709 colour of rays that hit nothing (the scene's)"},

    {.help = "Sampling to an error or a time (with the pattern sobol)"},
    {"target-error", 0, "E", take_above_zero, FIELD(settings.target_error), 0, 1e9,
     "samples until the estimated error of each tile of 32x32 pixels is at most E, in the unit of Cycles' "
     "noise "
     "threshold; 0.01 is about 1 of 255 display levels"},
    {"max-time", 0, "SECONDS", take_above_zero, FIELD(max_time), 0, 1e9,
     "what the whole command takes, reading to writing; samples go where they lower the error most"},
    {"min-spp", 0, "N", take_min_spp, 0, 4, 65536,
     "samples of each pixel before an error is trusted, a power of two (4); --spp is then the most, a power "
     "of "
     "two (65536)"},

    {.help = "Saving on the way"},
    {"checkpoint", 0, "FILE", take_text, FIELD(checkpoint), 0, 0,
     "save the work to FILE on the way, on Ctrl-C or SIGTERM, and on SIGUSR1, after which it goes on; FILE "
     "is "
     "removed once the image is written, and is never taken for another render"},
    {"checkpoint-every", 0, "SECONDS", take_f64, FIELD(checkpoint_every), 0, 1e9,
     "from the end of one save to the next (60)"},
    {"resume", 0, NULL, take_true, FIELD(resume), 0, 0,
     "continue from the checkpoint, or begin where there is none: the image is the same to the last bit, on "
     "any "
     "number of threads; without it a FILE that is there is an error"},

    {.help = "Light transport"},
    {"max-depth", 0, "N", take_u32, FIELD(settings.max_depth), 0, 64,
     "mirrored and refracted bounces, 0 to 64 (8)"},
    {"leave-out-below", 0, "none|8bit|half", take_choice, FIELD(loss), 0, 0,
     "cast no shadow rays whose light would not show: a pixel of a .png or .tif (8bit) changes by at most "
     "one "
     "of 255 levels, of an .exr (half) by one unit in the last place (none)"},
    {"epsilon", 0, "E|auto", take_epsilon, FIELD(settings.epsilon), 0, 0,
     "fixed distance that rays keep from where they start; auto follows from error bounds (auto)"},
    {"no-terminator-fix", 0, NULL, take_false, FIELD(settings.terminator_fix), 0, 0,
     "let the facets of smooth meshes shadow themselves"},
    {"tracer", 0, "SPEC|FILE.so", take_tracer, FIELD(settings.tracer_spec), 0, 0,
     "what answers the rays (embree): embree, bvh, linear or reference, which is linear:robust:f32, each "
     "with "
     "options such as bvh:f64, linear:textbook:f32 or embree:user:high:16; or a library as in "
     "fathom/plugin.h"},

    {.help = "Colour of .png, .jpg and .tif"},
    {"exposure", 0, "STOPS|auto", take_exposure, 0, -64, 64,
     "each doubles the light (0); auto: 99 of 100 lit pixels are at most white"},
    {"display", 0, "NAME", take_text, FIELD(write.display), 0, 0, "of the OpenColorIO config (its default)"},
    {"view", 0, "NAME", take_text, FIELD(write.view), 0, 0, "of the display (its default)"},
    {"ocio", 0, "FILE", take_text, FIELD(write.ocio), 0, 0,
     "OpenColorIO config ($OCIO, else a built-in one for sRGB)"},

    {.help = "Running"},
    {"threads", 0, "N", take_u32, FIELD(threads), 1, 1024, "1 to 1024 (one a processor)"},
    {"memory-limit", 0, "BYTES", take_count, FIELD(settings.memory_limit), 1e6, 1e15,
     "most that may be in memory, as 8G (what is free); where only Embree's compact structures fit they are "
     "taken, and nothing is begun where not even they do"},
    {"block-width", 0, "1|4|8|16", take_block_width, FIELD(settings.block_width), 0, 0,
     "rays handed to Embree at once (16); no pixel depends on it"},
    {"tile-size", 0, "N", take_tile_size, FIELD(settings.tile_size), 32, 65536,
     "pixels, a multiple of 32 (32); no pixel depends on it"},
    COMMAND_ALLOW_OUTSIDE(render_options),
    {"quiet", 'q', NULL, take_true, FIELD(quiet), 0, 0, "only errors and warnings"},
    {"verbose", 'v', NULL, take_true, FIELD(verbose), 0, 0,
     "tell what was traced and how long each step took"},
    {.help = NULL},
};

void render_options_default(render_options *options, const fathom_settings *settings) {
    *options = (render_options){.settings = *settings,
                                .checkpoint_every = -1,
                                .scene_adaptive = settings->target_error > 0 || settings->max_time > 0};
    fathom_write_options_default(&options->write);
}

/* The AOVs that at least one of the outputs can hold: .exr all, .png and .tif alpha, .jpg none. */
static unsigned held_aovs(const args_list *outputs) {
    unsigned held = 0;
    for (size_t i = 0; i < outputs->count; ++i) {
        char extension[16];
        file_extension(outputs->items[i], extension);
        if (strcmp(extension, "exr") == 0) return ~0u;
        if (strncmp(extension, "jp", 2) != 0) held |= FATHOM_AOV_ALPHA;
    }
    return held;
}

/* What the scene's file says about sampling is meant for as many samples everywhere. */
static bool finish_adaptive(render_options *options, args_problem *problem) {
    fathom_settings *s = &options->settings;
    if (options->max_time > 0) s->max_time = options->max_time;
    if (!(s->target_error > 0 || s->max_time > 0)) return true;
    if (options->pattern_given && s->pattern != FATHOM_PATTERN_SOBOL) {
        return args_wrong(
            problem, "--pattern: --target-error and --max-time need --pattern sobol, whose samples can be "
                     "added to");
    }
    if (options->scene_adaptive) return true;
    s->pattern = FATHOM_PATTERN_SOBOL;
    if (!options->spp_given) s->spp = 65536;
    return true;
}

/* What the view makes of a loss is known of the built-in one alone. */
static bool finish_loss(render_options *options, args_problem *problem) {
    if (options->loss == FATHOM_LOSS_8BIT && !image_view_is_srgb(&options->write)) {
        return args_wrong(problem, "--leave-out-below 8bit: what shows is known of the built-in sRGB view "
                                   "alone; expected no --ocio, --display, --view and no $OCIO");
    }
    if (options->loss == FATHOM_LOSS_8BIT && options->exposure_auto)
        return args_wrong(problem, "--leave-out-below 8bit: needs the exposure before rendering; expected "
                                   "--exposure STOPS rather than auto");
    fathom_settings_set_loss(&options->settings, options->loss, options->write.exposure);
    return true;
}

bool render_options_finish(render_options *options, args_problem *problem) {
    if (!options->outputs.count) return args_wrong(problem, "-o IMAGE is missing");
    if (options->size.width) {
        options->settings.width = options->size.width;
        options->settings.height = options->size.height;
    }
    if (options->quiet && options->verbose)
        return args_wrong(problem, "--quiet and --verbose exclude each other");
    if (!options->checkpoint && (options->resume || options->checkpoint_every >= 0)) {
        return args_wrong(problem, "--%s: only with --checkpoint FILE",
                          options->resume ? "resume" : "checkpoint-every");
    }
    if (!finish_adaptive(options, problem) || !finish_loss(options, problem)) return false;
    unsigned held = held_aovs(&options->outputs);
    if (options->aovs_given && options->settings.aovs & ~held)
        return args_wrong(problem, "--aov: only .exr holds these channels; expected one more -o FILE.exr");
    options->settings.aovs &= held;
    return true;
}
