/* Embree's calls alone: rays are converted to Embree's layout beforehand, and results stay in it. Every
 * renderer that uses Embree spends at least this time on the same rays; the benchmark compares the tracer
 * with it. */
#pragma once

#include "trace/trace.h"

/* Numbers for each ray in packets of fewer than 16: 12 for the ray, at most 9 for the hit, and padding. */
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

/* True for Embree's tracers, unless Embree's scene is empty: a few spheres, and planes, are not in it. Other
 * tracers have no bare form. */
bool embree_bare_possible(const trace_tracer *tracer);
/* Prepares the first `lanes` rays as the tracer would: masks, valid lanes, t_far, packet width and
 * kernels. */
void embree_bare_load(const trace_tracer *tracer, bare_query query, trace_coherence coherence,
                      const trace_rays *rays, unsigned lanes, bare_block *out);
/* Makes the calls on the tracer's own scene, with the same flags and the same build. */
void embree_bare_trace(const trace_tracer *tracer, bare_query query, bare_block *blocks, size_t count);
/* Number of rays of a traced block that hit something. */
unsigned embree_bare_met(bare_query query, const bare_block *block);
