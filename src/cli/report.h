/* Pages of results: DIR/results.json, and DIR/index.html drawn from it by share/fathom/report/report.py. */
#ifndef CLI_REPORT_H
#define CLI_REPORT_H

#include <fathom/base.h>
#include <jansson.h>

/* Before any work is done: FATHOM_OUT_OF_RESOURCES when `folder` is no folder and cannot become one, holds an
 * index.html that no report has written, or when a page cannot be drawn because a package is missing. The
 * message says which. */
fathom_status report_check(fathom_context *context, const char *folder);

/* The files that a report writes, for outputs_check_distinct(); `out` has room for PATH_MAX bytes each. */
#define REPORT_FILES 2
void report_paths(const char *folder, char *page, char *results);

/* Makes the folder if need be. Both files are whole or not there at all. */
fathom_status report_write(fathom_context *context, const char *folder, const json_t *results);

#endif
