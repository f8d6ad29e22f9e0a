/* Structs of callers that may be built against an older header, in which a struct has fewer members.
 *
 * New members go to the end of a struct, beyond its previous size. They must not use its tail padding,
 * because older callers leave that uninitialised. */
#pragma once

#include "base/status.h"

/* Copies the caller's `size` bytes to the start of `full`, which already holds the defaults of all `known`
 * bytes. `name` is the argument's name, for messages. FATHOM_BAD_USAGE: `from` is NULL, or the size is 0 or
 * larger than `known`. */
fathom_status sized_read(fathom_context *context, const char *name, const void *from, size_t size, void *full,
                         size_t known);
/* The same for structs whose first member is their size. In `full` that member becomes `known`. */
fathom_status sized_read_own(fathom_context *context, const char *name, const void *from, void *full,
                             size_t known);
/* FATHOM_OK if sized_write() may write to `out`, whose first member is its size; else FATHOM_BAD_USAGE. */
fathom_status sized_check(fathom_context *context, const char *name, const void *out, size_t known);
void sized_write(void *out, const void *full, size_t known);
/* The same for structs without a size member, and for defaults. Bytes beyond `known` become 0. `out` may be
 * NULL. */
void sized_give(void *out, size_t size, const void *full, size_t known);

/* Sets *full, of the given type, to the defaults and then to the argument `from`. */
#define SIZED_ITEM(context, type, from, size, full)                                                          \
    (type##_default(full), sized_read(context, #from, from, size, full, sizeof(type)))
#define SIZED_OWN(context, type, from, full)                                                                 \
    (type##_default(full), sized_read_own(context, #from, from, full, sizeof(type)))

/* Defines TYPE_default_sized(). SIZED_DEFAULT_OWN() is for structs whose first member is their size. */
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
