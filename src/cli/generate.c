#include "cli/command.h"
#include "cli/fail.h"

#include "base/clock.h"
#include "base/file_name.h"

#include <fathom/file.h>
#include <fathom/read.h>
#include <fathom/survey.h>
#include <math.h>
#include <string.h>

typedef struct generate_settings {
    command_common common;
    const char *kind, *output;
    uint64_t triangles, seed;
} generate_settings;

static const char *const kinds[] = {"sphere", "terrain", "sponge", "forest"};
#define KIND_COUNT (sizeof kinds / sizeof *kinds)

static fathom_status find_kind(fathom_context *context, const char *name, fathom_generator *out) {
    for (size_t i = 0; i < KIND_COUNT; ++i) {
        if (strcmp(name, kinds[i]) != 0) continue;
        *out = (fathom_generator)i;
        return FATHOM_OK;
    }
    const char *nearest = args_nearest(name, kinds, KIND_COUNT);
    return cli_fail(context, FATHOM_BAD_USAGE,
                    "KIND: expected sphere, terrain, sponge or forest, found \"%.60s\"%s%s%s", name,
                    nearest ? "; did you mean " : "", nearest ? nearest : "", nearest ? "?" : "");
}

static fathom_status check(fathom_context *context, const generate_settings *settings,
                           fathom_generator *kind) {
    const fathom_status status = find_kind(context, settings->kind, kind);
    if (status != FATHOM_OK) return status;
    if (!settings->triangles) return cli_fail(context, FATHOM_BAD_USAGE, "--triangles N is missing");
    if (!settings->output) return cli_fail(context, FATHOM_BAD_USAGE, "-o FILE is missing");
    if (file_ends_in(settings->output, "glb|ply|obj")) return fathom_file_check(context, settings->output);
    return cli_fail(context, FATHOM_BAD_USAGE,
                    "-o: expected a name that ends in .glb, .ply or .obj, found \"%.200s\"",
                    settings->output);
}

static fathom_status generate(const generate_settings *settings, fathom_generator kind, fathom_scene *scene) {
    fathom_generate_options options;
    fathom_generate_options_default(&options);
    options.kind = kind;
    options.triangles = settings->triangles;
    options.seed = settings->seed;
    const double start = clock_seconds();
    fathom_status status = fathom_scene_generate(scene, FATHOM_ROOT, &options);
    const double made = clock_seconds();
    const fathom_survey *survey = NULL;
    if (status == FATHOM_OK && !settings->common.quiet) status = fathom_scene_survey(scene, &survey);
    const double counted = clock_seconds();
    if (status == FATHOM_OK) status = fathom_scene_write(scene, settings->output);
    const double written = clock_seconds();
    if (status == FATHOM_OK && survey) {
        print_name(stdout, settings->output);
        printf(": %llu triangles, ", (unsigned long long)survey->placed_triangles);
        print_file_size(stdout, settings->output);
        printf(", made in %.2f s, written in %.2f s\n", made - start, written - counted);
    }
    fathom_survey_destroy(survey);
    return status;
}

static fathom_status check_and_generate(fathom_context *context, void *user) {
    const generate_settings *settings = user;
    fathom_generator kind = FATHOM_GENERATE_SPHERE;
    fathom_scene *scene = NULL;
    fathom_status status = check(context, settings, &kind);
    if (status == FATHOM_OK) status = fathom_scene_create(context, &scene);
    if (status == FATHOM_OK) status = generate(settings, kind, scene);
    fathom_scene_destroy(scene);
    return say_status(&command_generate, context, status);
}

static const args_option options[] = {
    {.help = "Options"},
    {"triangles", 't', "N", take_u64, offsetof(generate_settings, triangles), 1, 1e11,
     "number of triangles, instances included, such as 20k or 8M. The result has the nearest "
     "number that the kind allows"},
    {"seed", 0, "N", take_u64, offsetof(generate_settings, seed), 0, HUGE_VAL,
     "seed of the random shape (0)"},
    {"output", 'o', "FILE", take_text, offsetof(generate_settings, output), 0, 0,
     ".glb (keeps instances, read without parsing), .ply (binary) or .obj"},
    COMMAND_THREADS,
    COMMAND_QUIET("only errors and warnings"),
    {.help = NULL},
};

const command command_generate = {
    .name = "generate",
    .usage = "KIND --triangles N [--seed S] -o FILE.{glb,ply,obj}",
    .summary = "Generate a mesh of any size.",
    .text = "KIND is one of\n"
            "  sphere   a displaced sphere: closed, smooth normals\n"
            "  terrain  a fractal height field over a square\n"
            "  sponge   a Menger sponge of instanced cells\n"
            "  forest   a terrain with instanced trees\n"
            "The same KIND, N and S always give the same file.\n",
    .examples = "  fathom generate sphere --triangles 8M -o heavy.glb\n"
                "  fathom render heavy.glb -o heavy.png\n",
    .args = {options, {{"KIND", offsetof(generate_settings, kind)}}},
    COMMAND_BODY(check_and_generate, generate_settings, {.kind = NULL}),
};
