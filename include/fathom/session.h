/* Rendering in the background: start, look, stop, finish. */
#ifndef FATHOM_SESSION_H
#define FATHOM_SESSION_H

#include <fathom/render.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct fathom_session fathom_session;

/* Starts what fathom_render() does on threads of its own, and returns. Until fathom_session_finish() the
 * context belongs to the session, and the scene must not change; settings are copied. FATHOM_BAD_USAGE when a
 * pointer is NULL; all else that can be wrong is said by fathom_session_finish(). Where no thread can be had,
 * it renders before it returns. */
FATHOM_API fathom_status fathom_session_start(fathom_context *context, const fathom_scene *scene,
                                              const fathom_settings *settings, fathom_session **out);

/* These four may be called from any thread. */

/* How far it is, as fathom_render() tells its progress function. */
FATHOM_API void fathom_session_progress(fathom_session *session, fathom_progress *out);
/* Asks it to stop, and returns at once. */
FATHOM_API void fathom_session_stop(fathom_session *session);
/* Waits until it has ended, but no longer than `seconds` (negative: however long it takes). Whether it has.
 */
FATHOM_API bool fathom_session_wait(fathom_session *session, double seconds);
/* A copy of the film as it is now, to be released with fathom_film_destroy(): pixels with 0 in the channel
 * "samples" show a preview, or black. Taking it holds the render up for as long as the copy takes. It has no
 * statistics. *out is NULL, with FATHOM_OK, while there is no film. FATHOM_OUT_OF_RESOURCES. `context` gets
 * the message, and must not be the session's. */
FATHOM_API fathom_status fathom_session_snapshot(fathom_context *context, fathom_session *session,
                                                 fathom_film **out);

/* Waits until it has ended, releases the session, and returns what fathom_render() would. stats may be NULL.
 */
FATHOM_API fathom_status fathom_session_finish(fathom_session *session, fathom_stats *stats,
                                               fathom_film **out);

#ifdef __cplusplus
}
#endif
#endif
