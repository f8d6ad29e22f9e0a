/* Candidates judged by the reference intersector: the smallest t wins, then the first in world order, as in
 * linear search. */
#ifndef TRACE_EMBREE_VOTE_H
#define TRACE_EMBREE_VOTE_H

#include "trace/embree/embree.h"
#include "trace/search.h"

/* A candidate as Embree has it. */
typedef struct embree_offered {
    bool any;
    float t;
    uint32_t ids[3]; /* the world's: instance, geometry, primitive */
    uint32_t half;   /* of a quad that is traced in halves: which, 0 or 1; else 0 */
    float normal[3], u, v;
} embree_offered;

typedef struct embree_vote {
    const embree_tracer *tracer;
    search_f32 search;      /* by the reference intersector */
    embree_offered met;     /* first among those that it meets, by its t */
    embree_offered offered; /* first among all, by Embree's own */
} embree_vote;

/* For the lane's ray, its interval as it was asked. */
void embree_vote_begin(embree_vote *vote, const embree_tracer *tracer, const trace_rays *rays, unsigned lane,
                       float t_far);
/* The t at which the reference intersector meets a primitive of the world by the lane's ray; false: not. */
bool embree_vote_reference(const embree_tracer *tracer, const trace_rays *rays, unsigned lane, float t_far,
                           const uint32_t ids[3], float *t);
/* A hit in rows of n numbers, at t by Embree. */
void embree_vote_consider(embree_vote *vote, const float *hit, unsigned n, float t);

#endif
