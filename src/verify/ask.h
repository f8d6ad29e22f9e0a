/* Blocks of rays and a tracer's answers: asked in one call, and once more in all the ways that a renderer
 * might ask them. No answer may depend on the way. */
#ifndef VERIFY_ASK_H
#define VERIFY_ASK_H

#include "base/array.h"
#include "trace/trace.h"
#include "verify/verdict/verdict.h"

/* One call of trace_closest_fine() and one of trace_any() for the same rays, or only one of them. */
typedef struct ask_call {
    size_t first, count; /* its first block; its rays, 16 to a block */
    trace_coherence coherence;
    bool closest, any;
} ask_call;

/* A tracer's answer to one ray. */
typedef struct ask_answer {
    verdict_answer hit; /* of the closest hit */
    double u, v;
    vec3_f32 normal;
    bool met; /* of any hit */
} ask_answer;

/* Rays, and what the tracer said to each in the first way. */
typedef struct ask_batch {
    ARRAY(ask_call) calls;
    oracle_ray *rays; /* 16 a block */
    trace_block *closest;
    trace_fine *fine;
    trace_rays *any;
    uint32_t *call_of; /* by block */
    size_t blocks, room;
} ask_batch;

/* Makes room for so many blocks and forgets those that were there. False when out of memory. */
bool ask_batch_clear(ask_batch *batch, size_t blocks);
void ask_batch_free(ask_batch *batch);
/* Appends a call without its rays. False when out of memory. */
bool ask_batch_add(ask_batch *batch, size_t count, trace_coherence coherence, bool closest, bool any);
unsigned ask_lanes(const ask_batch *batch, size_t block);

/* Asks all calls in the first way, on so many threads. Returns the nanoseconds that closest hits took, added
 * up over threads. */
uint64_t ask_all(const trace_tracer *tracer, ask_batch *batch, unsigned threads);
ask_answer ask_answer_of(const ask_batch *batch, size_t ray);

/* An answer that another way of asking got, or an answer that was given before. */
typedef struct ask_other {
    size_t ray;
    unsigned way;
    bool any;
    ask_answer answer;
} ask_other;
typedef ARRAY(ask_other) ask_others;

/* Ways, from 0: by 16, 11, 8, 4 and 1 rays in a call, as coherent rays, neighbours or neither, in reverse
 * order. The lanes that are not asked hold NaNs. */
/* No ways: the answer that a render got, and what its repair of leaks made of it. */
#define ASK_GIVEN UINT32_MAX
#define ASK_REPAIRED (UINT32_MAX - 1)
unsigned ask_ways(void);
const char *ask_way_name(unsigned way);

/* Asks all blocks in all ways, on so many threads at once and, unless `once`, again until calls overlap; a
 * slow tracer in one way, once. Appends the answers that differ from the first way's, each once, in the order
 * of rays; at most ASK_OTHERS_MOST, since more are no news. False when out of memory. */
#define ASK_OTHERS_MOST 500
bool ask_others_find(const trace_tracer *tracer, const ask_batch *batch, unsigned threads, bool once,
                     ask_others *out);

/* The rays of one call of up to 16, and which of them is meant: enough to ask it again as it was asked. */
typedef struct ask_block {
    oracle_ray rays[LANES];
    unsigned lanes, lane;
    trace_coherence coherence;
    bool any;
} ask_block;

/* The call in which a way asked this ray; where it is no way, its block by itself, as it was. */
ask_block ask_block_of(const ask_batch *batch, size_t ray, unsigned way, bool any);
ask_answer ask_block_again(const trace_tracer *tracer, const ask_block *block);
bool ask_same(const ask_answer *a, const ask_answer *b, bool any);

#endif
