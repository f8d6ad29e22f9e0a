/* The job: waves handed to threads, samples summed into pixels, progress and stopping. */
#ifndef JOB_JOB_H
#define JOB_JOB_H

#include "film/sum_tree.h"
#include "job/checkpoint/checkpoint.h"

typedef struct job_result {
    ray_counts rays;
    uint64_t samples; /* that the film's pixels are the means of */
    double finished;  /* share of the work, or of the time */
    double error;     /* the largest estimate of any wave; see adaptive.h. 0 when it was not estimated */
} job_result;

/* The part of a time to keep for the work after rendering: asked once, on a thread of the job, when each
 * pixel has a sample and the film holds it. */
typedef struct job_reserve {
    double (*seconds)(void *user, const fathom_film *film, double left); /* left: of the time */
    void *user;
} job_reserve;

/* A unit that is done as far as this process does it. */
typedef struct wave_result {
    work_unit unit;
    uint64_t samples;
    double error, seconds; /* the second: of one thread's processor time */
    ray_counts rays;
    const unsigned char *sums; /* of a share of all samples (film/sum_tree.h), square after square; NULL: the
                                  film has its pixels */
    size_t bytes;
} wave_result;

/* The work of this process, where it is a part of the image. All calls but tick() come from any thread. */
typedef struct wave_share {
    void *user;
    bool sums; /* of the samples in `range`: the film gets no pixels */
    sum_range range;
    uint64_t pixels;        /* of its waves that the film shows */
    checkpoint_past before; /* what earlier calls did of it */
    bool (*wants)(void *user, uint32_t wave);
    /* Waits for the next unit to do; false: there is none, or *stop. NULL: all waves that it wants, tile by
     * tile. */
    bool (*next)(void *user, const atomic_bool *stop, work_unit *unit);
    bool (*take)(void *user, const wave_result *result); /* false: it cannot, and the job ends */
    void (*tick)(void *user); /* NULL, or: about ten times a second, on the calling thread */
    /* Units that other processes rendered into this one's film: the sums, until the job has ended, and their
     * pixels. */
    wave_result others;
    _Atomic uint64_t others_pixels;
} wave_share;

/* All may be 0. */
typedef struct job_options {
    double deadline;            /* of clock_seconds(), for settings with a time */
    const job_reserve *reserve; /* comes off it */
    wave_share *share;          /* NULL: the whole image is this process's */
    checkpoint *saving;         /* begun; the film holds what it has finished */
    bool live;                  /* others look at the film: it gets what passes have sampled, too */
    fathom_progress_fn progress;
    void *user;
} job_options;

/* FATHOM_INTERRUPTED: progress said stop. The film holds the squares of 4 × 4 pixels that were finished; with
 * a target error, the waves of 32 × 32. The other pixels show the preview (preview.h); with a target error,
 * and where there was no time for a preview, they are black. FATHOM_BAD_INPUT: a file of the scene was
 * changed, which stops the job. FATHOM_OUT_OF_RESOURCES without a message: the share could not take a wave.
 * FATHOM_BAD_USAGE: the deadline came before each pixel had a sample. */
fathom_status job_run(fathom_context *context, const render_plan *plan, const job_options *options,
                      fathom_film *film, job_result *out);

#endif
