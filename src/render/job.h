/* The job: waves handed to threads, samples summed into pixels, progress and stopping. */
#ifndef RENDER_JOB_H
#define RENDER_JOB_H

#include "render/film.h"
#include "render/wave.h"

typedef struct job_result {
    ray_counts rays;
    uint64_t samples; /* that the film's pixels are the means of */
    double error;     /* the largest estimate of any wave; see adaptive.h. 0 when it was not estimated */
} job_result;

/* What is to be left of a time for what comes after rendering: asked once, on a thread of the job, when each
 * pixel has a sample and the film holds it. */
typedef struct job_reserve {
    double (*seconds)(void *user, const fathom_film *film, double left); /* left: of the time */
    void *user;
} job_reserve;

/* FATHOM_INTERRUPTED when progress said stop: waves that were finished are in the film, the rest is black.
 * deadline: of clock_seconds(), for settings with a time; FATHOM_BAD_USAGE when it comes before each pixel
 * has a sample. reserve: comes off it; may be NULL. */
fathom_status job_run(fathom_context *context, const render_plan *plan, double deadline,
                      const job_reserve *reserve, fathom_film *film, fathom_progress_fn progress, void *user,
                      job_result *out);

#endif
