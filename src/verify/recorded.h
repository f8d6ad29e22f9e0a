/* The calls of a render: its rays in their blocks, as it asked them, the answers it got, and what its repair
 * of leaks (trace/watertight) put in their place. */
#ifndef VERIFY_RECORDED_H
#define VERIFY_RECORDED_H

#include "verify/ask.h"

typedef struct recorded_call {
    size_t first, count; /* its first block; its rays */
    trace_coherence coherence;
    bool any;
    const void *from; /* the render's own blocks */
} recorded_call;

typedef struct recorded {
    ARRAY(recorded_call) calls;
    ARRAY(oracle_ray) rays;    /* 16 a block, as they were asked */
    ARRAY(ask_answer) answers; /* parallel to rays; t as a float */
    ask_others repaired;       /* `ray` is the place among rays; in the order of calls, each ray once */
    bool failed;               /* out of memory */
} recorded;

/* Renders the scene with the tracer, a sample for each pixel, width wide, by one thread. The scene needs a
 * camera; without lights there are no shadow rays. Release `out` with recorded_free() whatever comes back. */
fathom_status recorded_render(fathom_context *context, const world *w, const trace_tracer *tracer,
                              uint32_t width, recorded *out);
void recorded_free(recorded *r);

#endif
