/* A render with everything that can be asked of one: on the calling thread, or in the background. */
#ifndef FATHOM_SESSION_H
#define FATHOM_SESSION_H

#include <fathom/image.h>
#include <fathom/part.h>
#include <fathom/ranks.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Saving a render on the way, so that a later call, in this process or another, can continue it: what was
 * finished when the file was last saved survives whatever happens to process or machine, and the image comes
 * out the same to the last bit, on any number of threads. With max_time, seconds that the calls before spent
 * on rendering count, and what is sampled still follows the clock.
 *
 * The file appears whole or not at all, at `path`; while it is written there are two. It holds the finished
 * pixels of all channels, and with target_error or max_time up to 350 bytes for each pixel that is begun: of
 * all pixels, with max_time. It fits the render that it is of: the same scene, by the contents of its arrays,
 * size, crop, samples, AOVs and other settings that pixels depend on, tracer and version of Fathom. Rendering
 * leaves it where it is; remove it once the image is safe. */
typedef struct fathom_checkpoint {
    size_t size;
    const char *path;
    double every; /* seconds from the end of one save to the beginning of the next, >= 0; default 60 */
    bool resume;  /* default false: a file at `path` is an error. true: it is continued; where there is
                     none, that is warned of, and rendering begins from the beginning */
    /* These may be NULL. They are called where the session's progress is. */
    bool (*wanted)(void *user); /* about ten times a second: true saves now, whatever `every` says */
    /* After each save: status is FATHOM_OK, or FATHOM_OUT_OF_RESOURCES with a message, and rendering goes on.
     * fraction: of the render that it holds, [0,1]. */
    void (*saved)(void *user, fathom_status status, const char *message, double fraction);
    void *user;
} fathom_checkpoint;

FATHOM_DEFAULT(fathom_checkpoint)

/* Finds what can be wrong before the scene is read: FATHOM_BAD_USAGE when there is a file at `path` and
 * resume is false, FATHOM_OUT_OF_RESOURCES when it could not be written. */
FATHOM_API fathom_status fathom_checkpoint_check(fathom_context *context,
                                                 const fathom_checkpoint *checkpoint);

/* All that it points to stays the caller's, until the session has ended. All may be NULL, 0 or false. */
typedef struct fathom_session_options {
    size_t size;
    fathom_progress_fn progress; /* on the thread that renders: see fathom_render() */
    void *user;                  /* of progress */
    /* Saves on the way. FATHOM_BAD_USAGE as fathom_checkpoint_check(), and when another render saves to it;
     * FATHOM_BAD_INPUT: the file is damaged, is no checkpoint, or is of another render: the message says what
     * differs. All of that is found before anything is built, but for another tracer. */
    const fathom_checkpoint *checkpoint;
    /* Files that the film will be written to, with `write` (NULL: the defaults). The part of max_time that
     * writing them takes is kept. A render to files that need the image helper ends with
     * FATHOM_OUT_OF_RESOURCES as soon as that is known to be missing. */
    const char *const *outputs;
    size_t output_count;
    const fathom_write_options *write;
    /* With FATHOM_BAD_INPUT, because a file of the scene was changed meanwhile, there is a film, too, as far
     * as it got: some of its pixels may be wrong. Default false: there is none. */
    bool keep_changed;
    /* Renders this part alone. FATHOM_BAD_USAGE together with a checkpoint, when the render cannot be split
     * so, or when another render writes the file; FATHOM_BAD_INPUT: there is a file that is no part, or one
     * of another render: the message says what differs; FATHOM_OUT_OF_RESOURCES: it cannot be written. */
    const fathom_part *part;
    /* Renders together with other processes. The film of rank 0 is the image, and rank 0 alone saves it. The
     * others' films are of no use; they return once rank 0 has no more work for them. FATHOM_BAD_USAGE
     * together with a part or max_time; FATHOM_BAD_INPUT: a rank renders something else, and the message of
     * rank 0 says what differs. */
    const fathom_ranks *ranks;
} fathom_session_options;

FATHOM_DEFAULT(fathom_session_options)

/* Renders on the calling thread; fathom_render() is this with `progress` and `user` alone. options and stats
 * may be NULL. */
FATHOM_API fathom_status fathom_session_run(fathom_context *context, const fathom_scene *scene,
                                            const fathom_settings *settings,
                                            const fathom_session_options *options, fathom_stats *stats,
                                            fathom_film **out);

/* ---- in the background ---- */

typedef struct fathom_session fathom_session;

/* Starts the same on threads of its own, and returns. Until fathom_session_finish() the context belongs to
 * the session, and the scene must not change; settings are copied. FATHOM_BAD_USAGE when a pointer is NULL or
 * a struct has no size; all else that can be wrong is said by fathom_session_finish(). Where no thread can be
 * had, it renders before it returns. */
FATHOM_API fathom_status fathom_session_start(fathom_context *context, const fathom_scene *scene,
                                              const fathom_settings *settings,
                                              const fathom_session_options *options, fathom_session **out);

/* These four may be called from any thread. */

/* How far it is, as `progress` is told. */
FATHOM_API void fathom_session_progress_sized(fathom_session *session, fathom_progress *out, size_t size);
static inline void fathom_session_progress(fathom_session *session, fathom_progress *out) {
    fathom_session_progress_sized(session, out, sizeof *out);
}
/* Asks it to stop, and returns at once. */
FATHOM_API void fathom_session_stop(fathom_session *session);
/* Waits until it has ended, but no longer than `seconds` (negative: without limit). True when it has ended.
 */
FATHOM_API bool fathom_session_wait(fathom_session *session, double seconds);
/* A copy of the film as it is now, to be released with fathom_film_destroy(): pixels with 0 in the channel
 * "samples" show a preview, or black. Taking it holds the render up for as long as the copy takes. It has no
 * statistics. *out is NULL, with FATHOM_OK, while there is no film. FATHOM_OUT_OF_RESOURCES. `context` gets
 * the message, and must not be the session's. */
FATHOM_API fathom_status fathom_session_snapshot(fathom_context *context, fathom_session *session,
                                                 fathom_film **out);

/* Waits until it has ended, releases the session, and returns what fathom_session_run() would. stats may be
 * NULL; one without a size is FATHOM_BAD_USAGE, and the session goes on. */
FATHOM_API fathom_status fathom_session_finish(fathom_session *session, fathom_stats *stats,
                                               fathom_film **out);

#ifdef __cplusplus
}
#endif
#endif
