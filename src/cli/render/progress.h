/* Progress on stderr: a bar redrawn in place on a terminal; otherwise lines with percent, or JSON. */
#pragma once

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

/* quiet: shows nothing. work: the name of the rendering phase, such as "render"; the caller owns the text. */
void progress_begin(bool quiet, const char *work);

/* Begins a phase that reports no progress; a terminal shows its name. */
void progress_phase(fathom_phase phase);
void progress_update(const fathom_progress *progress);
/* The same for work other than a render that began at this time of clock_seconds(). */
void progress_work(double began, double fraction, uint64_t rays);
/* Prints "takes about 12:30", unless that is short. */
void progress_estimate(double seconds);

/* Removes the bar, so that a line can be printed in its place; the next update draws it again. */
void progress_clear_line(void);
/* The text that clears the line, for a signal handler; "" if there is no bar. */
const char *progress_clear_text(void);

/* The text of the bar for a terminal with this many columns; at most columns - 1 characters. */
void progress_bar(const fathom_progress *progress, unsigned columns, char *out, size_t size);
/* The same facts as one line: "render 30 %, 45.2 Mrays/s, 0:12 left". */
void progress_line(const fathom_progress *progress, char *out, size_t size);

#ifdef __cplusplus
}
#endif
