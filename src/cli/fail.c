#include "cli/fail.h"

#include <stdarg.h>
#include <stdio.h>

fathom_status cli_fail_file(fathom_context *context, fathom_status status, const char *file,
                            const char *format, ...) {
    char text[6144]; /* enough for a path and a message */
    const fathom_place place = {.file = file};
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return fathom_context_fail(context, &(fathom_error){status, &place, text});
}

void cli_fail_within(fathom_context *context, const char *file) {
    if (!*fathom_context_error(context)->place->file)
        fathom_context_fail_within(context, &(fathom_place){.file = file});
}
