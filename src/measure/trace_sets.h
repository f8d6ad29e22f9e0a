/* Rays to measure tracers with: four kinds, as renderers and path tracers ask them. */
#ifndef BENCH_TRACE_SETS_H
#define BENCH_TRACE_SETS_H

#include "trace/trace.h"

typedef enum trace_set_kind {
    TRACE_SET_CAMERA,  /* closest, coherent: packets are squares of 4 × 4 pixels */
    TRACE_SET_BOUNCE,  /* closest, incoherent: from visible points in any direction */
    TRACE_SET_SHADOW,  /* any, coherent: from visible points to the first light, packets kept */
    TRACE_SET_BETWEEN, /* any, incoherent: between any two visible points */
    TRACE_SETS
} trace_set_kind;

typedef struct trace_set {
    const char *name;
    bool any; /* any hit; else closest hit */
    trace_coherence coherence;
    trace_rays *blocks; /* all are full */
    size_t count;
} trace_set;

typedef struct trace_sets {
    trace_set items[TRACE_SETS];
} trace_sets;

/* About `rays` camera rays through the scene's own camera, and as many of the others as there are hits;
 * `tracer` finds those. FATHOM_BAD_INPUT when the camera sees nothing. Release with trace_sets_free()
 * whatever comes back. */
fathom_status trace_sets_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                                uint64_t rays, trace_sets *out);
void trace_sets_free(trace_sets *sets);

#endif
