/* Rays per second of several tracers over the same rays. */
#pragma once

#include "measure/statistics.h"
#include "measure/trace_sets.h"

#define TRACE_TIME_REPEATS_MAX 1000
#define TRACE_TIME_TRACERS_MAX 32

typedef struct trace_rate {
    uint64_t rays;        /* in each repetition: a slow tracer gets fewer, spread uniformly over the set */
    uint64_t met;         /* number of hits */
    quartiles per_second; /* wall-clock time, all threads together */
    quartiles per_cpu_second;
} trace_rate;

typedef struct trace_time_options {
    unsigned repeats; /* [1, TRACE_TIME_REPEATS_MAX] */
    unsigned threads;
    double seconds;           /* limit of processor time for one repetition of a tracer and a set */
    const bench_watch *watch; /* may be NULL */
} trace_time_options;

/* Tracers take turns; each repetition begins with a different tracer. out: for each tracer, a rate for each
 * set. */
fathom_status trace_time_measure(fathom_context *context, trace_tracer *const *tracers, size_t count,
                                 const trace_sets *sets, const trace_time_options *options,
                                 trace_rate (*out)[TRACE_SETS]);
