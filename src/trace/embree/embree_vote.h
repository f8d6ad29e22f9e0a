/* Decides between candidates with the reference intersector: the smallest rank wins, then the first in world
 * order, as in linear search. */
#pragma once

#include "trace/embree/embree.h"
#include "trace/search.h"

/* A candidate as Embree reports it. */
typedef struct embree_offered {
    bool any;
    float t;
    uint32_t ids[3]; /* the world's: instance, geometry, primitive */
    uint32_t half;   /* 0 or 1 for a quad that is traced as two triangles; else 0 */
    float normal[3], u, v;
} embree_offered;

typedef struct embree_vote {
    const embree_tracer *tracer;
    search_f32 search;      /* by the reference intersector */
    embree_offered met;     /* best candidate that `search` also hits, by its rank */
    embree_offered offered; /* best of all candidates, by Embree's t */
} embree_vote;

/* Starts a vote for the lane's ray, with the interval of the original query. */
void embree_vote_begin(embree_vote *vote, const embree_tracer *tracer, const trace_rays *rays, unsigned lane,
                       float t_far);
/* Intersects a primitive of the world with the lane's ray by the reference intersector. False: miss. */
bool embree_vote_reference(const embree_tracer *tracer, const trace_rays *rays, unsigned lane, float t_far,
                           const uint32_t ids[3], float *t);
/* Adds a candidate with Embree's t; `hit` has rows of n numbers. */
void embree_vote_consider(embree_vote *vote, const float *hit, unsigned n, float t);
