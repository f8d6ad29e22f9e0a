/* Internals that the schedules of a job share. */
#pragma once

#include "film/sum_tree.h"
#include "job/adaptive.h"
#include "job/job.h"

/* State of one thread. `integration` is created when the thread first needs it. */
typedef struct worker {
    integration *integration;
    adaptive_wave *adaptive; /* NULL: every pixel gets the same number of samples, or waves keep their own */
    adaptive_view *view;     /* for adaptive waves */
    pixel_sums *sums;        /* for other waves, as is `nodes` */
    sum_node *nodes;         /* of the squares in progress; NULL: all samples are a single leaf */
    unsigned char *share;    /* the wave's sums, if the job is a share of all samples; otherwise NULL */
    size_t share_bytes;
    adaptive_limit limit;
    double kept;      /* clock_seconds() when its adaptive wave was last saved, or began */
    uint64_t samples; /* in the film */
    double error;     /* largest error of its waves */
    double wave_error;
} worker;

typedef struct job job;

/* How the work is divided into units, and the order of the units. */
typedef struct job_schedule {
    bool (*prepare)(const job *j, worker *self); /* allocates a worker's memory; false: out of memory */
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
    _Atomic double error_done; /* largest error of finished waves; set by the schedule to an error */
    job_result result;
    const job_options *options;
    double began;            /* by clock_seconds(), as is `deadline`; earlier calls move it back */
    _Atomic double deadline; /* 0: none. The time reserved for writing is already subtracted */
    uint64_t rays_before;    /* of earlier calls */
    atomic_bool complete;    /* all is rendered: stopping has no effect */
    bool interrupted;
    fathom_status files; /* status of the scene's files; a changed file or a broken image ends the job */
    double next_look;    /* when to check the files again */
    wave_grid grid;      /* of the film */
    double sampled;      /* fraction of the waves that have samples, if time ended before all had */
    unsigned threads;
    const job_schedule *schedule;
    unit_sink sinks[JOB_SINKS];
    unsigned sink_count;
};

/* The worker of this index, ready for work. NULL: the job stops. */
worker *job_worker(job *j, unsigned index);
/* Counts the rays of a pass or a wave, for progress. before: the counts at its beginning. */
void job_count_rays(job *j, const integration *work, const ray_counts *before);
/* Ends the job after the integrator's run() returned false. */
void job_stop(job *j, const integration *work);

/* Sends finished squares to all sinks. */
void job_deliver(job *j, worker *self, const unit_result *result);
/* Stores the samples of a wave so far in the film. */
void job_show(const job *j, worker *self, const adaptive_wave *a);
/* Renders these squares of a wave, none of which is finished; false: stopped, or out of memory. */
typedef bool (*render_wave_fn)(job *j, worker *self, const wave_region *region, uint64_t squares);
/* Renders tile by tile, and within each tile wave by wave. */
void job_run_tiles(job *j, render_wave_fn render);

/* Bytes that the schedule to a time needs. */
size_t timed_bytes(const job *j);
