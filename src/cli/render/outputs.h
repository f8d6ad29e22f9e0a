/* Checks of what will be written, before any work is done for it. */
#ifndef CLI_OUTPUTS_H
#define CLI_OUTPUTS_H

#include <fathom/base.h>

/* FATHOM_BAD_USAGE when two of the outputs, or one of them and `input` (may be NULL), are the same file,
 * however they are spelled. From then on reading one of them is FATHOM_BAD_USAGE, whatever scene names it. */
fathom_status outputs_check_distinct(fathom_context *context, const char *const *outputs, size_t count,
                                     const char *input);

/* Whether both paths lead to one file, or would. */
bool outputs_are_same(const char *a, const char *b);

/* A file that is no image: whole or not at all. "-" is standard output (standard_output.h). */
fathom_status outputs_write(fathom_context *context, const char *path, const char *bytes, size_t size);

/* Reads what it likes from now on. */
void outputs_may_be_read(fathom_context *context);

#endif
