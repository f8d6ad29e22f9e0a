/* The implementation side of trace.h: a table of functions for each kind of tracer. The struct of each tracer
 * begins with a trace_tracer. */
#pragma once

#include "trace/trace.h"

/* A triangle that a line crosses, by the tracer's own arithmetic. */
typedef struct trace_crossing {
    float t;
    uint32_t instance, geometry, primitive; /* the world's */
    bool entering;                          /* through the side on which its corners are counter-clockwise */
} trace_crossing;

typedef ARRAY(trace_crossing) trace_crossings;

typedef struct trace_ops {
    /* Releases the tracer and everything it owns. */
    void (*destroy)(trace_tracer *tracer);
    /* As trace_closest() and trace_any(); trace.c adds planes. closest() sets the ids of the hit and t_far,
     * or geometry = FATHOM_NONE. `fine` may be NULL; it is set only if ops->fine is true. */
    void (*closest)(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence);
    void (*any)(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence);
    bool fine;   /* closest() sets `fine` */
    bool planes; /* closest() and any() test planes too */
} trace_ops;

/* For watertight.c. */
typedef struct trace_retry {
    /* Searches again, slowly, for a hit of the lane's ray by the reference intersector that is nearer than
     * its t_far (any: inside its interval). `round` counts up from 0. True if it found one; the lane is then
     * set as by closest() or any(). */
    bool (*closest)(const trace_tracer *tracer, trace_block *block, unsigned lane, unsigned round);
    bool (*any)(const trace_tracer *tracer, trace_rays *rays, unsigned lane, unsigned round);
    /* Lists all triangles of a group (for group 0 also those of the instances) that the ray org + t dir
     * crosses, each once, in any order. False when out of memory. */
    bool (*crossings)(const trace_tracer *tracer, uint32_t group, vec3_f32 org, vec3_f32 dir,
                      trace_crossings *out);
    /* Bounding box of the group; lower > upper if it is empty. */
    void (*bounds)(const trace_tracer *tracer, uint32_t group, vec3_f32 *lower, vec3_f32 *upper);
} trace_retry;

struct trace_tracer {
    const trace_ops *ops;
    const trace_retry *retry; /* NULL: the tracer never misses a triangle */
    const trace_tracer *self; /* argument of the functions of `retry`; another tracer if this one only
                                 forwards rays */
    const world *world;
    uint64_t bvh_bytes, peak_bytes, foreseen_bytes; /* see trace.h; 0: not known */
    double unit;                                    /* roundoff */
    bool slow;                                      /* a ray may take milliseconds */
    bool tells_opaque;                              /* any() sets TRACE_NOT_OPAQUE */
    trace_passing passing;                          /* as told; {NULL}: nothing is known */
    char name[64];
    char way[32]; /* other choices that hits depend on; "": none */
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
