/* Structs of callers that may have been built against an older header, whose structs end sooner.
 *
 * A struct grows at its end, and past the size that it had: not within its padding, which older callers leave
 * unset. */
#ifndef BASE_SIZED_H
#define BASE_SIZED_H

#include "base/status.h"

/* Copies the caller's `size` bytes over `full`, which holds the defaults of all `known` bytes. `name` is the
 * argument's, for messages. FATHOM_BAD_USAGE: `from` is NULL, or the size is 0 or larger than `known`. */
fathom_status sized_read(fathom_context *context, const char *name, const void *from, size_t size, void *full,
                         size_t known);
/* The same for structs that begin with their size. `full` then has the size of this version. */
fathom_status sized_read_own(fathom_context *context, const char *name, const void *from, void *full,
                             size_t known);
/* True if sized_write() may write to `out`, which begins with its size. */
fathom_status sized_check(fathom_context *context, const char *name, const void *out, size_t known);
void sized_write(void *out, const void *full, size_t known);
/* For structs without a size of their own, and for defaults. */
void sized_give(void *out, size_t size, const void *full, size_t known);

/* Reads the argument `from` into *full, of the given type. */
#define SIZED_ITEM(context, type, from, size, full)                                                          \
    (type##_default(full), sized_read(context, #from, from, size, full, sizeof(type)))
#define SIZED_OWN(context, type, from, full)                                                                 \
    (type##_default(full), sized_read_own(context, #from, from, full, sizeof(type)))

/* Defines TYPE_default_sized(); SIZED_DEFAULT_OWN() is for structs that begin with their size. */
#define SIZED_DEFAULT(type, ...)                                                                             \
    void type##_default_sized(type *out, size_t size) {                                                      \
        const type value = __VA_ARGS__;                                                                      \
        sized_give(out, size, &value, sizeof value);                                                         \
    }
#define SIZED_DEFAULT_OWN(type, ...)                                                                         \
    void type##_default_sized(type *out, size_t bytes) {                                                     \
        type value = __VA_ARGS__;                                                                            \
        value.size = bytes;                                                                                  \
        sized_give(out, bytes, &value, sizeof value);                                                        \
    }

#endif
