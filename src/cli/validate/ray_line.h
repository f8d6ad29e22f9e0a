/* Lines of `fathom validate --failures`, read back by --replay. */
#pragma once

#include "verify/ask.h"

/* Prefix of the verdict of any-hit rays. */
#define RAY_LINE_ANY "any-"

typedef struct ray_line {
    char spec[128], family[32], scene[4096];
    unsigned long long index;
    bool any;
    oracle_ray ray; /* may hold any numbers: rays_allowed() checks whether they form a valid ray */
    bool has_block; /* the members below are set: the ray has a line that begins with +, and a line for each
                       ray of the call */
    char way[32];
    ask_block block;
    ask_answer given;
} ray_line;

/* A file that is being read. */
typedef struct ray_lines {
    fathom_context *context;
    const char *path;
    const char *at, *end; /* zero bytes follow `end` */
    unsigned number;      /* number of the last line read, from 1; 0 at first */
} ray_lines;

/* Reads the next ray; *found is false at the end. Skips empty lines and those that begin with #.
 * FATHOM_BAD_INPUT names file and line. */
fathom_status ray_lines_next(ray_lines *lines, ray_line *out, bool *found);
