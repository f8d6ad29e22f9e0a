/* The options of `fathom render`. */
#pragma once

#include "cli/command.h"

#include <fathom/session.h>
#include <limits.h>

/* Frames of an animation, one image each. first > last: none were requested. */
typedef struct render_frames {
    uint32_t first, last;
    double fps; /* 0: not given */
} render_frames;

#define FRAMES_NONE ((render_frames){.first = 1})
static inline bool frames_asked(const render_frames *frames) { return frames->first <= frames->last; }
/* Replaces the last run of # in the path with the frame's number, padded to the width of the run. False: the
 * path has no #, or the result is too long. */
bool frames_name(const char *path, uint32_t frame, char out[PATH_MAX]);

typedef struct render_background {
    bool given;
    float rgb[3];
} render_background;

/* How the exposure of files for the display is chosen. */
typedef enum exposure_rule {
    EXPOSURE_USUAL, /* 0; but as EXPOSURE_AUTO if most pixels would be white or nearly black */
    EXPOSURE_AUTO,  /* computed from the finished film */
    EXPOSURE_GIVEN,
    EXPOSURE_KEPT /* that of the sequence of frames, or of the parts */
} exposure_rule;

typedef struct render_options {
    command_common common;
    const char *scene;
    args_list outputs;
    fathom_settings
        asked; /* from the command line; only those in `given` are set: bits by index in the table */
    uint64_t given;
    fathom_settings settings; /* the scene's, overridden by the given ones: see render_options_finish() */
    command_model model;
    render_frames frames;
    double max_time; /* limit in seconds for the whole command; 0: none */
    args_size size;  /* 0 × 0: the settings' own */
    render_background background;
    bool no_floor, no_studio;
    const char *environment;     /* NULL: none */
    double environment_rotation; /* degrees */
    fathom_write_options write;
    exposure_rule exposure;
    bool in_studio; /* found with the exposure: the built-in studio lights the image */
    fathom_loss loss;
    const char *stats;       /* NULL: none */
    const char *checkpoint;  /* NULL: none */
    double checkpoint_every; /* seconds; < 0: not given */
    bool resume;
    fathom_part part; /* path NULL: the whole image */
    args_many parts;  /* files of `fathom merge` */
    bool mpi;
    bool verbose;
} render_options;

void render_options_default(render_options *options);
/* Call after parsing. Computes the settings: the scene's, overridden by those of the command line. Called
 * with the default settings to find wrong usage before anything is read, then with the scene's. False: wrong
 * usage. */
bool render_options_finish(render_options *options, const fathom_settings *scene, args_problem *problem);
/* False: an option about images applies to none of them. */
bool render_options_check_images(const render_options *options, args_problem *problem);
/* Room for the names of a frame's files. */
typedef struct frame_names {
    char names[ARGS_LIST_MAX + 3][PATH_MAX];
} frame_names;

/* Sets the file names and the time of one frame, before the options are finished. False: wrong usage. */
bool render_options_frame(render_options *options, uint32_t frame, frame_names *room, args_problem *problem);
/* True if the command line sets the setting with this name. */
bool render_options_give(const render_options *options, const char *name);

const args_option *render_option_table(void);
/* The options of `fathom merge`, which fill the same struct. */
extern const args_option merge_option_table[];
