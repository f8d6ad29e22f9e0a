/* A tracer against the oracle, family by family. */
#ifndef VERIFY_COMPARE_H
#define VERIFY_COMPARE_H

#include "trace/trace.h"
#include "verify/ask.h"
#include "verify/compare_family.h"
#include "verify/search/rays.h"
#include "verify/verdict/verdict.h"

/* An answer that is a leak or wrong, and the call that got it. */
typedef struct compare_failure {
    rays_family family;
    uint64_t index;
    verdict verdict;
    unsigned way; /* ask.h; COMPARE_FIRST: the first one */
    ask_block block;
    ask_answer answer;
} compare_failure;

#define COMPARE_FIRST (UINT32_MAX - 2)

/* The tracer to judge and what that needs; borrowed. */
typedef struct compare_subject {
    const world *world;
    const search *search;
    const rays_source *source;
    const trace_tracer *tracer;
    verdict_tracer precision;
} compare_subject;

typedef struct compare_options {
    unsigned families; /* bit i: rays_family i */
    uint64_t rays;     /* of each family */
    uint64_t seed;
    unsigned threads;
    bool once;       /* few rays are not asked again until threads meet in the tracer */
    size_t failures; /* kept, of each family: the first ones */
    uint64_t
        sample; /* of each family so many rays first have their exact answer found by every primitive too */
    const struct recorded *rendered; /* the calls of a render, judged as RAYS_RENDERED; may be NULL */
    /* So many rays more are only judged where this other tracer answers otherwise; NULL: none. */
    const trace_tracer *second;
    uint64_t screened;
    /* From the calling thread, with the number of rays done. False stops it. May be NULL. */
    bool (*progress)(void *user, uint64_t rays);
    void *user;
} compare_options;

typedef struct compare_result {
    compare_family families[RAYS_FAMILIES];
    ARRAY(compare_failure) failures; /* leaks and what is wrong, by family and index, any hit after closest */
    uint64_t sampled, differ;        /* rays of the sample; those where both ways did not find the same */
    uint64_t screened, unequal;      /* rays asked of both tracers; those that were judged */
    uint64_t nanoseconds, rays; /* spent tracing closest hits, added up over threads, and of how many rays */
} compare_result;

/* Zero `out` first and release it with compare_result_free() whatever comes back. FATHOM_INTERRUPTED when
 * progress said stop: `out` then holds what was done. No number but nanoseconds depends on the threads, as
 * long as the tracer's answers do not. */
fathom_status compare_run(fathom_context *context, const compare_subject *subject,
                          const compare_options *options, compare_result *out);
void compare_result_free(compare_result *result);

/* Judges an answer to the ray: its closest hit with all that it reports, or any hit. `room` is for searches.
 * False when out of memory. */
bool compare_judge(const compare_subject *subject, const oracle_ray *ray, const ask_answer *answer, bool any,
                   search_result *room, verdict_report *out, error_report *errors);

#endif
