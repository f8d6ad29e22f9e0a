#include "cli/fail.h"

#include <stdarg.h>
#include <stdio.h>

/* Enough for a path and what is said of it. */
#define TEXT_SIZE 6144

static fathom_status store(fathom_context *context, fathom_status status, const char *file,
                           const char *format, va_list args) {
    char text[TEXT_SIZE];
    const fathom_place place = {.file = file};
    vsnprintf(text, sizeof text, format, args);
    return fathom_context_fail(context, &(fathom_error){status, &place, text});
}

fathom_status cli_fail(fathom_context *context, fathom_status status, const char *format, ...) {
    va_list args;
    va_start(args, format);
    store(context, status, NULL, format, args);
    va_end(args);
    return status;
}

fathom_status cli_fail_file(fathom_context *context, fathom_status status, const char *file,
                            const char *format, ...) {
    va_list args;
    va_start(args, format);
    store(context, status, file, format, args);
    va_end(args);
    return status;
}

fathom_status cli_fail_memory(fathom_context *context) {
    return cli_fail(context, FATHOM_OUT_OF_RESOURCES, "out of memory");
}

void cli_fail_within(fathom_context *context, const char *file) {
    if (!*fathom_context_error(context)->place->file)
        fathom_context_fail_within(context, &(fathom_place){.file = file});
}
