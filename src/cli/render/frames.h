/* Frames of an animation, one image each. */
#pragma once

#include "cli/args.h"

#include <limits.h>

/* first > last: no frames were requested. */
typedef struct render_frames {
    uint32_t first, last;
    double fps; /* 0: not given */
} render_frames;

#define FRAMES_NONE ((render_frames){.first = 1})
static inline bool frames_asked(const render_frames *frames) { return frames->first <= frames->last; }

/* "1-24" or "7". */
bool take_frames(const args_option *option, const char *value, void *field, args_problem *problem);
/* The time of a frame, in seconds. */
double frames_time(const render_frames *frames, uint32_t frame);
/* Replaces the last run of # in the path with the frame's number, padded to the width of the run. False: the
 * path has no #, or the result is too long. */
bool frames_name(const char *path, uint32_t frame, char out[PATH_MAX]);
