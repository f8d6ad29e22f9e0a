/* Rays to measure tracers with: four kinds that renderers and path tracers trace. */
#pragma once

#include "trace/trace.h"

typedef enum trace_set_kind {
    TRACE_SET_CAMERA,  /* closest, coherent: packets are squares of 4 × 4 pixels */
    TRACE_SET_BOUNCE,  /* closest, incoherent: from visible points in any direction */
    TRACE_SET_SHADOW,  /* any, coherent: from visible points to the first light, in the same packets */
    TRACE_SET_BETWEEN, /* any, incoherent: between any two visible points */
    TRACE_SETS
} trace_set_kind;

typedef struct trace_set {
    const char *name;
    bool any; /* any hit; otherwise closest hit */
    trace_coherence coherence;
    trace_rays *blocks; /* all lanes are used */
    size_t count;
} trace_set;

typedef struct trace_sets {
    trace_set items[TRACE_SETS];
} trace_sets;

/* About `rays` rays through the scene's camera; each other set has about one ray per hit of these. `tracer`
 * finds the hits. FATHOM_BAD_INPUT if no camera ray hits anything. Release with trace_sets_free(), whatever
 * the status. */
fathom_status trace_sets_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                                uint64_t rays, trace_sets *out);
void trace_sets_free(trace_sets *sets);
