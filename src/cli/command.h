/* The subcommands, and the code that they share. */
#pragma once

#include "cli/args.h"

#include <fathom/read.h>
#include <stdio.h>

/* Does the work of a command, and prints its own errors. */
typedef fathom_status (*command_body)(fathom_context *context, void *settings);

typedef struct command {
    const char *name;
    const char *usage;   /* "SCENE -o IMAGE [-o IMAGE2 ...] [options]" */
    const char *summary; /* one line, for the list of commands */
    const char *text;    /* paragraphs between the usage and the options */
    const char *examples;
    args_spec args;
    fathom_status (*run)(int argc, char **argv); /* NULL: by the following */
    command_body body;
    const void *defaults; /* of its settings, which begin with a command_common */
    size_t size;          /* of the settings, at most COMMAND_SETTINGS_MOST */
} command;

#define COMMAND_SETTINGS_MOST 2048
#define COMMAND_BODY(function, type, ...)                                                                    \
    .body = function, .defaults = &(const type)__VA_ARGS__, .size = sizeof(type)

fathom_status command_run(const command *c, int argc, char **argv);

extern const command command_render, command_merge, command_info, command_generate, command_convert,
    command_texture, command_compare, command_validate, command_bench, command_help;

/* All commands, and those of two words, `fathom bench WHAT`; NULL ends both. */
extern const command *const commands[];
extern const command *const benches[];

/* By its last word. NULL: there is none; `problem` says so and names the nearest. */
const command *command_find(const command *const *among, const char *name, args_problem *problem);

void help_overview(FILE *out);
void help_command(const command *c, FILE *out);

/* Prints a name that may come from a file, with '?' for bytes that could steer a terminal. */
void print_name(FILE *out, const char *name);
/* The size of a file, such as "3.5 kB" or "1200.0 MB". */
void print_file_size(FILE *out, const char *path);
/* The name and size of the only output of a command, and how long that took since `start`. */
void print_written(const char *path, double start);

/* Says on stderr what is wrong, and how to get help; returns FATHOM_BAD_USAGE. c: NULL if no command was
 * found. */
fathom_status say_usage(const command *c, const char *text);

/* Prints the context's message if `status` is a failure, and returns the status. */
fathom_status say_status(const command *c, const fathom_context *context, fathom_status status);

/* Reads the command line into `settings`. False: the command has ended, with the exit code *status. */
bool command_parse(const command *c, int argc, char **argv, void *settings, fathom_status *status);

/* The options that choose the part of a model to read, and how to read it. */
typedef struct command_model {
    const char *camera, *variant, *scene; /* NULL: the first, or none */
    fathom_up up;
    unsigned unit; /* index in COMMAND_UNITS */
    args_f64 time;
    args_f64 shutter, azimuth, elevation;
    args_list animations;
} command_model;

#define COMMAND_UNITS "m|mm|cm|dm|km|in|ft"
fathom_read_options command_read_options(const command_model *model);

/* Rows for settings with a command_model named model. */
#define COMMAND_MODEL_ROW(settings, name, word, take, field, ...)                                            \
    ARGS_ROW(name, 0, word, take, offsetof(settings, model.field), __VA_ARGS__)
#define COMMAND_MODEL(settings)                                                                              \
    COMMAND_MODEL_ROW(                                                                                       \
        settings, "camera", "NAME|N", take_text, camera, 0, 0,                                               \
        "which camera of a .gltf or .glb file: the name of its node, its own name, or its number "           \
        "from 0 in the list of fathom info (the first perspective camera, else the first)"),                 \
        COMMAND_MODEL_ROW(settings, "scene", "NAME|N", take_text, scene, 0, 0,                               \
                          "which scene of a .gltf or .glb file, by its name or its number from 0 (the one "  \
                          "that the file chooses, else the first)"),                                         \
        COMMAND_MODEL_ROW(                                                                                   \
            settings, "time", "SECONDS", take_given_f64, time, -1e9, 1e9,                                    \
            "time of the image. A .gltf or .glb file takes the pose of its animations at this time "         \
            "(default: the pose at rest); scene JSON opens its shutter then (default: as the scene says)"),  \
        COMMAND_MODEL_ROW(                                                                                   \
            settings, "shutter", "SECONDS", take_given_f64, shutter, 0, 1e9,                                 \
            "motion blur: opens the shutter at --time for so long, in place of the shutter of scene JSON "   \
            "(none)"),                                                                                       \
        COMMAND_MODEL_ROW(                                                                                   \
            settings, "animation", "NAME|N", take_list, animations, 0, 0,                                    \
            "apply only this animation: its name, or its number from 0; give the option once for each of "   \
            "several (default: all, except those that move something that an earlier one moves)"),           \
        COMMAND_MODEL_ROW(                                                                                   \
            settings, "variant", "NAME|N", take_text, variant, 0, 0,                                         \
            "which material variant of a .gltf or .glb file, by its name or its number from 0 (none)"),      \
        COMMAND_MODEL_ROW(settings, "unit", COMMAND_UNITS, take_choice, unit, 0, 0,                          \
                          "unit of the model's lengths. The model is scaled to metres, the unit of lights "  \
                          "and of the AOVs Z and P (m)")

/* For commands that make a camera. */
#define COMMAND_VIEW(settings)                                                                               \
    COMMAND_MODEL_ROW(                                                                                       \
        settings, "up", "y|z", take_choice, up, 0, 0,                                                        \
        "up axis of the automatic camera and its lights (y); most CAD programs and scanners use z"),         \
        COMMAND_MODEL_ROW(settings, "azimuth", "DEGREES", take_given_f64, azimuth, -1e6, 1e6,                \
                          "how far the automatic camera, its lights and the floor turn around the model, "   \
                          "from the front to the right; 180 shows the back (24)"),                           \
        COMMAND_MODEL_ROW(settings, "elevation", "DEGREES", take_given_f64, elevation, -90, 90,              \
                          "height of the automatic camera above the floor as an angle; 90 looks straight "   \
                          "down (18)")

/* Options that most commands share: the first member of the settings. */
typedef struct command_common {
    unsigned threads; /* 0: one a processor */
    bool quiet, allow_outside;
} command_common;

#define COMMAND_THREADS                                                                                      \
    ARGS_ROW("threads", 0, "N", take_u32, offsetof(command_common, threads), 1, 1024,                        \
             "number of threads, 1 to 1024 (one per processor)")
#define COMMAND_QUIET(help)                                                                                  \
    ARGS_ROW("quiet", 'q', NULL, take_true, offsetof(command_common, quiet), 0, 0, help)
#define COMMAND_ALLOW_OUTSIDE                                                                                \
    ARGS_ROW("allow-outside", 0, NULL, take_true, offsetof(command_common, allow_outside), 0, 0,             \
             "allow files outside the folder of SCENE")

/* Creates a context with these options, whose warnings go to stderr. Prints the error if memory runs out. */
fathom_status command_context(const command_common *common, fathom_context **out);
