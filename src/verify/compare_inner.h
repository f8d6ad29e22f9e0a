/* The state of a running comparison, shared by its source files. */
#pragma once

#include "verify/compare.h"

#define COMPARE_CALL (8 * LANES) /* rays in a call of a family */

/* One thread's counts. */
typedef struct compare_worker {
    search_result room, linear; /* linear: for the sample */
    compare_family family;
    ARRAY(compare_failure) failures;
    ask_batch batch; /* for rays that two tracers trace */
    uint64_t sampled, differ, screened, unequal;
    bool failed; /* out of memory */
} compare_worker;

typedef struct comparison {
    const compare_subject *subject;
    const compare_options *options;
    rays_family family;
    uint64_t first; /* first ray of the batch: its index in the family */
    ask_batch batch;
    ask_others others;
    const ask_answer *given; /* results of the render, parallel to the batch's rays; NULL: none */
    compare_worker *workers;
} comparison;

/* Checks a result from another way of calling, and adds its verdict to other_counts. */
void compare_judge_other(const comparison *c, compare_worker *w, const ask_other *other);
/* Makes rays [begin, end) of the batch. Body of a parallel loop; user: the comparison. */
void compare_make_rays(void *user, size_t begin, size_t end);
/* After each batch: adds the workers' results to `out` and resets the workers. */
fathom_status compare_join_workers(fathom_context *context, const comparison *c, compare_result *out,
                                   size_t family_begin);
fathom_status compare_tell(fathom_context *context, const compare_options *o, uint64_t done);

/* compare_screen.c: rays that two tracers trace. Their indices follow those of the family, so all rays are
 * new. */
fathom_status compare_screen(fathom_context *context, comparison *c, uint64_t done, compare_result *out);
