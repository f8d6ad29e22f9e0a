/* Pages of results: DIR/results.json, and DIR/index.html drawn from it by share/fathom/report/report.py. */
#ifndef CLI_REPORT_H
#define CLI_REPORT_H

#include <fathom/base.h>
#include <jansson.h>

/* Before any work is done, for the files of a command that writes results: each of `files` (at most 4) may be
 * NULL, or "-" for standard output; `report`, a folder, and `input` may be NULL. FATHOM_BAD_USAGE when two of
 * them are the same file; FATHOM_OUT_OF_RESOURCES when one cannot be written, `report` is no folder and
 * cannot become one, holds an index.html that no report has written, or when a package that draws pages is
 * missing: the message says which. */
fathom_status report_check_files(fathom_context *context, const char *const *files, size_t count,
                                 const char *report, const char *input);

/* Makes the folder if need be. Both files are whole or not there at all. */
fathom_status report_write(fathom_context *context, const char *folder, const json_t *results);

#endif
