/* What the ways to run a job share. */
#ifndef RENDER_JOB_INNER_H
#define RENDER_JOB_INNER_H

#include "render/adaptive.h"
#include "render/job.h"

/* A wave is made by the thread that uses it, when it first does. */
typedef struct worker {
    wave wave;
    adaptive_wave *adaptive; /* NULL: every pixel gets the same samples, or waves keep their own */
    pixel_sums *sums;        /* otherwise */
    adaptive_limit limit;
    double kept; /* clock_seconds() when its wave was last saved, or began */
    bool ready;
    uint64_t samples; /* in the film */
    double error;     /* the largest of its waves */
} worker;

typedef struct job {
    const render_plan *plan;
    fathom_film *film;
    worker *workers;
    atomic_bool stop, failed;
    _Atomic uint64_t pixels_done, rays_done;
    job_result result;
    const job_options *options;
    double began;            /* of clock_seconds(), as the next; the calls that this one continues count */
    _Atomic double deadline; /* 0: none. What has to be reserved comes off it on the way */
    uint64_t rays_before;    /* of these calls */
    atomic_bool complete;    /* nothing is left to stop */
    bool interrupted;
    fathom_status files; /* of the scene: not FATHOM_OK once one was found changed, which ends the job */
    double next_look;    /* at them */
    double sampled;      /* part of the waves that have samples, when time ended before all had */
    unsigned threads;
} job;

/* The worker of this index, its wave ready to be used; NULL when the job stops. */
worker *job_worker(job *j, unsigned index);
/* After a pass or a wave, for progress. before: the wave's rays then. */
void job_count_rays(job *j, const wave *w, const ray_counts *before);
/* Ends the job after wave_run_batch() said false. */
void job_stop(job *j, const wave *w);

/* Rounds over all waves until the deadline. */
void timed_run(job *j);
/* Bytes that timed_run() takes. */
size_t timed_bytes(const job *j);

#endif
