/* Internal rendering interface. */
#pragma once

#include "job/job.h"
#include "scene/world/world.h"

#include <fathom/session.h>

/* How to render. All may be 0. */
typedef struct render_request {
    fathom_progress_fn progress;
    /* Receives the film once it exists, and NULL before it is released. Other threads may copy it in between
     * (film_copy()). */
    void (*on_film)(void *user, const fathom_film *film);
    void *user;                      /* of both callbacks */
    const job_reserve *reserve;      /* part of max_time that is reserved for the work after rendering */
    const fathom_checkpoint *saving; /* complete */
    const fathom_part *part;         /* complete; not with `saving` */
    const fathom_ranks *ranks;       /* complete; not with `part` */
    bool keep_changed;               /* see fathom_session_options */
} render_request;

/* Implements fathom_session_run(), with complete settings. stats may be NULL. */
fathom_status render_film(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          const render_request *request, fathom_stats *stats, fathom_film **out);

/* scene_fingerprint(), and the files that OpenColorIO reads for the scene's textures. */
fathom_status render_fingerprint(const fathom_scene *scene, uint64_t *out);
