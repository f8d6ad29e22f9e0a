/* Status, messages, and the context that every other call takes.
 *
 * Fathom never exits, prints or aborts: each call returns a status, and the context keeps one error: what
 * went wrong, in which file, line and field. Plain C99, and C++17.
 *
 * NULL. No pointer may be NULL unless the comment on its call says so. Two exceptions hold everywhere:
 * `destroy` calls take NULL, and calls that add something to a scene take a NULL `out` if you do not need
 * the id. Any other NULL makes the call do nothing: it returns FATHOM_BAD_USAGE, with a message if there
 * is a context to keep it; calls without a status return 0, NULL, "" or the defaults. The library cannot
 * detect destroyed handles: using one is undefined behaviour.
 *
 * Order. A context must outlive the scenes and tracers made with it, and a scene its tracers; films depend on
 * neither. `destroy` calls need only their own handle, and may come in any order. Incomplete inputs, such as
 * a scene without objects, are refused with a status.
 *
 * Threads. Calls on different contexts may run at the same time; each gives the same bits as alone. One
 * context serves one calling thread at a time. A call on a scene is also a call on the scene's own
 * context. While no such call runs, any number of threads may pass the same scene to fathom_render() and
 * fathom_tracer_create(), each with its own context: these two only read the scene. Any number of threads
 * may trace rays with the same tracer and read the same film. A callback (warning, progress) must not make
 * calls on its own context, except fathom_context_error(), fathom_context_message() and
 * fathom_context_threads().
 *
 * Structs. They may grow in later versions, at their end; a program that was built against an older header
 * continues to work. There are three kinds.
 * - Settings, options and results begin with their own `size`. Their `_default` call sets it, or write
 *   `fathom_stats stats = {.size = sizeof stats};`. A size of 0, or beyond what this version knows, is
 *   FATHOM_BAD_USAGE. Members past the size have their defaults, and are not written to.
 * - Parts of a scene (scene.h) have no size, because there may be millions: each call that takes one is an
 *   inline function that passes sizeof to a call whose name ends in `_sized`, under the same rules. Bindings
 *   for other languages call that one.
 * - Structs that the library allocates and returns by pointer have no size either. Rays, hits and the items
 *   of returned arrays keep their layout in all versions.
 *
 * Stack. 64 KiB are enough for the calling thread, unless plug-ins and callbacks take more.
 *
 * Processes. A child of fork() may create contexts of its own and use them. It may only read objects that
 * its parent created. dlclose() leaves the library in memory, because its threads wait there. */
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

/* Declares NAME_default(out), which fills a struct with its defaults, its size among them if it has one. */
#define FATHOM_DEFAULT(name)                                                                                 \
    FATHOM_API void name##_default_sized(name *out, size_t size);                                            \
    static inline void name##_default(name *out) { name##_default_sized(out, sizeof *out); }

/* The result of a call. The values are the command line's exit codes. */
typedef enum fathom_status {
    FATHOM_OK = 0,
    FATHOM_CHECK_FAILED = 1,     /* a validation or comparison found a difference */
    FATHOM_BAD_USAGE = 2,        /* arguments of the call are wrong */
    FATHOM_BAD_INPUT = 3,        /* a file or a scene is wrong */
    FATHOM_OUT_OF_RESOURCES = 4, /* memory or disk */
    FATHOM_INTERRUPTED = 5,      /* stopped by the caller; what was finished is kept */
    FATHOM_INTERNAL = 70         /* a fault of Fathom's own */
} fathom_status;

/* Owns the error, the warning callback and the thread count. Calls on different contexts may run at
 * the same time; one context serves one calling thread at a time. */
typedef struct fathom_context fathom_context;

/* Returns FATHOM_OUT_OF_RESOURCES when there is no memory. Release with fathom_context_destroy(). */
FATHOM_API fathom_status fathom_context_create(fathom_context **out);
FATHOM_API void fathom_context_destroy(fathom_context *context);

/* Where an error is. Strings are never NULL; "" means not known, or that there is none. Later versions may
 * add members at the end. */
typedef struct fathom_place {
    const char *file; /* the path as it was given, byte for byte; show it with care */
    size_t line;      /* from 1; 0: not known, as in files of bytes */
    size_t column;    /* from 1; 0: not known */
    bool has_byte;    /* whether `byte` is known */
    size_t byte;      /* from the beginning of the file */
    const char
        *field; /* "objects[3].radius", "radius", a statement or a property; without control characters */
    const struct fathom_place *within; /* what refers to this file, such as an object of a scene; or NULL */
} fathom_place;

