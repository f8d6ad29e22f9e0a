/* Internal rendering interface. */
#ifndef JOB_RENDER_H
#define JOB_RENDER_H

#include "job/job.h"
#include "scene/world/world.h"

#include <fathom/session.h>

/* How to render. All may be 0. */
typedef struct render_request {
    fathom_progress_fn progress;
    /* Gets the film once it is there, and NULL before it is released. Others may copy it meanwhile
     * (film_copy()). */
    void (*on_film)(void *user, const fathom_film *film);
    void *user;                      /* of both */
    const vec3_f64 *origin;          /* where the world's coordinates are counted from: see
                                        world_create_from(), to show what is lost elsewhere than near the view */
    const job_reserve *reserve;      /* the part of max_time that is kept for the work after rendering */
    const fathom_checkpoint *saving; /* complete */
    const fathom_part *part;         /* likewise; not with `saving` */
    const fathom_ranks *ranks;       /* likewise; not with `part` */
    bool keep_changed;               /* as fathom_session_options says */
} render_request;

/* Does the work of fathom_session_run(), with complete settings. stats may be NULL. */
fathom_status render_film(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          const render_request *request, fathom_stats *stats, fathom_film **out);

#endif
