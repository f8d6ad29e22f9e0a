/* Rejects in double precision what is certainly missed.
 *
 * u = 2^-53. A ray in object space is known to within org_error and dir_error, bounds on the Euclidean length
 * of what rounding did to it (0 outside instances); its primitives' floats are exact. Everything here is far
 * from overflow: the largest product has degree 4 in numbers of at most 2^258. Products of very small numbers
 * may lose all digits: FILTER_LEAST covers that. NaN rejects nothing, since each test rejects by a comparison
 * that is true. */
#ifndef PARITY_FILTER_H
#define PARITY_FILTER_H

#include "verify/exact/oracle.h"

#define FILTER_LEAST 1e-150

typedef struct filter_ray {
    vec3_f64 org, dir;
    double org_error, dir_error;
    double length, largest; /* of dir: |dir|, and its largest component */
    double inverse;         /* 1 / dir·dir */
    double widen;           /* relative error of a quotient by dir·dir */
    double t_near, t_far;
    bool vague; /* the direction is known too badly: nothing is rejected */
} filter_ray;

filter_ray filter_ray_of(const oracle_ray *ray, const world_instance *instance);

/* Spheres around runs of primitives, as arrays. */
typedef struct filter_spheres {
    double *x, *y, *z, *radius;
} filter_spheres;

/* out[i] = 1 where the ray may meet what lies in sphere first + i in (t_near, t_far); low[i]: a bound below
 * its t. */
void filter_run(const filter_ray *ray, const filter_spheres *spheres, size_t first, size_t count,
                uint8_t *out, double *low);

/* The same for one. */
bool filter_sphere(const filter_ray *ray, vec3_f64 center, double radius, double *low);

typedef enum filter_verdict { FILTER_MISS, FILTER_DOUBT, FILTER_HIT } filter_verdict;

/* FILTER_HIT: certainly met in (t_near, t_far); [*low, *high] then holds t. FILTER_DOUBT: *low bounds t
 * below. */
filter_verdict filter_triangle(const filter_ray *ray, vec3_f64 a, vec3_f64 b, vec3_f64 c, double *low,
                               double *high);

#endif
