/* Blocks of rays and a tracer's hits. Rays are traced once in a first way, then again in all the ways in
 * which a renderer may call a tracer (packet sizes, coherence, order). Results must not depend on the way. */
#pragma once

#include "base/array.h"
#include "trace/trace.h"
#include "verify/verdict/verdict.h"

/* One call of trace_closest_fine() and one of trace_any() for the same rays, or only one of them. */
typedef struct ask_call {
    size_t first, count; /* index of its first block; number of its rays, 16 per block */
    trace_coherence coherence;
    bool closest, any;
} ask_call;

/* A tracer's results for one ray. */
typedef struct ask_answer {
    verdict_answer hit; /* the closest hit; u, v and normal belong to it */
    double u, v;
    vec3_f32 normal;
    bool met; /* result of the any-hit query */
} ask_answer;

/* Rays, and the tracer's results in the first way. */
typedef struct ask_batch {
    ARRAY(ask_call) calls;
    oracle_ray *rays; /* 16 per block */
    trace_block *closest;
    trace_fine *fine;
    trace_rays *any;
    uint32_t *call_of; /* by block */
    size_t blocks, room;
    bool (*stopped)(void); /* asked by all threads: true leaves out the remaining calls; NULL: never */
} ask_batch;

/* Removes all blocks and allocates room for `blocks` new ones. False when out of memory. */
bool ask_batch_clear(ask_batch *batch, size_t blocks);
void ask_batch_free(ask_batch *batch);
/* Appends a call; the caller then sets its rays. False when out of memory. */
bool ask_batch_add(ask_batch *batch, size_t count, trace_coherence coherence, bool closest, bool any);
unsigned ask_lanes(const ask_batch *batch, size_t block);

/* Makes all calls in the first way, on this many threads. Returns the nanoseconds spent on closest hits,
 * summed over threads. */
uint64_t ask_all(const trace_tracer *tracer, ask_batch *batch, unsigned threads);
ask_answer ask_answer_of(const ask_batch *batch, size_t ray);
/* The answer of a call for closest hits; fine: NULL if the call gave no finer numbers. */
ask_answer ask_closest_of(const trace_block *block, const trace_fine *fine, unsigned lane);

/* A result from another way of calling, or from an earlier render. */
typedef struct ask_other {
    size_t ray;
    unsigned way;
    bool any;
    ask_answer answer;
} ask_other;
typedef ARRAY(ask_other) ask_others;

/* Ways are numbered from 0: 16, 11, 8, 5, 4 or 1 rays per call, as coherent rays, neighbours or neither, or
 * in reverse order. Unused lanes hold NaNs. */
/* Special values of `way`: the result that a render got, and that result after the repair of leaks. */
#define ASK_GIVEN UINT32_MAX
#define ASK_REPAIRED (UINT32_MAX - 1)
const char *ask_way_name(unsigned way);

/* Traces all blocks in all ways, on this many threads at once and, unless `once`, again until calls overlap;
 * a slow tracer in one way, once. Appends the results that differ from the first way's, each once, in the
 * order of rays. Stops at ASK_OTHERS_MOST, because more would add nothing. False when out of memory. */
#define ASK_OTHERS_MOST 500
bool ask_others_find(const trace_tracer *tracer, const ask_batch *batch, unsigned threads, bool once,
                     ask_others *out);

/* The rays of one call (up to 16) and the lane of interest: enough to repeat the call exactly. */
typedef struct ask_block {
    oracle_ray rays[LANES];
    unsigned lanes, lane;
    trace_coherence coherence;
    bool any;
} ask_block;

/* The call that traced this ray in `way`. For ASK_GIVEN and similar values: its own block, unchanged. */
ask_block ask_block_of(const ask_batch *batch, size_t ray, unsigned way, bool any);
ask_answer ask_block_again(const trace_tracer *tracer, const ask_block *block);
/* True if both hit the same primitive of the same instance, or nothing. */
bool ask_same_primitive(const ask_answer *a, const ask_answer *b);
/* True if all bits are the same. */
bool ask_same(const ask_answer *a, const ask_answer *b, bool any);
/* True if the primitives are the same, and t as a float: renders and files of --failures hold no more. */
bool ask_alike(const ask_answer *a, const ask_answer *b, bool any);
