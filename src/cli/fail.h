/* Failures of the program's own, as the context's error. */
#ifndef CLI_FAIL_H
#define CLI_FAIL_H

#include <fathom/base.h>

/* Each stores the error and returns the status. The text says what was found and what was expected. */
fathom_status cli_fail(fathom_context *context, fathom_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
fathom_status cli_fail_file(fathom_context *context, fathom_status status, const char *file,
                            const char *format, ...) __attribute__((format(printf, 4, 5)));
fathom_status cli_fail_memory(fathom_context *context);

/* Adds the file to an error that names none, such as how a scene's parts fit together. */
void cli_fail_within(fathom_context *context, const char *file);

#endif
