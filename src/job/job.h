/* The job: distributes waves to threads, sums samples into pixels, reports progress, and stops. */
#pragma once

#include "film/sum_tree.h"
#include "job/checkpoint/checkpoint.h"

typedef struct job_result {
    ray_counts rays;
    uint64_t samples; /* samples in the film's pixels */
    double finished;  /* fraction of the work, or of the time */
    double error;     /* largest estimate of any wave (adaptive.h); 0: not estimated */
} job_result;
_Static_assert(offsetof(fathom_stats, faint_shadow_rays) - offsetof(fathom_stats, camera_rays) ==
                   offsetof(ray_counts, faint),
               "statistics have the counts of rays in the same order, from camera_rays on");

/* Time to reserve for the work after rendering. Called once, on a thread of the job, when each pixel has a
 * sample and the film holds it. */
typedef struct job_reserve {
    double (*seconds)(void *user, const fathom_film *film, double left); /* left: seconds that are left */
    void *user;
} job_reserve;

/* A unit that is done, as far as it is this process's work. */
typedef struct wave_result {
    work_unit unit;
    uint64_t samples;
    double error, seconds; /* seconds: processor time of one thread */
    ray_counts rays;
    const unsigned char *sums; /* for a share of all samples (film/sum_tree.h): square after square; NULL: the
                                  pixels are in the film */
    size_t bytes;
} wave_result;

/* The work of this process if it renders only a part of the image. All calls except tick() come from any
 * thread. */
typedef struct wave_share {
    void *user;
    bool sums; /* the result is sums of the samples in `range`: the film gets no pixels */
    sum_range range;
    uint64_t pixels;        /* in its waves, clipped to the film */
    checkpoint_past before; /* the work of earlier calls */
    bool (*wants)(void *user, uint32_t wave);
    /* Waits for the next unit to do. False: there is none, or *stop is set. NULL: all waves for which wants()
     * is true, tile by tile. */
    bool (*next)(void *user, const atomic_bool *stop, work_unit *unit);
    bool (*take)(void *user, const wave_result *result); /* false: failed, and the job ends */
    void (*tick)(void *user); /* called about ten times a second, on the calling thread; may be NULL */
    /* Units that other processes rendered into this process's film: their sums, valid once the job has ended,
     * and their pixels so far. */
    wave_result others;
    _Atomic uint64_t others_pixels;
} wave_share;

/* All may be 0. */
typedef struct job_options {
    double deadline;            /* a time of clock_seconds(), for settings with a time limit */
    const job_reserve *reserve; /* subtracted from the time */
    wave_share *share;          /* NULL: this process renders the whole image */
    checkpoint *saving;         /* begun; its finished pixels are in the film */
    bool live; /* others copy the film during the render: passes also store their samples so far */
    fathom_progress_fn progress;
    void *user;
} job_options;

/* FATHOM_INTERRUPTED: progress returned false. The film then holds the finished squares of 4 × 4 pixels; with
 * a target error, the finished waves of 32 × 32; with a time, all samples taken. The other pixels show the
 * preview (preview.h), or are black if there is no preview: with a time, a share or one sample a pixel, or if
 * the render stopped too early. FATHOM_BAD_INPUT: a file of the scene changed, which stops the job.
 * FATHOM_OUT_OF_RESOURCES without a message: the share could not take a wave. FATHOM_BAD_USAGE: the deadline
 * came before each pixel had a sample. */
fathom_status job_run(fathom_context *context, const render_plan *plan, const job_options *options,
                      fathom_film *film, job_result *out);

/* Runs work() on a separate thread, and returns when it has ended. Meanwhile calls tick() on the calling
 * thread about ten times a second, and once more at the end. If no thread can be created, the calling thread
 * does the work. */
void job_watch(void (*work)(void *user), void (*tick)(void *user), void *user);
