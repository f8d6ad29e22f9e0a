#include "cli/command.h"
#include "cli/outputs.h"

#include "base/clock.h"
#include "base/text.h"

#include <fathom/file.h>
#include <fathom/texture.h>
#include <string.h>

typedef struct texture_settings {
    command_common common;
    const char *input, *output, *color;
} texture_settings;

static fathom_texture describe(const texture_settings *settings) {
    fathom_texture t;
    fathom_texture_default(&t);
    t.file = settings->input;
    const int known = words_find("auto|srgb|linear", settings->color, strlen(settings->color));
    t.color_space = known < 0 ? FATHOM_COLOR_NAMED : (fathom_color_space)known;
    t.color_space_name = settings->color;
    return t;
}

static fathom_status check_and_write(fathom_context *context, void *user) {
    const texture_settings *settings = user;
    if (!settings->output) return say_usage(&command_texture, "-o FILE is missing");
    const fathom_texture texture = describe(settings);
    const double start = clock_seconds();
    fathom_status status = outputs_check_distinct(context, &settings->output, 1, settings->input);
    if (status == FATHOM_OK) status = fathom_file_check(context, settings->output);
    if (status == FATHOM_OK) status = fathom_texture_write(context, &texture, settings->output);
    if (status != FATHOM_OK || settings->common.quiet) return say_status(&command_texture, context, status);
    print_written(settings->output, start);
    return FATHOM_OK;
}

static const args_option options[] = {
    {.help = "Options"},
    {"output", 'o', "FILE", take_text, offsetof(texture_settings, output), 0, 0, ".tx, .tif or .tiff"},
    {"color", 0, "SPACE", take_text, offsetof(texture_settings, color), 0, 0,
     "color space of the image: srgb; linear, also for data such as normals; auto: as the file "
     "says, else srgb for integers and linear for half and float; or a color space of the "
     "OpenColorIO config $OCIO, which is converted to linear Rec.709 (auto)"},
    COMMAND_THREADS,
    COMMAND_QUIET("only errors and warnings"),
    {.help = NULL},
};

const command command_texture = {
    .name = "texture",
    .usage = "IMAGE -o FILE.tx [--color SPACE]",
    .summary = "Convert an image to a tiled, mip-mapped texture.",
    .text = "A render reads only the tiles of such a file that it needs, and does not have to\n"
            "compute the mip levels. The levels are averages of linear values, so data need\n"
            "--color linear. The file says which it has, and keeps the number type of the\n"
            "image. A scene can use it in place of the image.\n",
    .examples = "  fathom texture wood.png -o wood.tx\n"
                "  fathom texture normals.png -o normals.tx --color linear\n",
    .args = {options, {{"IMAGE", offsetof(texture_settings, input)}}},
    COMMAND_BODY(check_and_write, texture_settings, {.color = "auto"}),
};
