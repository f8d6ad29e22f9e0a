/* Rays to measure tracers with, as a renderer and a path tracer ask them, and rays a second of several
 * tracers over the same rays. */
#ifndef BENCH_TRACE_TIME_H
#define BENCH_TRACE_TIME_H

#include "measure/statistics.h"
#include "trace/embree/embree_bare.h"

typedef enum trace_set_kind {
    TRACE_SET_CAMERA,  /* closest, coherent: packets are squares of 4 × 4 pixels */
    TRACE_SET_BOUNCE,  /* closest, incoherent: from what the camera sees in any direction */
    TRACE_SET_SHADOW,  /* any, coherent: from what the camera sees to the first light, packets kept */
    TRACE_SET_BETWEEN, /* any, incoherent: between any two points that the camera sees */
    TRACE_SETS
} trace_set_kind;

/* "camera" … */
const char *trace_set_name(trace_set_kind kind);
bare_query trace_set_query(trace_set_kind kind);
trace_coherence trace_set_coherence(trace_set_kind kind);

/* Full blocks. */
typedef struct trace_set {
    trace_rays *blocks;
    size_t count;
} trace_set;

/* About `rays` camera rays through the scene's own camera, and as many of the others as there are hits;
 * `tracer` finds those. FATHOM_BAD_INPUT when the camera sees nothing. Release with trace_sets_free()
 * whatever comes back. */
fathom_status trace_sets_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                                uint64_t rays, trace_set out[TRACE_SETS]);
void trace_sets_free(trace_set sets[TRACE_SETS]);

/* ---- rays a second ---- */

#define TRACE_TIME_REPEATS_MAX 1000
#define TRACE_TIME_TRACERS_MAX 32

typedef struct trace_rate {
    uint64_t rays; /* in each repetition: a slow tracer gets fewer, evenly out of the set */
    uint64_t met;  /* of them */
    quartiles per_second,
        per_cpu_second; /* by the clock, of all threads together; by one thread's processor time */
} trace_rate;

typedef struct trace_time_options {
    unsigned repeats; /* [1, TRACE_TIME_REPEATS_MAX] */
    unsigned threads;
    double seconds;           /* of processor time that one repetition of a tracer and a set may take */
    const bench_watch *watch; /* may be NULL */
} trace_time_options;

/* Tracers take turns, each repetition beginning with another one. out: for each tracer, for each set. */
fathom_status trace_time_measure(fathom_context *context, const trace_tracer *const *tracers, size_t count,
                                 const trace_set sets[TRACE_SETS], const trace_time_options *options,
                                 trace_rate (*out)[TRACE_SETS]);

#endif
