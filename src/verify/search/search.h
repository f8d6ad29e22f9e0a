/* The exact answer over a whole world: closest hit with all its ties, and any hit.
 *
 * A test in double precision with a proved error bound (filter.h) rejects only what is certainly missed; runs
 * of primitives are rejected together by spheres around them, and by spheres around those (search_tree.h).
 * The oracle decides the candidates that remain. */
#ifndef PARITY_SEARCH_H
#define PARITY_SEARCH_H

#include "verify/exact/oracle.h"

typedef struct search search;

typedef struct search_hit {
    uint32_t geometry, primitive, instance; /* as in trace_hits */
    oracle_answer answer;
} search_hit;

typedef struct search_candidate {
    uint32_t geometry, primitive, instance;
    double t_low; /* no hit is nearer */
} search_candidate;

/* One ray's answer and the room it takes; may be used again and again. Zero it first, release it with
 * search_result_free(). One thread at a time. */
typedef struct search_result {
    ARRAY(search_hit) ties; /* all hits with the exact smallest t, in the world's order; none: a miss */
    ARRAY(search_candidate) candidates;
} search_result;

/* Vertices of meshes need not be finite: such triangles are never met. The world must outlive it. */
fathom_status search_create(fathom_context *context, const world *w, search **out);
void search_destroy(search *s);

/* False when out of memory. Many threads may search at once, each with a result of its own. */
bool search_closest(const search *s, const oracle_ray *ray, search_result *result);
/* The same without any sphere: every primitive is tested. */
bool search_exhaustive(const search *s, const oracle_ray *ray, search_result *result);
/* The closest hit among what casts shadows. */
bool search_shadow(const search *s, const oracle_ray *ray, search_result *result);
/* Fills `candidates` with everything that casts shadows and may be met when the origin moves by up to `aside`
 * and the interval widens accordingly; `ties` stays empty. */
bool search_near(const search *s, const oracle_ray *ray, double aside, search_result *result);
void search_result_free(search_result *result);
/* All but planes lies so far from the world's origin at most. */
double search_extent(const search *s);

/* The primitive as the oracle takes it. geometry may be TRACE_PLANE; instance FATHOM_NONE. */
oracle_primitive search_primitive(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance);

#endif
