/* A tracer against the oracle, family by family. */
#ifndef PARITY_COMPARE_H
#define PARITY_COMPARE_H

#include "trace/trace.h"
#include "verify/ask.h"
#include "verify/error.h"
#include "verify/search/rays.h"
#include "verify/verdict/verdict.h"

/* The largest of something, and the ray that caused it: of equals the first. */
typedef struct compare_most {
    double value;
    uint64_t index;
    oracle_ray ray;
} compare_most;

/* Errors that are measured where the line meets the reported primitive and the verdict is neither leak nor
 * wrong. */
typedef enum compare_measure {
    COMPARE_T_ULPS,     /* of t, in units of its last place as a float */
    COMPARE_T_RELATIVE, /* of t times |d|, which is that of the position, over the world's radius */
    COMPARE_POSITION,   /* as in error.h, and those below */
    COMPARE_NORMAL,
    COMPARE_UV,
    COMPARE_MEASURES
} compare_measure;

typedef struct compare_error {
    histogram counts;
    compare_most most;
} compare_error;

/* Signed errors of t in units of the tracer's roundoff times t, of hits whose condition is at most
 * COMPARE_WELL |t|; in steps of 1/1024, so that sums do not depend on their order. */
#define COMPARE_WELL 32
typedef struct compare_bias {
    int64_t sum;
    uint64_t squares, count;
} compare_bias;

/* Results of one family. */
typedef struct compare_family {
    uint64_t rays, counts[VERDICT_COUNT];
    uint64_t any_rays, any_counts[VERDICT_COUNT]; /* of the same rays, asked for any hit */
    uint64_t others, other_counts[VERDICT_COUNT]; /* answers that depend on the way of asking */
    uint64_t repaired;                            /* answers that a render's repair of leaks replaced */
    compare_error errors[COMPARE_MEASURES];
    histogram constants;   /* errors over (unit roundoff times condition number) */
    compare_most constant; /* the largest of them */
    compare_most widest;   /* the widest bound that t was held against, over unit roundoff times t */
    compare_bias bias;
    uint64_t asked, exact; /* questions to the oracle, and those that took whole numbers */
} compare_family;

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

void compare_family_join(compare_family *to, const compare_family *from);

#endif
