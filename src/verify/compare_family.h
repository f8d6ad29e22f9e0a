/* What a family of rays showed of a tracer: verdicts counted, errors measured. */
#ifndef VERIFY_COMPARE_FAMILY_H
#define VERIFY_COMPARE_FAMILY_H

#include "verify/error.h"
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

/* Slivers and surfaces seen from very far have errors far above their condition, which their bounds allow
 * (verdict_bound.c): a triangle's bound is 32 L² / |n| times its condition. Hits whose bound is wider than so
 * many units of condition take no part in statistics of errors: those of triangles with L² > 8 |n|. */
#define COMPARE_SHAPED 256.0

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
    histogram constants;   /* errors over (unit roundoff times condition number), of hits with such a bound */
    compare_most constant; /* the largest of all hits */
    compare_most widest;   /* the widest bound that t was held against, over unit roundoff times t */
    compare_bias bias;
} compare_family;

/* Adds the errors of a measured answer that is neither leak nor wrong. `index`: of the ray in its family;
 * `unit`: the tracer's roundoff; `radius`: the world's. */
void compare_family_measure(compare_family *f, const oracle_ray *ray, uint64_t index,
                            const verdict_report *report, const error_report *errors, double unit,
                            double radius);
/* No sum depends on the order of joining. */
void compare_family_join(compare_family *to, const compare_family *from);

#endif
