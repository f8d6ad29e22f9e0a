/* The cost of rendering in addition to tracing: the time of the render phase, compared with bare Embree calls
 * for the same rays. */
#pragma once

#include "integrate/wave/wave.h"
#include "measure/statistics.h"

#define RENDER_TIME_REPEATS_MAX 1000
#define RENDER_TIME_THREADS_MAX 8

/* Processor time of one thread. Each ratio is between values of the same repetition. */
typedef struct render_ratio {
    quartiles render, traced, bare; /* seconds: the render phase; calls of trace.h only; Embree calls only */
    quartiles render_to_bare, traced_to_bare;
    uint64_t closest, any; /* number of rays that were traced again */
    unsigned bands;        /* parts of the image that are recorded separately, to limit memory */
} render_ratio;

/* The render phase with this number of threads, including film and waves. */
typedef struct render_speed {
    unsigned threads;
    quartiles seconds, cpu_seconds; /* wall-clock time; processor time of all threads together */
    quartiles speedup; /* seconds of the first row divided by those of this row, per repetition */
} render_speed;

typedef struct render_time {
    quartiles plan_seconds;
    ray_counts rays;
    bool has_ratio; /* embree_bare_possible() */
    render_ratio ratio;
    render_speed speeds[RENDER_TIME_THREADS_MAX];
    unsigned speed_count;
} render_time;

typedef struct render_time_options {
    unsigned repeats; /* [1, RENDER_TIME_REPEATS_MAX] */
    double seconds;   /* for phases.h */
    unsigned threads[RENDER_TIME_THREADS_MAX], thread_counts;
    uint64_t record_bytes;    /* limit for the rays of one band (approximate) */
    const bench_watch *watch; /* may be NULL */
} render_time_options;

/* Changes the number of threads of the context. Renders the settings' crop, if there is one. */
fathom_status render_time_measure(fathom_context *context, const world *w, const trace_tracer *tracer,
                                  const fathom_settings *settings, const render_time_options *options,
                                  render_time *out);
