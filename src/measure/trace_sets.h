/* Rays to measure tracers with: four kinds as renderers and path tracers ask them, or those of a render. */
#ifndef BENCH_TRACE_SETS_H
#define BENCH_TRACE_SETS_H

#include "integrate/plan.h"
#include "trace/embree/embree_bare.h"

/* Full blocks. */
typedef struct trace_set {
    char name[16]; /* "camera", "2 mirrored" */
    bare_query query;
    trace_coherence coherence;
    trace_rays *blocks;
    size_t count;
} trace_set;

#define TRACE_SETS_MAX 36

typedef struct trace_sets {
    trace_set items[TRACE_SETS_MAX];
    size_t count;
} trace_sets;

/* The sets of trace_sets_create(). */
typedef enum trace_set_kind {
    TRACE_SET_CAMERA,  /* closest, coherent: packets are squares of 4 × 4 pixels */
    TRACE_SET_BOUNCE,  /* closest, incoherent: from visible points in any direction */
    TRACE_SET_SHADOW,  /* any, coherent: from visible points to the first light, packets kept */
    TRACE_SET_BETWEEN, /* any, incoherent: between any two visible points */
    TRACE_SETS
} trace_set_kind;

/* About `rays` camera rays through the scene's own camera, and as many of the others as there are hits;
 * `tracer` finds those. FATHOM_BAD_INPUT when the camera sees nothing. Release with trace_sets_free()
 * whatever comes back. */
fathom_status trace_sets_create(fathom_context *context, const world *w, const trace_tracer *tracer,
                                uint64_t rays, trace_sets *out);

/* The rays of a render by depth and kind: "0 camera", "0 shadow", "1 mirrored", "1 refracted" and so on, up
 * to eight bounces. Up to `rays` of each, from the first samples of waves all over the image; fewer than 16
 * of a kind are left out. Release as above. */
fathom_status trace_sets_record(fathom_context *context, const render_plan *plan, uint64_t rays,
                                trace_sets *out);

void trace_sets_free(trace_sets *sets);

#endif
