/* Frames of an animation, one image each. */
#ifndef CLI_FRAMES_H
#define CLI_FRAMES_H

#include "cli/args.h"

#include <limits.h>

/* first > last: none asked for. */
typedef struct render_frames {
    uint32_t first, last;
    double fps; /* 0: not given */
} render_frames;

#define FRAMES_NONE ((render_frames){.first = 1})
static inline bool frames_asked(const render_frames *frames) { return frames->first <= frames->last; }

/* "1-24" or "7". */
bool take_frames(const args_option *option, const char *value, void *field, args_problem *problem);
/* Seconds. */
double frames_time(const render_frames *frames, uint32_t frame);
/* The path with the frame's number in place of its first run of #, as wide as that or wider. False where it
 * has none, or would be too long. */
bool frames_name(const char *path, uint32_t frame, char out[PATH_MAX]);

#endif
