/* Families of rays that test the weak points of intersectors. Ray `index` of a family depends only on the
 * world, the seed and the index. Every ray is valid: no origin coordinate above RAYS_LARGEST; the direction
 * is not zero and has no coordinate above RAYS_LONGEST; 0 <= t_near <= t_far; t_far may be infinite. */
#pragma once

#include "verify/exact/oracle.h"

typedef enum rays_family {
    RAYS_CAMERA,   /* camera rays of the scene */
    RAYS_UNIFORM,  /* from points around the world to points in it */
    RAYS_EDGE,     /* aimed at edges; every second one from inside a closed shape, where every miss is
                      wrong */
    RAYS_VERTEX,   /* aimed at vertices, likewise */
    RAYS_GRAZING,  /* 1 to 1e-6 radians off the surface */
    RAYS_TANGENT,  /* past the silhouette of spheres; along the edges of other shapes */
    RAYS_SURFACE,  /* from a point on a surface, rounded to float */
    RAYS_FAR,      /* from 10 to 1e6 times the world's radius away */
    RAYS_AXIS,     /* one or two components of the direction are 0 or -0 */
    RAYS_SCALED,   /* directions 1e-31 to 1e36 long; t_far is infinite, 1e30 and more, or half or twice the
                      target's t */
    RAYS_INTERVAL, /* intervals around a hit, down to width 0; tiny and huge ones */
    RAYS_TINY,     /* one or two components of the direction are 1e-12 to 1e-36 of the others */
    RAYS_BUNDLE,   /* 16 from nearly one point in nearly one direction, often along an axis */
    RAYS_LATTICE,  /* along axes at corners, edges and eighths of edges, exact if the shape's coordinates have
                      few digits; from corners and planes of boxes; intervals that end at the hit */
    RAYS_ENDS,     /* intervals that end exactly at the hit: compare.c sets their end to the tracer's t */
    RAYS_RENDERED, /* rays of a render, in its own blocks; rays_make() makes none */
    RAYS_FAMILIES
} rays_family;

/* "camera" … */
const char *rays_family_name(rays_family family);

/* The targets for rays in a world. */
typedef struct rays_source rays_source;

/* FATHOM_BAD_INPUT when the world is empty. The world must outlive *out. */
fathom_status rays_create(fathom_context *context, const world *w, rays_source **out);
void rays_destroy(rays_source *source);

/* Sums and differences of such coordinates fit in float. Rays that a tracer itself cannot handle get
 * VERDICT_BEYOND. */
#define RAYS_LARGEST 1e30
#define RAYS_LONGEST 1e37
/* True when the ray is within these limits, also in the space of every instance, so a tracer may get it. */
bool rays_allowed(const rays_source *source, const oracle_ray *ray);
/* Rounds to float, and denormals to 0: tracers flush denormals, the oracle does not, and both must get the
 * same ray. */
float rays_normal(double x);

/* Thread-safe. */
oracle_ray rays_make(const rays_source *source, rays_family family, uint64_t seed, uint64_t index);

/* A ray in double, in world coordinates. rays_make() rounds it, and makes another with new random numbers if
 * it is not allowed. */
typedef struct rays_draft {
    vec3_f64 org, dir;
    double t_near, t_far;
} rays_draft;

/* Random numbers of one ray, and its index in the family. */
typedef struct rays_random {
    uint64_t counter, index;
} rays_random;
typedef rays_draft (*rays_maker)(const void *user, rays_random *random);

/* ---- rays_aim.c: random numbers, and target points on the world's primitives ---- */

rays_random rays_random_of(uint64_t seed, uint64_t family, uint64_t index);
double rays_unit(rays_random *r); /* [0,1) */
double rays_between(rays_random *r, double low, double high);
double rays_power(rays_random *r, double low, double high); /* 10^x, x in [low, high) */
vec3_f64 rays_direction(rays_random *r);                    /* unit, uniform over the sphere */
vec3_f64 rays_in_ball(rays_random *r, vec3_f64 center, double radius);
vec3_f64 rays_perpendicular(rays_random *r, vec3_f64 to); /* unit; `to` need not be */

/* A run of primitives, transformed to world space. */
typedef struct rays_run {
    uint32_t geometry, instance, count;
    vec3_f64 center; /* of its box, in world coordinates */
    double radius;   /* half the box's diagonal */
} rays_run;

struct rays_source {
    const world *world;
    ARRAY(rays_run) runs;  /* planes are the last */
    vec3_f64 center;       /* of a sphere around everything except planes */
    double radius;         /* of the sphere; at least 1e-30. Errors of position are relative to it */
    double stretch, shift; /* maximum scale of lengths and maximum translation by instances; stretch >= 1 */
    rays_maker own;        /* makes the rays of every family; may be NULL */
    const void *own_user;
};

/* A point to aim at. */
typedef struct rays_target {
    const rays_run *run;
    oracle_shape shape;
    vec3_f64 point;     /* on the surface, in world coordinates */
    vec3_f64 normal;    /* unit, of either side */
    vec3_f64 corner[4]; /* triangles and quads */
    unsigned corners;   /* 0 for others */
} rays_target;

rays_target rays_pick(const rays_source *source, rays_random *r);
