/* Internal rendering interface. */
#ifndef JOB_RENDER_H
#define JOB_RENDER_H

#include "job/job.h"
#include "scene/world/world.h"

#include <fathom/render.h>

/* fathom_render(), but the world's coordinates are counted from `origin` (see world_create_from()): to show
 * what would be lost if they were not counted from near the view. */
fathom_status render_from(fathom_context *context, const fathom_scene *scene, const fathom_settings *settings,
                          const vec3_f64 *origin, fathom_progress_fn progress, void *user, fathom_film **out);

/* fathom_render() of settings that may have a max_time, some of which is left for what follows (reserve, may
 * be NULL), saved on the way (saving, may be NULL). On FATHOM_BAD_INPUT too *out may be a film: as far as it
 * got before a file of the scene was found changed. */
fathom_status render_to_time(fathom_context *context, const fathom_scene *scene,
                             const fathom_settings *settings, const job_reserve *reserve,
                             const fathom_checkpoint *saving, fathom_progress_fn progress, void *user,
                             fathom_stats *stats, fathom_film **out);

/* fathom_render(), whose film others copy meanwhile (film_copy()). on_film: gets the film once it is there,
 * and NULL before it is released; called with progress's user. */
fathom_status render_watched(fathom_context *context, const fathom_scene *scene,
                             const fathom_settings *settings,
                             void (*on_film)(void *user, const fathom_film *film),
                             fathom_progress_fn progress, void *user, fathom_stats *stats, fathom_film **out);

#endif
