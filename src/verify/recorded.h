/* A recording of a render's tracer calls: its rays in their original blocks, the hits, and the hits that its
 * repair of leaks (trace/watertight) changed. */
#pragma once

#include "verify/ask.h"

typedef struct recorded_call {
    size_t first, count; /* index of its first block; number of its rays */
    trace_coherence coherence;
    bool any;
    const void *from; /* the render's own blocks, to identify the call */
} recorded_call;

typedef struct recorded {
    ARRAY(recorded_call) calls;
    ARRAY(oracle_ray) rays;    /* 16 per block, as traced */
    ARRAY(ask_answer) answers; /* parallel to rays; t as a float */
    ask_others repaired;       /* `ray` is an index into rays; in the order of calls, each ray once */
    bool failed;               /* out of memory */
} recorded;

/* Renders the scene with the tracer on one thread, one sample per pixel, `width` pixels wide. The scene needs
 * a camera; without lights there are no shadow rays. Release `out` with recorded_free(), also after a
 * failure. FATHOM_INTERRUPTED: progress, which gets no user, returned false. */
fathom_status recorded_render(fathom_context *context, const world *w, const trace_tracer *tracer,
                              uint32_t width, fathom_progress_fn progress, recorded *out);
void recorded_free(recorded *r);
