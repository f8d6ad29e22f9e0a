/* A tracer's results for one family of rays: counts of verdicts, and measured errors. */
#pragma once

#include "verify/error.h"
#include "verify/verdict/verdict.h"

/* A maximum and the ray that caused it, of equals the first. */
typedef struct compare_most {
    double value;
    uint64_t index;
    oracle_ray ray;
} compare_most;

/* Errors. They are measured if the line hits the reported primitive and the verdict is neither leak nor
 * wrong. */
typedef enum compare_measure {
    COMPARE_T_ULPS,     /* of t, in units of its last place as a float */
    COMPARE_T_RELATIVE, /* of t times |d|, which is the error of the position, divided by the world's
                           radius */
    COMPARE_POSITION,   /* this and the two below: as in error.h */
    COMPARE_NORMAL,
    COMPARE_UV,
    COMPARE_MEASURES
} compare_measure;

typedef struct compare_error {
    histogram counts;
    compare_most most;
} compare_error;

/* Slivers and surfaces seen from very far have errors far above their condition, and their bounds allow these
 * (verdict_bound.c): a triangle's bound is 32 L² / |n| times its condition. Hits with a bound of more than
 * COMPARE_SHAPED units of condition are excluded from the statistics of errors. For triangles, this means L²
 * > 8 |n|. */
#define COMPARE_SHAPED 256.0

/* Signed errors of t in units of the tracer's roundoff times t, for hits whose condition is at most
 * COMPARE_WELL |t|. They are multiples of 1/1024, so that sums do not depend on the order. */
#define COMPARE_WELL 32
typedef struct compare_bias {
    int64_t sum;
    uint64_t squares, count;
} compare_bias;

/* Results of one family. */
typedef struct compare_family {
    uint64_t rays, counts[VERDICT_COUNT];
    uint64_t any_rays, any_counts[VERDICT_COUNT]; /* the same rays, as any-hit queries */
    uint64_t others, other_counts[VERDICT_COUNT]; /* results that depend on the way of calling (ask.h) */
    uint64_t repaired;                            /* results that a render's repair of leaks replaced */
    compare_error errors[COMPARE_MEASURES];
    histogram constants;   /* errors divided by (unit roundoff times condition number), of hits with a bound
                              of at most COMPARE_SHAPED */
    compare_most constant; /* the largest of them */
    compare_most widest;   /* the largest bound for t, divided by unit roundoff times t */
    compare_bias bias;
} compare_family;

/* Adds the errors of a measured result that is neither leak nor wrong. `index`: of the ray in its family;
 * `unit`: the tracer's roundoff; `radius`: the world's. */
void compare_family_measure(compare_family *f, const oracle_ray *ray, uint64_t index,
                            const verdict_report *report, const error_report *errors, double unit,
                            double radius);
/* Adds the counts of `from` to `to`. The sums do not depend on the order of the calls. */
void compare_family_join(compare_family *to, const compare_family *from);
