/* Lines of `fathom validate --failures`, read back by --replay. */
#ifndef CLI_RAY_LINE_H
#define CLI_RAY_LINE_H

#include "base/file.h"
#include "verify/ask.h"

/* The prefix of the verdict of a ray that was asked for any hit. */
#define RAY_LINE_ANY "any-"

typedef struct ray_line {
    char spec[128], family[32], scene[4096];
    unsigned long long index;
    bool any;
    oracle_ray ray; /* any numbers at all: rays_allowed() tells whether they are a ray */
    bool has_block; /* what follows is set: a line that begins with + and one for each ray of the call */
    char way[32];
    ask_block block;
    ask_answer given;
} ray_line;

/* A file under reading. */
typedef struct ray_lines {
    fathom_context *context;
    const char *path;
    const char *at, *end; /* zeros follow */
    unsigned number;      /* of the line read last, from 1; 0 at first */
} ray_lines;

/* The next ray; *found is false at the end. Empty lines and those that begin with # are passed over.
 * FATHOM_BAD_INPUT names file and line. */
fathom_status ray_lines_next(ray_lines *lines, ray_line *out, bool *found);

#endif
