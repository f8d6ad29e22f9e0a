/* Embree's calls alone: rays are brought into Embree's form beforehand, and answers stay in it. Any renderer
 * on Embree must spend this time on the same rays; the tracer is measured against it. */
#ifndef TRACE_EMBREE_BARE_H
#define TRACE_EMBREE_BARE_H

#include "trace/trace.h"

/* Numbers for each ray in packets of fewer than 16: 12 of the ray, at most 9 of the hit, and padding. */
#define EMBREE_BARE_ROWS 24

/* Up to 16 rays: one packet, or several narrower ones in a row. */
typedef struct bare_block {
    union {
        trace_block whole;
        _Alignas(64) uint32_t rows[EMBREE_BARE_ROWS * LANES];
    };
    _Alignas(64) int valid[LANES];
    unsigned lanes, width; /* rays in use; rays in a packet */
    bool coherent;
} bare_block;

typedef enum bare_query { BARE_CLOSEST, BARE_ANY } bare_query;

/* True for Embree's tracers: others have no bare form. */
bool embree_bare_possible(const trace_tracer *tracer);
/* The first `lanes` rays as the tracer would hand them over: masks, valid lanes, t_far, width and kernels. */
void embree_bare_load(const trace_tracer *tracer, bare_query query, trace_coherence coherence,
                      const trace_rays *rays, unsigned lanes, bare_block *out);
/* The calls, over the tracer's own scene: same flags, same build. */
void embree_bare_trace(const trace_tracer *tracer, bare_query query, bare_block *blocks, size_t count);
/* How many rays of a traced block met something. */
unsigned embree_bare_met(bare_query query, const bare_block *block);

#endif
