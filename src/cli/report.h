/* Pages of results: DIR/results.json, and DIR/index.html drawn from it by share/fathom/report/report.py. */
#ifndef CLI_REPORT_H
#define CLI_REPORT_H

#include <fathom/base.h>
#include <jansson.h>

/* Checks the files of a command that writes results before any work is done. Each of `files` (at most 4) may
 * be NULL, or "-" for standard output; `report`, a folder, and `input` may be NULL. FATHOM_BAD_USAGE when two
 * are the same file; FATHOM_OUT_OF_RESOURCES when one cannot be written, `report` cannot become a folder or
 * holds an index.html of something else, or a package that draws pages is missing. */
fathom_status report_check_files(fathom_context *context, const char *const *files, size_t count,
                                 const char *report, const char *input);

/* Makes the folder if need be. Both files are whole or not there at all. */
fathom_status report_write(fathom_context *context, const char *folder, const json_t *results);

#endif
