/* Failures of the command-line program, as errors of the context. */
#pragma once

#include <fathom/base.h>
#include <stddef.h>

/* Stores the error and returns the status. The text states what was found and what was expected. */
fathom_status cli_fail_file(fathom_context *context, fathom_status status, const char *file,
                            const char *format, ...) __attribute__((format(printf, 4, 5)));
#define cli_fail(context, status, ...) cli_fail_file(context, status, NULL, __VA_ARGS__)
#define cli_fail_memory(context) cli_fail(context, FATHOM_OUT_OF_RESOURCES, "out of memory")

/* Adds the file to an error that names none, for example an error in how the parts of a scene fit
 * together. */
void cli_fail_within(fathom_context *context, const char *file);
