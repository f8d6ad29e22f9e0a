/* The implementation side of trace.h: a table of calls for each kind of tracer. A tracer's own struct begins
 * with a trace_tracer. */
#ifndef TRACE_TRACER_H
#define TRACE_TRACER_H

#include "trace/trace.h"

/* A triangle that a line crosses, as a tracer's own arithmetic sees it. */
typedef struct trace_crossing {
    float t;
    uint32_t instance, geometry, primitive; /* the world's */
    bool entering;                          /* through the side that its corners go round counter-clockwise */
} trace_crossing;

typedef ARRAY(trace_crossing) trace_crossings;

typedef struct trace_ops {
    /* Releases the tracer and everything it owns. */
    void (*destroy)(trace_tracer *tracer);
    /* As trace_closest() and trace_any(); trace.c adds planes. closest() sets the ids of the hit and t_far,
     * or geometry = FATHOM_NONE. `fine` may be NULL, and is not set where `fine` below is false. */
    void (*closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence);
    void (*any)(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence);
    bool fine;   /* closest() sets `fine` */
    bool planes; /* closest() and any() see the planes too */
} trace_ops;

/* For watertight.c. */
typedef struct trace_retry {
    /* Looks again, slowly, for what the lane's ray meets by the reference intersector nearer than its t_far
     * (any: inside its interval). `round` counts up from 0. True if anything was found: then the lane is as
     * after closest() or any(). */
    bool (*closest)(const trace_tracer *tracer, trace_block *block, unsigned lane, unsigned round);
    bool (*any)(const trace_tracer *tracer, trace_rays *rays, unsigned lane, unsigned round);
    /* Adds all triangles of a group, and for group 0 of the instances, on the way from org along dir, each
     * once, in any order. False when out of memory. */
    bool (*crossings)(const trace_tracer *tracer, uint32_t group, vec3_f32 org, vec3_f32 dir,
                      trace_crossings *out);
    /* A box around the group; lower > upper where it is empty. */
    void (*bounds)(const trace_tracer *tracer, uint32_t group, vec3_f32 *lower, vec3_f32 *upper);
} trace_retry;

struct trace_tracer {
    const trace_ops *ops;
    const trace_retry *retry; /* NULL: no triangle that a ray meets is ever missed */
    const trace_tracer *self; /* what the calls of `retry` take: another where this one only passes rays on */
    const world *world;
    uint64_t bvh_bytes, peak_bytes, foreseen_bytes; /* see trace.h; 0: not known */
    double unit;                                    /* roundoff */
    bool slow;                                      /* a ray may take milliseconds */
    char name[64];
    char way[32]; /* what else answers depend on; "": only the name */
};

/* The kinds. Each sets all of the above on FATHOM_OK. */
fathom_status embree_create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out);
fathom_status linear_create(fathom_context *context, const world *w, const trace_spec *spec,
                            trace_tracer **out);
fathom_status plugin_create(fathom_context *context, const world *w, const trace_spec *spec,
                            const trace_options *options, trace_tracer **out);
fathom_status bvh_create(fathom_context *context, const world *w, const trace_spec *spec,
                         const trace_options *options, trace_tracer **out);

#endif
