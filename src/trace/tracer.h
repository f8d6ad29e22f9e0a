/* What stands behind trace.h: a table of calls for each kind of tracer. A tracer's own struct begins with a
 * trace_tracer. */
#ifndef TRACE_TRACER_H
#define TRACE_TRACER_H

#include "trace/trace.h"

typedef struct trace_ops {
    /* Releases the tracer and all that it owns. */
    void (*destroy)(trace_tracer *tracer);
    /* As trace_closest() and trace_any(), but for the planes of the world, which trace.c adds afterwards. For
     * each of the first `count` lanes closest() sets the ids of the hit and t_far, or geometry = FATHOM_NONE
     * and leaves t_far. `fine` may be NULL, and stays as it is where `fine` below is false. */
    void (*closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence);
    void (*any)(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence);
    bool fine;   /* closest() sets `fine` */
    bool planes; /* closest() and any() see the planes too */
} trace_ops;

struct trace_tracer {
    const trace_ops *ops;
    const world *world;
    uint64_t bvh_bytes;
    double unit; /* roundoff */
    char name[64];
};

/* The kinds. Each sets all of the above on FATHOM_OK. */
fathom_status embree_create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out);
/* Robust and in float. */
fathom_status linear_create(fathom_context *context, const world *w, trace_tracer **out);
fathom_status linear_single_create(fathom_context *context, const world *w, const trace_spec *spec,
                                   trace_tracer **out);
fathom_status plugin_create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out);
fathom_status bvh_create(fathom_context *context, const world *w, const trace_spec *spec,
                         const trace_options *options, trace_tracer **out);

#endif
