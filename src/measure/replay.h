/* Records the rays that a render asks of its tracer and traces them again, timed: the ceiling of that render.
 */
#ifndef BENCH_REPLAY_H
#define BENCH_REPLAY_H

#include "base/array.h"
#include "trace/embree/embree_bare.h"

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
uint64_t record_rays(const record *r, bare_query query);

/* A tracer that records all rays, in order, and passes them on to `real`; one thread at a time. Both must
 * outlive it. NULL when out of memory. Release with trace_destroy(), which leaves `real` alone. */
trace_tracer *record_tracer(const trace_tracer *real, record *to);

typedef struct replay_result {
    double cpu_seconds;       /* of the thread */
    uint64_t rays[2], met[2]; /* by bare_query */
} replay_result;

/* Traces all rays through trace_closest() and trace_any(); bare: by Embree's calls alone, which wants
 * embree_bare_possible(). Only the calls are timed: rays are brought into the form of the calls, and into the
 * processor's second-level cache, before. A render's rays are in its cache too. False when out of memory. */
bool replay(const record *r, const trace_tracer *tracer, bool bare, replay_result *out);

#endif
