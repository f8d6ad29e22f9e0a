/* Measures reading, building and rendering, phase by phase. */
#pragma once

#include "measure/render_time.h"
#include "measure/stage.h"

/* Reading and building are not repeated once their runs took longer than the options' `seconds`. The first
 * run is not counted. */

/* Measures reading a file that is in the system's cache. *scene is the scene that was read last; the caller
 * destroys it, whatever the status. */
fathom_status phases_read(fathom_context *context, const char *path, const fathom_read_options *read,
                          const render_time_options *options, fathom_scene **scene,
                          quartiles out[BENCH_CLOCKS]);

typedef struct phases {
    uint64_t bvh_bytes, peak_bytes; /* peak: while the tracer is built */
    quartiles build[BENCH_CLOCKS];  /* all work between the scene and the first ray */
    render_time time;
    char tracer[64];
} phases;

/* words: the words of the tracer. */
fathom_status phases_measure(fathom_context *context, const fathom_scene *scene,
                             const fathom_settings *settings, const char *words,
                             const render_time_options *options, phases *out);
