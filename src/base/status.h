/* The context's error, and how functions fail. */
#pragma once

#include <fathom/base.h>
#include <stdarg.h>
#include <sys/stat.h>

/* Each of these stores an error in the context and returns the status: return fail(context, FATHOM_BAD_INPUT,
 * …). The text says what was found and what was expected; the place says where. NULL strings in a place mean
 * "". If the context is NULL, nothing is stored. */
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

/* Adds a place that the callee did not know to the context's error, and returns the status. If the error
 * names a file, it keeps its place, which is then `within` this one. Otherwise this place replaces it; if
 * both have a field, the error's own field goes to the text. */
fathom_status fail_within(fathom_context *context, fathom_status status, const fathom_place *place);

fathom_status fail_memory(fathom_context *context, size_t bytes);

/* The values set by fathom_context_allow_outside() and fathom_context_copy_files(). */
bool context_allows_outside(const fathom_context *context);
bool context_copies_files(const fathom_context *context);

/* True if the file was given to fathom_file_protect(). file_open() refuses such files. */
bool context_is_output(const fathom_context *context, const struct stat *file);

/* FATHOM_BAD_USAGE: this argument of a public call is NULL. The context may be NULL too. */
fathom_status fail_null(fathom_context *context, const char *argument);

/* Warns the user through fathom_context_on_warning(). Call it only on the thread that made the public
 * call. */
void warn(fathom_context *context, const char *format, ...) __attribute__((format(printf, 2, 3)));
