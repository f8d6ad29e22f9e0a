/* Random numbers and the places on a world's primitives that rays are aimed at. */
#ifndef PARITY_RAYS_AIM_H
#define PARITY_RAYS_AIM_H

#include "verify/search/rays.h"

/* Numbers of one ray. */
typedef struct rays_random {
    uint64_t counter;
} rays_random;

rays_random rays_random_of(uint64_t seed, uint64_t family, uint64_t index);
double rays_unit(rays_random *r); /* [0,1) */
double rays_between(rays_random *r, double low, double high);
double rays_power(rays_random *r, double low, double high); /* 10^x, x in [low, high) */
vec3_f64 rays_direction(rays_random *r);                    /* unit, evenly over the sphere */
vec3_f64 rays_in_ball(rays_random *r, vec3_f64 center, double radius);
vec3_f64 rays_perpendicular(rays_random *r, vec3_f64 to); /* unit; `to` need not be */

/* A run of primitives as placed in the world. */
typedef struct rays_run {
    uint32_t geometry, instance, count;
    vec3_f64 center; /* of its box, in world coordinates */
    double radius;   /* half the box's diagonal */
} rays_run;

struct rays_source {
    const world *world;
    ARRAY(rays_run) runs; /* planes are the last */
    vec3_f64 center;
    double radius;
    double stretch, shift; /* at most, of what instances do to lengths and to the origin; stretch >= 1 */
    rays_maker own;        /* makes the rays of every family; may be NULL */
    const void *own_user;
};

/* A place to aim at. */
typedef struct rays_target {
    const rays_run *run;
    oracle_shape shape;
    vec3_f64 point;     /* on the surface, in world coordinates */
    vec3_f64 normal;    /* unit, of either side */
    vec3_f64 corner[4]; /* triangles and quads */
    unsigned corners;   /* 0 for others */
} rays_target;

rays_target rays_pick(const rays_source *source, rays_random *r);

#endif
