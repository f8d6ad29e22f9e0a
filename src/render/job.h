/* The job: waves handed to threads, samples summed into pixels, progress and stopping. */
#ifndef RENDER_JOB_H
#define RENDER_JOB_H

#include "render/film.h"
#include "render/wave.h"

/* FATHOM_INTERRUPTED when progress said stop: waves that were finished are in the film, the rest is black.
 * rays: how many were traced. */
fathom_status job_run(fathom_context *context, const render_plan *plan, fathom_film *film,
                      fathom_progress_fn progress, void *user, ray_counts *rays);

#endif
