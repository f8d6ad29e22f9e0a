/* A tracer that hands every ray on to another and keeps it: what a render asked, in order. For one thread at
 * a time. */
#ifndef BENCH_RECORD_H
#define BENCH_RECORD_H

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

#endif
