/* The exact hit in a whole world: closest hit with all ties, and any hit.
 *
 * A test in double precision with a proved error bound (filter.h) rejects only certain misses. Runs of
 * primitives are rejected together by a hierarchy of bounding spheres (search_tree.h). The oracle decides the
 * remaining candidates. */
#pragma once

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

/* One ray's result and working memory; reusable. Zero it first, release it with search_result_free(). One
 * thread at a time. */
typedef struct search_result {
    ARRAY(search_hit) ties; /* all hits with the exact smallest t, in the world's order; none: a miss */
    ARRAY(search_candidate) candidates;
} search_result;

/* Mesh vertices need not be finite: such triangles are never hit. The world must outlive *out. */
fathom_status search_create(fathom_context *context, const world *w, search **out);
void search_destroy(search *s);

/* False when out of memory. Thread-safe, if each thread has its own result. */
bool search_closest(const search *s, const oracle_ray *ray, search_result *result);
/* Same without bounding spheres: every primitive is tested. */
bool search_exhaustive(const search *s, const oracle_ray *ray, search_result *result);
/* The closest hit among shapes that cast shadows. */
bool search_shadow(const search *s, const oracle_ray *ray, search_result *result);
/* Fills `candidates` with all shapes that cast shadows and may be hit when the origin moves by up to `aside`
 * and the interval widens accordingly; `ties` stays empty. */
bool search_near(const search *s, const oracle_ray *ray, double aside, search_result *result);
void search_result_free(search_result *result);
/* Maximum distance of anything but planes from the world's origin. */
double search_extent(const search *s);

/* Converts a primitive for the oracle. geometry may be TRACE_PLANE; instance may be FATHOM_NONE. */
oracle_primitive search_primitive(const world *w, uint32_t geometry, uint32_t primitive, uint32_t instance);
