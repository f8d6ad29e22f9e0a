/* Of --max-time, what rendering may take. */
#ifndef CLI_TIME_LEFT_H
#define CLI_TIME_LEFT_H

#include "cli/render/render_options.h"
#include "job/job.h"

/* Sets settings.max_time to what is left at `elapsed` seconds after the start, for rendering and writing.
 * FATHOM_BAD_USAGE when nothing is. Does nothing without --max-time. */
fathom_status time_left(fathom_context *context, double elapsed, render_options *options);

typedef struct time_outputs {
    fathom_context *context;
    const render_options *options;
} time_outputs;

/* What writing the outputs takes; outputs must outlive it. */
job_reserve time_to_write(const time_outputs *outputs);

#endif
