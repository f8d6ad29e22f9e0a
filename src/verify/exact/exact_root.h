/* Numbers (p + s √d) / q in whole numbers: where lines meet planes (s = 0) and spheres. */
#ifndef PARITY_EXACT_ROOT_H
#define PARITY_EXACT_ROOT_H

#include "verify/exact/integer.h"

/* q > 0, d >= 0; d counts only where s is not 0. */
typedef struct exact_root {
    integer p, d, q;
    int s; /* -1, 0, 1 */
} exact_root;

/* m 2^e: any finite float. m is odd or 0. */
typedef struct dyadic {
    int64_t m;
    int e;
} dyadic;

dyadic dyadic_of(float x);

/* *r = *r 2^bits */
void exact_root_scale(exact_root *r, int bits);
/* *r = *r - x */
void exact_root_subtract(exact_root *r, dyadic x);
int exact_root_sign(const exact_root *r);
/* -1, 0, 1 as x is less than, equal to or greater than y. */
int exact_root_compare(const exact_root *x, const exact_root *y);
/* Within 2^-105 of itself; zero exactly. */
ball exact_root_ball(const exact_root *r);

#endif
