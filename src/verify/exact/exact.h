/* The oracle's arithmetic: whole numbers, in which nothing is rounded. Coordinates are scaled by a power of
 * two that makes all of them whole, directions by another; t is then scaled by their ratio. */
#ifndef VERIFY_EXACT_H
#define VERIFY_EXACT_H

#include "verify/exact/oracle.h"

#include <gmp.h>

/* ---- what there is about a ray and a sphere, triangle or plane; oracle.c judges it ---- */

typedef struct solution {
    bool parallel;  /* nothing else is set */
    unsigned roots; /* 0: a sphere that the line misses; t[0] is the closest approach */
    real_f128 t[2], above_near[2], below_far[2];
    real_f128 weight[3]; /* triangles */
    real_f128 edge;      /* spheres */
} solution;

/* The primitive is a sphere with a radius above 0, a triangle or a plane; everything is finite but the
 * interval's ends. */
void exact_solve(const oracle_ray *ray, const oracle_primitive *primitive, solution *out);

/* As oracle_condition(); a quad is given by its part. */
double condition_of(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                    bool inverted);

/* A ray in the space of the instance, or of the world for NULL, in quadruple precision: for what takes no
 * more digits than that. */
typedef struct object_ray {
    vec3_f128 org, dir;
} object_ray;
object_ray object_ray_of(const oracle_ray *ray, const world_instance *instance);

/* ---- whole numbers: GMP's, of up to 16384 bits in limbs of our own, so that nothing allocates ----
 *
 * Coordinates, scaled to whole numbers, have at most 560 bits after an instance's map, and the longest
 * expression, the comparison of two spheres' roots, has 13,800. Centres of spheres are sums of two floats:
 * they are whole in the same scale, and have no more bits. */

#define INTEGER_LIMBS 256

/* Must stay where integer_init() found it. */
typedef struct integer {
    mpz_t z;
    mp_limb_t limb[INTEGER_LIMBS];
} integer;

/* Zero. GMP takes a number with room enough as it is, wherever its limbs are. */
static inline void integer_init(integer *a) {
    a->z->_mp_alloc = INTEGER_LIMBS, a->z->_mp_size = 0, a->z->_mp_d = a->limb;
}
/* Within 2^-111 of itself; exact up to 64 bits. */
real_f128 integer_real(const integer *a);
/* r = a · b, r = a × b of three-vectors; r must be none of them. Both initialise r. */
void integer_dot(integer *r, const integer a[3], const integer b[3]);
void integer_cross(integer r[3], const integer a[3], const integer b[3]);

/* m 2^e: any finite float. m is odd or 0. */
typedef struct dyadic {
    int64_t m;
    int e;
} dyadic;
dyadic dyadic_of(float x);

/* (p + s √d) / q: where lines meet planes (s = 0) and spheres. q > 0, d >= 0; d counts only where s is not
 * 0. */
typedef struct exact_root {
    integer p, d, q;
    int s; /* -1, 0, 1 */
} exact_root;

/* Sets the root from these numbers, times 2^scale; d may be NULL for s = 0. */
void exact_root_set(exact_root *r, const integer *p, int s, const integer *d, const integer *q, int scale);
/* *r = *r - x */
void exact_root_subtract(exact_root *r, dyadic x);
/* -1, 0, 1 as x is less than, equal to or greater than y. */
int exact_root_compare(const exact_root *x, const exact_root *y);
/* Within 2^-105 of itself; zero exactly. */
real_f128 exact_root_real(const exact_root *r);

/* The t of root `which` (spheres: 0 smaller, 1 larger; else 0). The line must meet the shape; a quad is given
 * by its part. */
void exact_root_of(const oracle_ray *ray, const oracle_primitive *primitive, unsigned which, exact_root *out);

#endif
