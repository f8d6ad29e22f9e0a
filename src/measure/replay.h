/* Records the rays that a render traces, and traces them again, timed. This tracing time is the lower limit
 * of the render time. */
#pragma once

#include "base/array.h"
#include "trace/embree/embree_bare.h"

/* One call of trace_closest() or trace_any(). */
typedef struct record_call {
    bare_query query;
    trace_coherence coherence;
    size_t first, rays; /* first: its first block; rays: their number */
} record_call;

/* Blocks per piece of the record's memory. */
#define RECORD_PIECE 1024

typedef struct record {
    ARRAY(record_call) calls;
    ARRAY(trace_rays *) pieces;
    size_t blocks;
    bool out_of_memory; /* the record is incomplete */
} record;

/* Empties the record and keeps its memory. */
void record_clear(record *r);
void record_free(record *r);
uint64_t record_rays(const record *r, bare_query query);

/* A tracer that records all rays in order, and passes them to `real`. Not thread-safe. `real` and `to` must
 * outlive it. NULL when out of memory. Release with trace_destroy(), which does not destroy `real`. */
trace_tracer *record_tracer(const trace_tracer *real, record *to);

typedef struct replay_result {
    double cpu_seconds;       /* of the calling thread */
    uint64_t rays[2], met[2]; /* indexed by bare_query; met: hits */
} replay_result;

/* Traces all rays through trace_closest() and trace_any(). bare: with Embree calls only, which requires
 * embree_bare_possible(). Only the calls are timed. Before them, the rays are converted to the form of the
 * calls and loaded into the second-level cache: in a render, they are in the cache too. False when out of
 * memory. */
bool replay(const record *r, const trace_tracer *tracer, bool bare, replay_result *out);
