/* Rejects certain misses in double precision.
 *
 * u = 2^-53. org_error and dir_error bound the Euclidean length of the rounding error of a ray in object
 * space (0 outside instances); the primitives' floats are exact. Nothing here overflows: the largest product
 * has degree 4 in numbers of at most 2^258. Products of very small numbers may lose all digits: FILTER_LEAST
 * covers this. A NaN rejects nothing, because a test rejects only if a comparison is true. */
#pragma once

#include "verify/exact/oracle.h"

#define FILTER_LEAST 1e-150

typedef struct filter_ray {
    vec3_f64 org, dir;
    double org_error, dir_error;
    double length, largest; /* of dir: |dir|, and its largest component */
    double inverse;         /* 1 / dir·dir */
    double widen;           /* relative error of a quotient by dir·dir */
    double t_near, t_far;
    bool vague; /* the direction is too inaccurate: nothing is rejected */
} filter_ray;

filter_ray filter_ray_of(const oracle_ray *ray, const world_instance *instance);

/* Bounding spheres of runs of primitives, as arrays. */
typedef struct filter_spheres {
    double *x, *y, *z, *radius;
} filter_spheres;

/* Sets out[i] = 1 if the ray may hit something in sphere first + i within (t_near, t_far), else 0; low[i]:
 * lower bound of its t. */
void filter_run(const filter_ray *ray, const filter_spheres *spheres, size_t first, size_t count,
                uint8_t *out, double *low);

/* Same for one sphere. */
bool filter_sphere(const filter_ray *ray, vec3_f64 center, double radius, double *low);

typedef enum filter_verdict { FILTER_MISS, FILTER_DOUBT, FILTER_HIT } filter_verdict;

/* FILTER_HIT: a certain hit in (t_near, t_far), with t in [*low, *high]. FILTER_DOUBT: *low is a lower bound
 * of t. */
filter_verdict filter_triangle(const filter_ray *ray, vec3_f64 a, vec3_f64 b, vec3_f64 c, double *low,
                               double *high);
