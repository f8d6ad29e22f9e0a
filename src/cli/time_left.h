/* Of --max-time, what rendering may take. */
#ifndef CLI_TIME_LEFT_H
#define CLI_TIME_LEFT_H

#include "cli/render_options.h"

/* Seconds that writing the outputs is expected to take. */
double time_to_write(const render_options *options);

/* Sets settings.max_time to what is left, at `elapsed` seconds after the start, when the writing is taken
 * off. FATHOM_BAD_USAGE when nothing is. Does nothing without --max-time. */
fathom_status time_left(fathom_context *context, double elapsed, render_options *options);

#endif
