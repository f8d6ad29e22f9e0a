/* Status, messages and the context that every other call is given.
 *
 * Fathom never exits, prints or aborts: each call returns a status, and the context keeps one message
 * that names the file, the line and the field. Plain C99, and C++17. */
#ifndef FATHOM_BASE_H
#define FATHOM_BASE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define FATHOM_VERSION_MAJOR 0
#define FATHOM_VERSION_MINOR 1
#define FATHOM_VERSION_PATCH 0

#if defined(__GNUC__)
#define FATHOM_API __attribute__((visibility("default")))
#else
#define FATHOM_API
#endif

#ifdef __cplusplus
extern "C" {
#endif

/* What came of a call. The values are the command line's exit codes. */
typedef enum fathom_status {
    FATHOM_OK = 0,
    FATHOM_CHECK_FAILED = 1,     /* a validation or comparison found a difference */
    FATHOM_BAD_USAGE = 2,        /* arguments of the call are wrong */
    FATHOM_BAD_INPUT = 3,        /* a file or a scene is wrong */
    FATHOM_OUT_OF_RESOURCES = 4, /* memory or disk */
    FATHOM_INTERRUPTED = 5,      /* stopped by the caller; what was finished is kept */
    FATHOM_INTERNAL = 70         /* a fault of Fathom's own */
} fathom_status;

/* Owns the message, the warning callback and the thread count. Calls on different contexts may run at
 * the same time; one context serves one calling thread at a time. */
typedef struct fathom_context fathom_context;

/* Returns FATHOM_OUT_OF_RESOURCES when there is no memory. Release with fathom_context_destroy(). */
FATHOM_API fathom_status fathom_context_create(fathom_context **out);
FATHOM_API void fathom_context_destroy(fathom_context *context);

/* The message of the last call that did not return FATHOM_OK; "" when there was none. Never NULL; valid
 * until the next call on this context. */
FATHOM_API const char *fathom_context_message(const fathom_context *context);

/* Called for each thing that was rendered around (degenerate triangles, ignored textures…), on the
 * calling thread, once for each kind and file. Default: warnings are dropped. */
typedef void (*fathom_warning_fn)(void *user, const char *message);
FATHOM_API void fathom_context_on_warning(fathom_context *context, fathom_warning_fn fn, void *user);

/* Threads used by reading, building and rendering; 0 (the default) means one for each processor.
 * No result depends on it. */
FATHOM_API void fathom_context_set_threads(fathom_context *context, unsigned threads);
FATHOM_API unsigned fathom_context_threads(const fathom_context *context);

/* "0.1.0" */
FATHOM_API const char *fathom_version(void);

#ifdef __cplusplus
}
#endif
#endif
