/* The context's message, and how functions fail. */
#ifndef BASE_STATUS_H
#define BASE_STATUS_H

#include <fathom/base.h>
#include <stdarg.h>
#include <sys/stat.h>

/* Stores the message and returns the status, so that a failure is one line: return fail(ctx,
 * FATHOM_BAD_INPUT, …); A message says where (file:line: or file: at byte N:), what was found, what was
 * expected. Without a context there is no place for it, as for whoever only asks whether. */
fathom_status fail(fathom_context *context, fathom_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Puts text in front of the message that a callee left ("scene.json:12: objects[3]: "), and hands the status
 * on. */
fathom_status fail_within(fathom_context *context, fathom_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

fathom_status fail_memory(fathom_context *context, size_t bytes);

/* As fathom_context_allow_outside() and fathom_context_copy_files() say. */
bool context_allows_outside(const fathom_context *context);
bool context_copies_files(const fathom_context *context);

/* Files that nothing may be read from, since they are to be written: file_open() refuses them. The array
 * stays the caller's; count 0: none any more. */
typedef struct file_identity {
    dev_t device;
    ino_t number;
} file_identity;
void context_set_outputs(fathom_context *context, const file_identity *files, size_t count);
bool context_is_output(const fathom_context *context, const struct stat *file);

/* FATHOM_BAD_USAGE: this argument of a public call is NULL and must not be. The context may be NULL too.
 */
fathom_status fail_null(fathom_context *context, const char *argument);

/* A warning for the user; see fathom_context_on_warning(). Only from the calling thread, once for each kind.
 */
void warn(fathom_context *context, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
