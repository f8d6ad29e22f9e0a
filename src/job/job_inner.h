/* Shared by the schedules of a job. */
#ifndef JOB_JOB_INNER_H
#define JOB_JOB_INNER_H

#include "film/sum_tree.h"
#include "job/adaptive.h"
#include "job/job.h"

/* A thread's integration is made when the thread first needs it. */
typedef struct worker {
    integration *integration;
    adaptive_wave *adaptive; /* NULL: every pixel gets the same samples, or waves keep their own */
    adaptive_view *view;     /* of adaptive waves */
    pixel_sums *sums;        /* of other waves, as the next */
    sum_node *nodes;         /* of the squares under way; NULL: a single leaf of samples */
    unsigned char *share;    /* the wave's sums, where the job is a share of all samples; else NULL */
    size_t share_bytes;
    adaptive_limit limit;
    double kept;      /* clock_seconds() when its adaptive wave was last saved, or began */
    uint64_t samples; /* in the film */
    double error;     /* the largest of its waves */
    double wave_error;
} worker;

typedef struct job job;

/* How the work is cut into units, and in which order these are done. */
typedef struct job_schedule {
    bool (*prepare)(const job *j, worker *self); /* a worker's memory; false: there is none */
    void (*run)(job *j);
} job_schedule;

extern const job_schedule schedule_even, schedule_to_error, schedule_to_time;

#define JOB_SINKS 2

struct job {
    const render_plan *plan;
    fathom_film *film;
    worker *workers;
    atomic_bool stop, failed;
    atomic_bool lost; /* the share could not take a wave */
    _Atomic uint64_t pixels_done, rays_done;
    _Atomic double error_done; /* the largest of finished waves, by the schedule to an error */
    job_result result;
    const job_options *options;
    double began;            /* of clock_seconds(), as the next; the calls that this one continues count */
    _Atomic double deadline; /* 0: none. Time reserved for writing is taken off it */
    uint64_t rays_before;    /* of these calls */
    atomic_bool complete;    /* nothing is left to stop */
    bool interrupted;
    fathom_status files; /* of the scene: not FATHOM_OK once one was found changed, which ends the job */
    double next_look;    /* at them */
    wave_grid grid;      /* of the film */
    double sampled;      /* part of the waves that have samples, when time ended before all had */
    unsigned threads;
    const job_schedule *schedule;
    unit_sink sinks[JOB_SINKS];
    unsigned sink_count;
};

/* The worker of this index, ready for work; NULL when the job stops. */
worker *job_worker(job *j, unsigned index);
/* After a pass or a wave, for progress. before: its rays then. */
void job_count_rays(job *j, const integration *work, const ray_counts *before);
/* Ends the job after the integrator's run() returned false. */
void job_stop(job *j, const integration *work);

/* Squares that are done go to all sinks. */
void job_deliver(job *j, worker *self, const unit_result *result);
/* Shows in the film what a wave has sampled so far. */
void job_show(const job *j, worker *self, const adaptive_wave *a);
/* Renders these squares of a wave, none of which is finished; false: stopped, or out of memory. */
typedef bool (*render_wave_fn)(job *j, worker *self, const wave_region *region, uint64_t squares);
/* Tile by tile, and in each wave by wave. */
void job_run_tiles(job *j, render_wave_fn render);

/* Bytes that the schedule to a time takes. */
size_t timed_bytes(const job *j);

#endif
