/* Rays to measure tracers with: what a renderer asks, and what a path tracer would. */
#ifndef BENCH_TRACE_RAYS_H
#define BENCH_TRACE_RAYS_H

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

#endif
