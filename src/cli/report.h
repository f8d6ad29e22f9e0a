/* Pages of results: DIR/results.json, and DIR/index.html drawn from it by share/fathom/report/report.py. */
#pragma once

#include <fathom/base.h>
#include <jansson.h>

/* Checks the output files of a command before any work is done. Each of the two `files` may be NULL, or
 * "-" for standard output; `report`, a folder, and `input` may be NULL. FATHOM_BAD_USAGE: two are the same
 * file; FATHOM_OUT_OF_RESOURCES: one cannot be written; `report` cannot become a folder, or its index.html is
 * not a report; or a package that draws pages is missing. */
fathom_status report_check_files(fathom_context *context, const char *const files[2], const char *report,
                                 const char *input);

/* Creates the folder if needed. Each of the two files is written whole or not at all. */
fathom_status report_write(fathom_context *context, const char *folder, const json_t *results);
