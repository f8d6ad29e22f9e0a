/* What `fathom render` is told. */
#ifndef CLI_RENDER_OPTIONS_H
#define CLI_RENDER_OPTIONS_H

#include "cli/args.h"

#include <fathom/read.h>

typedef struct render_background {
    bool given;
    float rgb[3];
} render_background;

typedef struct render_options {
    const char *scene;
    args_list outputs;
    fathom_settings settings;
    const char *camera; /* NULL: the scene's first */
    fathom_up up;
    bool aovs_given, spp_given, pattern_given, min_spp_given;
    bool scene_adaptive; /* the scene's own spp is the most of any pixel */
    double max_time;     /* seconds of the whole command; 0: none */
    args_size size;      /* 0 × 0: the settings' own */
    unsigned threads;    /* 0: all processors */
    render_background background;
    fathom_write_options write;
    bool exposure_auto; /* found once the film is there */
    fathom_loss loss;
    const char *stats;       /* NULL: none */
    const char *checkpoint;  /* NULL: none */
    double checkpoint_every; /* seconds; < 0: not given */
    bool resume;
    bool quiet, verbose, allow_outside;
} render_options;

/* Everything not given stays as `settings` says. */
void render_options_default(render_options *options, const fathom_settings *settings);
/* What the options' fields make of each other, after parsing. False: wrong usage. */
bool render_options_finish(render_options *options, args_problem *problem);

extern const args_option render_option_table[];

#endif
