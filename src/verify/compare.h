/* Compares a tracer with the oracle, family by family. */
#pragma once

#include "trace/trace.h"
#include "verify/ask.h"
#include "verify/compare_family.h"
#include "verify/search/rays.h"
#include "verify/verdict/verdict.h"

/* A result that is a leak or wrong, and the call that returned it. */
typedef struct compare_failure {
    rays_family family;
    uint64_t index;
    verdict verdict;
    unsigned way; /* of calling, see ask.h; COMPARE_FIRST: the first call */
    ask_block block;
    ask_answer answer;
} compare_failure;

#define COMPARE_FIRST (UINT32_MAX - 2)

/* The tracer to check, and the data needed for it. All pointers are borrowed. */
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
    bool once;       /* do not repeat small batches until threads overlap in the tracer */
    size_t failures; /* maximum number of failures kept per family: the first ones */
    uint64_t sample; /* for this many first rays of each family, the exact hit is also searched over all
                        primitives */
    const struct recorded *rendered; /* the calls of a render, checked as the family RAYS_RENDERED; may be
                                        NULL */
    /* `screened` more rays are traced, and checked only if this other tracer gives another result; NULL:
     * none. */
    const trace_tracer *second;
    uint64_t screened;
    /* Called from the calling thread, with the number of rays done. False stops the run. May be NULL. */
    bool (*progress)(void *user, uint64_t rays);
    void *user;
    /* Called from all threads, often. True: answers are no longer needed, as progress will return false. May
     * be NULL. */
    bool (*stopped)(void);
} compare_options;

typedef struct compare_result {
    compare_family families[RAYS_FAMILIES];
    ARRAY(compare_failure) failures; /* leaks and wrong results, by family and index, any hit after closest */
    uint64_t sampled, differ;        /* rays of the sample; those for which the two searches differ */
    uint64_t screened, unequal;      /* rays traced with both tracers; those that differed and were checked */
    uint64_t nanoseconds, rays;      /* time spent on closest hits, summed over threads, and number of these
                                        rays */
} compare_result;

/* Zero `out` first; release it with compare_result_free(), also after a failure. FATHOM_INTERRUPTED when
 * progress returned false: `out` then holds the results so far. Only `nanoseconds` depends on the threads, if
 * the tracer's hits do not. */
fathom_status compare_run(fathom_context *context, const compare_subject *subject,
                          const compare_options *options, compare_result *out);
void compare_result_free(compare_result *result);

/* Checks a result for the ray: its closest hit with all reported values, or any hit. `room` is working memory
 * for searches. False when out of memory. */
bool compare_judge(const compare_subject *subject, const oracle_ray *ray, const ask_answer *answer, bool any,
                   search_result *room, verdict_report *out, error_report *errors);
