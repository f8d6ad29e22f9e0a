/* Renders with all options, on the calling thread or in the background. */
#ifndef FATHOM_SESSION_H
#define FATHOM_SESSION_H

#include <fathom/image.h>
#include <fathom/part.h>
#include <fathom/ranks.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Saves a render at intervals, so that a later call, in this process or another, can continue it. Everything
 * finished at the last save survives a crash of the process or the machine. The continued image has the same
 * bits, on any number of threads. Exception: with max_time the clock decides which samples are taken. The
 * rendering time of earlier calls counts towards max_time.
 *
 * The file appears whole or not at all, at `path`; while it is written there are two. It holds the finished
 * pixels of all channels. With target_error it also holds sums of the pixels in progress; with max_time that
 * is every pixel: about 200 bytes each, 1,400 with all AOVs. It is valid for the same render only: the same
 * scene (compared by content), size, crop, samples, AOVs, other settings that pixels depend on, tracer, and
 * version of Fathom. Rendering does not delete it; remove it once the image is safe. */
typedef struct fathom_checkpoint {
    size_t size;
    const char *path;
    double every; /* seconds from the end of one save to the beginning of the next, >= 0; default 60 */
    bool resume;  /* false (default): an existing file at `path` is an error. true: continues it; without a
                     file, warns and starts from the beginning */
    /* These may be NULL. They are called on the same thread as the session's progress. */
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

/* ---- sequences of images, such as the frames of an animation ---- */

/* Replaces the checkpoint of a finished render at `path` by a small record: of the render, the options by
 * which the film was written, and the contents of the files that it was written to.
 * Remove it once the sequence is finished. FATHOM_OUT_OF_RESOURCES: it cannot be written. */
FATHOM_API fathom_status fathom_finished_keep(fathom_context *context, const fathom_film *film,
                                              const char *path, const fathom_write_options *write,
                                              const char *const *files, size_t count);
/* *finished: there is such a record of this render, and the files, named in the same order, still have the
 * same contents. If files, the exposure or other options of writing have changed, the record is removed, and
 * *finished is false. An exposure of NaN matches any, and becomes that of the record. FATHOM_BAD_INPUT: the
 * record is damaged, or of another render: the message says what differs. Tracers are not compared. */
FATHOM_API fathom_status fathom_finished_find(fathom_context *context, const fathom_scene *scene,
                                              const fathom_settings *settings, const char *path,
                                              fathom_write_options *write, const char *const *files,
                                              size_t count, bool *finished);

/* The caller keeps everything that this points to until the session has ended. Every member may be NULL, 0 or
 * false. */
typedef struct fathom_session_options {
    size_t size;
    fathom_progress_fn progress; /* on the thread that renders: see fathom_render() */
    void *user;                  /* of progress */
    /* Saves on the way. FATHOM_BAD_USAGE as fathom_checkpoint_check(), and when another render saves to it;
     * FATHOM_BAD_INPUT: the file is damaged, is no checkpoint, or is of another render: the message says what
     * differs. All of this is found before anything is built, except a different tracer. */
    const fathom_checkpoint *checkpoint;
    /* Files that the film will be written to, with `write` (NULL: the defaults). max_time reserves the
     * time to write them. A render to files that need the image helper ends with FATHOM_OUT_OF_RESOURCES
     * as soon as that is known to be missing. */
    const char *const *outputs;
    size_t output_count;
    const fathom_write_options *write;
    /* If a file of the scene changes during the render, the status is FATHOM_BAD_INPUT. true: *out is then
     * the unfinished film, in which some pixels may be wrong. false (default): *out is NULL. */
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

/* Starts the same render on its own threads, and returns at once. Until fathom_session_finish() the session
 * owns the context, and the scene must not change; settings are copied. FATHOM_BAD_USAGE when a pointer is
 * NULL or a struct has no size; fathom_session_finish() reports all other errors. If no thread can be
 * created, the call renders before it returns. */
FATHOM_API fathom_status fathom_session_start(fathom_context *context, const fathom_scene *scene,
                                              const fathom_settings *settings,
                                              const fathom_session_options *options, fathom_session **out);

/* These four may be called from any thread. */

/* The same values that `progress` receives. */
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
 * "samples" (FATHOM_AOV_SAMPLES) show a preview, or black. Taking it holds the render up for as long as the
 * copy takes. It has no statistics. *out is NULL, with FATHOM_OK, while there is no film.
 * FATHOM_OUT_OF_RESOURCES. `context` gets the message, and must not be the session's. */
FATHOM_API fathom_status fathom_session_snapshot(fathom_context *context, fathom_session *session,
                                                 fathom_film **out);

/* Waits until it has ended, releases the session, and returns what fathom_session_run() would. stats and out
 * may be NULL. stats without a size are FATHOM_BAD_USAGE, and the session goes on. */
FATHOM_API fathom_status fathom_session_finish(fathom_session *session, fathom_stats *stats,
                                               fathom_film **out);

#ifdef __cplusplus
}
#endif
#endif
