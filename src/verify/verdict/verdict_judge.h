/* What the two judges of answers, verdict.c and verdict_any.c, share. */
#ifndef PARITY_VERDICT_JUDGE_H
#define PARITY_VERDICT_JUDGE_H

#include "verify/verdict/verdict_bound.h"

/* One answer on its way to a verdict. */
typedef struct judge {
    const search *search;
    const world *world;
    const verdict_tracer *tracer;
    const oracle_ray *ray;
    search_result *room;
    bool shadows;               /* only what casts shadows counts */
    bool failed;                /* out of memory */
    const verdict_answer *said; /* what was reported instead of the nearest; NULL: nothing */
} judge;

/* The exact t of the nearest hit, infinite for a miss; `room` then holds it. */
double judge_nearest(judge *j, const oracle_ray *ray);

/* Why `hit`, exactly the nearest, was not reported; the tracer saw nothing before t (infinite: at all). */
verdict judge_skip(judge *j, const search_hit *hit, double before);

/* The exact intersection nearest to t: of a sphere, of the root that was taken. */
void judge_ask(const judge *j, const oracle_primitive *p, double t, oracle_answer *out);

/* Whether the primitive may be met at that t at all; AGREE: it is, exactly. `a`: what judge_ask() said. */
verdict judge_meeting(const judge *j, const oracle_primitive *p, const oracle_answer *a, double t,
                      verdict_bound *bound);

#endif
