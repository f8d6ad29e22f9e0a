/* Whole numbers of up to 16384 bits, by GMP's layer of plain limbs: exact, without allocating.
 *
 * What the oracle forms of floats is bounded: coordinates, scaled to whole numbers, have at most 560 bits
 * after an instance's map, and the longest expression, the comparison of two spheres' roots (exact_root.c),
 * has 13,800. Centres of spheres are sums of two floats: they are whole in the same scale, and have no more
 * bits. */
#ifndef PARITY_INTEGER_H
#define PARITY_INTEGER_H

#include "verify/exact/ball.h"

#include <gmp.h>
#include <stdint.h>

#define INTEGER_LIMBS 256

typedef struct integer {
    int size; /* limbs in use, the highest not zero; negative for negative numbers */
    mp_limb_t limb[INTEGER_LIMBS];
} integer;

/* m 2^shift */
void integer_set(integer *r, int64_t m, unsigned shift);
void integer_copy(integer *r, const integer *a);
/* r may be a or b. */
void integer_add(integer *r, const integer *a, const integer *b);
void integer_sub(integer *r, const integer *a, const integer *b);
/* r must be neither a nor b. */
void integer_mul(integer *r, const integer *a, const integer *b);
/* *r = *r 2^bits */
void integer_shift(integer *r, unsigned bits);
static inline void integer_negate(integer *r) { r->size = -r->size; }
/* -1, 0, 1 */
static inline int integer_sign(const integer *a) { return (a->size > 0) - (a->size < 0); }
int integer_compare(const integer *a, const integer *b);
/* r = a · b, r = a × b of three-vectors; r must be none of them. */
void integer_dot(integer *r, const integer a[3], const integer b[3]);
void integer_cross(integer r[3], const integer a[3], const integer b[3]);
/* Within 2^-111 of itself; exact up to 64 bits. */
ball integer_ball(const integer *a);

#endif
