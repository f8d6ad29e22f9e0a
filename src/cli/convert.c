#include "cli/command.h"
#include "cli/fail.h"
#include "cli/outputs.h"

#include "base/clock.h"
#include "base/file_name.h"

#include <fathom/file.h>
#include <fathom/read.h>
#include <limits.h>
#include <stdio.h>

typedef struct convert_settings {
    command_common common;
    command_model model;
    const char *input, *output;
} convert_settings;

/* An .obj has its materials next to it, in an .mtl. */
static fathom_status check(fathom_context *context, const convert_settings *settings) {
    const char *output = settings->output;
    char library[PATH_MAX];
    const char *const written[2] = {output, library};
    const bool two = file_ends_in(output, "obj");
    if (!file_ends_in(output, "glb|json|obj|ply"))
        return cli_fail(context, FATHOM_BAD_USAGE,
                        "OUT: expected a name that ends in .glb, .json, .obj or .ply, found \"%.200s\"",
                        output);
    snprintf(library, sizeof library, "%.*s.mtl", (int)file_stem_length(output), output);
    const fathom_status status = outputs_check_distinct(context, written, two ? 2 : 1, settings->input);
    return status == FATHOM_OK ? fathom_file_check(context, output) : status;
}

static fathom_status convert(fathom_context *context, void *user) {
    const convert_settings *settings = user;
    const fathom_read_options options = command_read_options(&settings->model);
    const double start = clock_seconds();
    fathom_scene *scene = NULL;
    fathom_status status = check(context, settings);
    if (status == FATHOM_OK) status = fathom_scene_read_with(context, settings->input, &options, &scene);
    if (status == FATHOM_OK) status = fathom_scene_write(scene, settings->output);
    fathom_scene_destroy(scene);
    if (status == FATHOM_OK && !settings->common.quiet) print_written(settings->output, start);
    return say_status(&command_convert, context, status);
}

static const args_option options[] = {
    {.help = "Options"},
    COMMAND_MODEL(convert_settings),
    {"allow-outside", 0, NULL, take_true, offsetof(command_common, allow_outside), 0, 0,
     "allow files outside the folder of IN"},
    COMMAND_THREADS,
    COMMAND_QUIET("only errors and warnings"),
    {.help = NULL},
};

const command command_convert = {
    .name = "convert",
    .usage = "IN OUT.{glb,json,obj,ply} [options]",
    .summary = "Write a scene or a model in another format.",
    .text = "IN is any file that fathom render reads. OUT keeps what its format can hold:\n"
            "  .json  all of it; images that are not in the folder of OUT are copied there\n"
            "  .glb   meshes, instances, materials, images, lights and the camera\n"
            "  .obj   meshes, instances expanded; materials in an .mtl next to it\n"
            "  .ply   meshes, instances expanded; one image of colours next to it\n"
            "Quads and spheres become triangles in all but .json.\n"
            "Warnings name and count what OUT cannot hold. The camera and lights that a\n"
            "render adds to IN are not written, because a render of OUT adds them again.\n",
    .examples = "  fathom convert model.gltf model.glb\n"
                "  fathom convert walk.glb pose.json --time 1.5\n",
    .args = {options,
             {{"IN", offsetof(convert_settings, input)}, {"OUT", offsetof(convert_settings, output)}}},
    COMMAND_BODY(convert, convert_settings, {.input = NULL}),
};
