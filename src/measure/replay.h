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

/* Keeps closest-hit and any-hit rays in these records; NULL: keeps none. `real` and the records must outlive
 * the tracer. NULL when out of memory. Release with trace_destroy(), which leaves `real` alone. */
trace_tracer *record_tracer(const trace_tracer *real, record *closest, record *any);

/* ---- rays in the form in which they are asked ----
 * Rays are brought into that form, and into the processor's second-level cache, outside of what is timed. A
 * render's rays are in its cache too when they are traced. */

/* Blocks between two looks at the clocks: 4096 rays, some 0.4 MB in either form. Reading the clocks takes
 * under a microsecond, tracing so many rays more than a hundred. */
#define REPLAY_PIECE 256

typedef struct replay_piece {
    bare_block bare[REPLAY_PIECE];
    trace_block closest[REPLAY_PIECE];
    trace_rays any[REPLAY_PIECE];
} replay_piece;

/* Through trace_closest() and trace_any(), or by Embree's calls alone, which wants embree_bare_possible(). */
typedef struct replay_way {
    const trace_tracer *tracer;
    bool bare;
} replay_way;

/* Rays of one kind in a piece. */
typedef struct replay_part {
    bare_query query;
    trace_coherence coherence;
    size_t first, rays; /* the first block in the piece */
} replay_part;

/* Puts a block of the part, counted from its first, into the piece. */
void replay_load(const replay_way *way, const replay_part *part, size_t block, const trace_rays *rays,
                 replay_piece *piece);
void replay_trace(const replay_way *way, const replay_part *part, replay_piece *piece);
/* How many of the part's rays met something. */
uint64_t replay_met(const replay_way *way, const replay_part *part, const replay_piece *piece);

/* ---- a whole record asked again ---- */

typedef struct replay_result {
    double seconds, cpu_seconds; /* by the clock; of one thread's processor */
    uint64_t rays[2], met[2];    /* by bare_query */
} replay_result;

/* False when out of memory. */
bool replay(const record *r, const replay_way *way, replay_result *out);
/* The bare calls by several threads at once, each of which asks all rays: the mean of their seconds, and the
 * first one's counts. Threads that do not hinder each other take as long as one alone. */
bool replay_together(const record *r, const trace_tracer *tracer, unsigned threads, replay_result *out);

#endif
