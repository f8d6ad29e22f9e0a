/* The context's error, and how functions fail. */
#ifndef BASE_STATUS_H
#define BASE_STATUS_H

#include <fathom/base.h>
#include <stdarg.h>
#include <sys/stat.h>

/* Each stores an error and returns the status: return fail(context, FATHOM_BAD_INPUT, …). The text says what
 * was found and expected, the place where; NULL in it means "". Without a context nothing is stored. */
fathom_status fail(fathom_context *context, fathom_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
fathom_status fail_at(fathom_context *context, fathom_status status, const fathom_place *place,
                      const char *format, ...) __attribute__((format(printf, 4, 5)));
#define fail_file(context, status, path, ...)                                                                \
    fail_at(context, status, &(const fathom_place){.file = path}, __VA_ARGS__)
#define fail_field(context, status, name, ...)                                                               \
    fail_at(context, status, &(const fathom_place){.field = name}, __VA_ARGS__)
/* The field is an item of an array: "rays[17]". */
fathom_status fail_item(fathom_context *context, fathom_status status, const char *array, size_t index,
                        const char *format, ...) __attribute__((format(printf, 5, 6)));

/* Adds the place that a callee did not know and returns the status. An error that names a file keeps it and
 * is `within` this place. Any other moves here: its own field goes to the text if this place has a field. */
fathom_status fail_within(fathom_context *context, fathom_status status, const fathom_place *place);

fathom_status fail_memory(fathom_context *context, size_t bytes);

/* As fathom_context_allow_outside() and fathom_context_copy_files() say. */
bool context_allows_outside(const fathom_context *context);
bool context_copies_files(const fathom_context *context);

/* True if fathom_file_protect() was given it: file_open() refuses those. */
bool context_is_output(const fathom_context *context, const struct stat *file);

/* FATHOM_BAD_USAGE: this argument of a public call is NULL. The context may be NULL too. */
fathom_status fail_null(fathom_context *context, const char *argument);

/* A warning for the user (fathom_context_on_warning()), only from the calling thread. */
void warn(fathom_context *context, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
