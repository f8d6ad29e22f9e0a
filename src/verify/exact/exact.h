/* The oracle's arithmetic: integers, without rounding. A power of two scales the coordinates to integers,
 * another one the directions; t is then scaled by their ratio. */
#pragma once

#include "verify/exact/oracle.h"

#include <gmp.h>

/* ---- the solution for a ray and a sphere, triangle or plane; oracle.c interprets it ---- */

typedef struct solution {
    bool parallel;  /* nothing else is set */
    unsigned roots; /* number of roots; 0: the line misses the sphere, and t[0] is the closest approach */
    real_f128 t[2], above_near[2], below_far[2];
    real_f128 weight[3]; /* triangles */
    real_f128 edge;      /* spheres */
} solution;

/* The primitive must be a sphere with a radius above 0, a triangle or a plane. All numbers must be finite,
 * except the ends of the interval. */
void exact_solve(const oracle_ray *ray, const oracle_primitive *primitive, solution *out);

/* As oracle_condition(); for a quad, pass the triangle of its `part`. */
double condition_of(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                    bool inverted);

/* A ray in the space of the instance (NULL: the world), in quadruple precision, for computations that need no
 * more digits. */
typedef struct object_ray {
    vec3_f128 org, dir;
} object_ray;
object_ray object_ray_of(const oracle_ray *ray, const world_instance *instance);

/* ---- integers: GMP's, of up to 16384 bits in limbs of our own, so that GMP never allocates ----
 *
 * Coordinates, scaled to integers, have at most 560 bits after an instance's transform. The longest
 * expression, the comparison of two spheres' roots, has 13,800 bits. Sphere centres are sums of two floats:
 * they are integers in the same scale, and have no more bits. */

#define INTEGER_LIMBS 256

/* Must not be moved or copied after integer_init(), because z points to limb. */
typedef struct integer {
    mpz_t z;
    mp_limb_t limb[INTEGER_LIMBS];
} integer;

/* Sets a to zero. GMP does not reallocate a number with enough limbs, so these may be our own. */
static inline void integer_init(integer *a) {
    a->z->_mp_alloc = INTEGER_LIMBS, a->z->_mp_size = 0, a->z->_mp_d = a->limb;
}
/* Relative error at most 2^-111; exact up to 64 bits. */
real_f128 integer_real(const integer *a);
/* r = a · b, r = a × b of 3-vectors; r must not alias a or b. Both initialise r. */
void integer_dot(integer *r, const integer a[3], const integer b[3]);
void integer_cross(integer r[3], const integer a[3], const integer b[3]);

/* m 2^e: any finite float. m is odd or 0. */
typedef struct dyadic {
    int64_t m;
    int e;
} dyadic;
dyadic dyadic_of(float x);

/* (p + s √d) / q: t at which a line hits a plane (s = 0) or a sphere. q > 0, d >= 0; d is used only if s is
 * not 0. */
typedef struct exact_root {
    integer p, d, q;
    int s; /* -1, 0, 1 */
} exact_root;

/* Sets the root from these numbers, times 2^scale; d may be NULL for s = 0. */
void exact_root_set(exact_root *r, const integer *p, int s, const integer *d, const integer *q, int scale);
/* *r = *r - x */
void exact_root_subtract(exact_root *r, dyadic x);
/* -1, 0 or 1 if x is less than, equal to or greater than y. */
int exact_root_compare(const exact_root *x, const exact_root *y);
/* Relative error at most 2^-105; zero is exact. */
real_f128 exact_root_real(const exact_root *r);

/* The t of root `which` (spheres: 0 smaller, 1 larger; else 0). The line must hit the shape; for a quad, pass
 * the triangle of its `part`. */
void exact_root_of(const oracle_ray *ray, const oracle_primitive *primitive, unsigned which, exact_root *out);
