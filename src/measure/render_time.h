/* The cost of rendering beyond tracing: the render phase against Embree's bare calls over the same rays. */
#ifndef BENCH_RENDER_TIME_H
#define BENCH_RENDER_TIME_H

#include "integrate/wave.h"
#include "measure/statistics.h"

#define RENDER_TIME_REPEATS_MAX 1000
#define RENDER_TIME_THREADS_MAX 8

/* Processor time of one thread. The ratios are of each repetition by itself. */
typedef struct render_ratio {
    quartiles render, traced, bare; /* seconds: the render phase; trace.h alone; Embree's calls alone */
    quartiles render_to_bare, traced_to_bare;
    uint64_t closest, any; /* rays that were asked again */
    unsigned bands;        /* parts of the image that were recorded one by one, to bound the memory */
} render_ratio;

/* The render phase by so many threads, film and waves included. */
typedef struct render_speed {
    unsigned threads;
    quartiles seconds, cpu_seconds; /* by the clock; of all threads together */
    quartiles speedup;              /* the first row's seconds over this one's, repetition by repetition */
} render_speed;

typedef struct render_time {
    quartiles plan_seconds;
    ray_counts rays;
    bool has_ratio; /* the tracer is Embree's, by packets or single rays */
    render_ratio ratio;
    render_speed speeds[RENDER_TIME_THREADS_MAX];
    unsigned speed_count;
} render_time;

typedef struct render_time_options {
    unsigned repeats; /* [1, RENDER_TIME_REPEATS_MAX] */
    unsigned threads[RENDER_TIME_THREADS_MAX], thread_counts;
    uint64_t record_bytes;    /* rays of one band take about as much at most */
    const bench_watch *watch; /* may be NULL */
} render_time_options;

/* Sets the context's threads. The settings' crop, if any, is what is rendered. */
fathom_status render_time_measure(fathom_context *context, const world *w, const trace_tracer *tracer,
                                  const fathom_settings *settings, const render_time_options *options,
                                  render_time *out);

#endif
