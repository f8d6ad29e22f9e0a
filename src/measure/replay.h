/* Records what a render asks of its tracer, and asks it again, timed: the ceiling of that render. */
#ifndef BENCH_REPLAY_H
#define BENCH_REPLAY_H

#include "base/array.h"
#include "trace/embree/embree_bare.h"

/* ---- a tracer that hands every ray on to another and keeps it, in order; one thread at a time ---- */

/* One call of trace_closest() or trace_any(). */
typedef struct record_call {
    bare_query query;
    trace_coherence coherence;
    size_t first, rays; /* its first block; how many rays it had */
} record_call;

/* Blocks in a piece of the record's memory. */
#define RECORD_PIECE 1024

typedef struct record {
    ARRAY(record_call) calls;
    ARRAY(trace_rays *) pieces;
    size_t blocks;
    bool out_of_memory; /* the record is not whole */
} record;

/* Forgets all and keeps the memory. */
void record_clear(record *r);
void record_free(record *r);
/* Rays as they were asked. */
const trace_rays *record_block(const record *r, size_t index);
uint64_t record_rays(const record *r, bare_query query);

/* One call of so many rays; `stride`: bytes from one block's rays to the next one's. */
void record_keep(record *r, bare_query query, trace_coherence coherence, const void *rays, size_t stride,
                 size_t count);

/* Both must outlive the tracer. NULL when out of memory. Release with trace_destroy(), which leaves `real`
 * alone. */
trace_tracer *record_tracer(const trace_tracer *real, record *to);
/* From now on it keeps the rays of either query here; NULL: not at all. */
void record_redirect(trace_tracer *recorder, record *closest, record *any);

/* ---- the rays of a record asked again ----
 * Rays are brought to the processor's second-level cache piece by piece, and into the form that is asked for,
 * outside of what is timed. A render's rays are in its cache too when they are traced. */

typedef struct replay_result {
    double seconds, cpu_seconds; /* by the clock; of one thread's processor */
    uint64_t rays[2], met[2];    /* by bare_query */
} replay_result;

/* By Embree's calls alone; embree_bare_possible() must hold. All are false when out of memory. */
bool replay_bare(const record *r, const trace_tracer *tracer, replay_result *out);
/* The same by several threads at once, each of which asks all rays: the mean of their seconds, and the
 * first one's counts. Were they no hindrance to each other, they took as long as one alone. */
bool replay_bare_together(const record *r, const trace_tracer *tracer, unsigned threads, replay_result *out);
/* The same in packets of `width`, 1, 4, 8 or 16, by the kernels for coherent packets or the others. */
bool replay_bare_as(const record *r, const trace_tracer *tracer, unsigned width, bool coherent,
                    replay_result *out);
/* By trace_closest() and trace_any(). */
bool replay_traced(const record *r, const trace_tracer *tracer, replay_result *out);

#endif