typedef struct fathom_error {
    fathom_status status;      /* FATHOM_OK: no call has failed yet */
    const fathom_place *place; /* never NULL */
    const char *text;          /* what was found and expected, without the place and control characters */
} fathom_error;

/* The error of the last call that did not return FATHOM_OK. Calls that return FATHOM_OK leave it as it was.
 * Never NULL, even when context is; valid until the next call on this context. */
FATHOM_API const fathom_error *fathom_context_error(const fathom_context *context);

/* The same error as one line, "FILE:LINE: FIELD: text", without control characters; "" when there was
 * none, or context is NULL. Never NULL; valid until the next call on this context. Errors and warnings name
 * what the caller can set as the program's option: --allow-outside is fathom_context_allow_outside(), and
 * --up the member `up` of fathom_read_options. */
FATHOM_API const char *fathom_context_message(const fathom_context *context);

/* Sets the context's error as a failing call does, and returns error->status. It is for code that adds its
 * own calls, such as readers of other formats. Strings are copied; they must not belong to the context's
 * present error. A NULL string counts as "", a NULL place as unknown. */
FATHOM_API fathom_status fathom_context_fail(fathom_context *context, const fathom_error *error);
/* Adds a place that the failing call did not know to the context's error, and returns its status. If the
 * error names a file, this place becomes its `within`; otherwise it becomes the error's own place. */
FATHOM_API fathom_status fathom_context_fail_within(fathom_context *context, const fathom_place *place);

/* Called for each problem that does not stop the call (degenerate triangles, ignored textures…), on the
 * calling thread, once per kind and file. Default, and with fn NULL: warnings are dropped; user may be
 * NULL. */
typedef void (*fathom_warning_fn)(void *user, const char *message);
FATHOM_API void fathom_context_on_warning(fathom_context *context, fathom_warning_fn fn, void *user);

/* Threads used by reading, building and rendering, at most 1024; 0 (the default) means one for each
 * processor. No result depends on it. */
FATHOM_API void fathom_context_set_threads(fathom_context *context, unsigned threads);
FATHOM_API unsigned fathom_context_threads(const fathom_context *context);

/* Sets whether files that a scene names, directly or through other files (meshes, buffers, material
 * libraries), may lie outside its folder. Default false: absolute paths, and relative ones or symbolic
 * links that lead out of the folder of the file given to fathom_scene_read(), are FATHOM_BAD_INPUT.
 * Symbolic links are followed before the check. Hard links and mounts are not detected. */
FATHOM_API void fathom_context_allow_outside(fathom_context *context, bool allow);

/* Sets whether files are copied to memory rather than mapped. Default false: mesh files stay
 * memory-mapped for the life of the scene. If another process truncates a mapped file, SIGBUS ends this one,
 * unless fathom_guard_files() was called. If it overwrites the file, behaviour is undefined. Copies take
 * memory; later changes to the file then have no effect. */
FATHOM_API void fathom_context_copy_files(fathom_context *context, bool copy);

/* Installs a handler for SIGBUS, once in the process. If a mapped file is truncated, reading the missing
 * part then gives zeros, on any thread, and the call that notices returns FATHOM_BAD_INPUT (see
 * fathom_scene_check_files()). All other SIGBUS go to the previous handler. The library never calls this
 * by itself; the program `fathom` does. */
FATHOM_API void fathom_guard_files(void);

/* How the library was built, and which parts of this machine it uses. */
typedef struct fathom_build {
    size_t size;
    const char *version;   /* as fathom_version() */
    const char *commit;    /* as fathom_commit() */
    const char *compiler;  /* "gcc 12.2.0" */
    const char *isa;       /* of the library's own loops: "portable", "AVX2" or "AVX-512" */
    const char *libraries; /* "libpng 1.6.39, zlib 1.2.13, jansson 2.14" */
    char embree[64];       /* with the instruction set that it takes: "Embree 3.13.5, AVX2" */
    unsigned processors;   /* that this process may run on */
} fathom_build;

/* FATHOM_BAD_USAGE: `out` is NULL or has no size. The strings are the library's. */
FATHOM_API fathom_status fathom_build_info(fathom_build *out);

/* "0.1.0" */
FATHOM_API const char *fathom_version(void);
/* The commit of the source, with a "+" if files had been changed since; "" if not known. */
FATHOM_API const char *fathom_commit(void);

#ifdef __cplusplus
}
#endif
#endif
