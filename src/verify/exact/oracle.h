/* The exact oracle: whether a ray meets a primitive, where, and by how much, for the real-number geometry of
 * the very floats that tracers are given.
 *
 * All is computed in whole numbers (exact.h), without any rounding, and rounded once in the end. So every
 * sign is right, and zero is zero.
 *
 * Definitions. A hit has t in the open interval (t_near, t_far), in units of |dir|. Triangles are closed:
 * their edges and vertices belong to them; rays in the triangle's plane miss; triangles without area are
 * never met. A quad is the triangles (0,1,3) and (2,3,1). A sphere is met where its discriminant is at least
 * 0, at the smaller root in the interval, else the larger; its radius must be above 0. A plane holds the
 * points with (P - point) · normal = 0; parallel rays miss. In an instance the ray is carried by to_object,
 * row by row, without rounding. Input that is not finite is never met (but t_near and t_far may be infinite),
 * nor is anything by a ray without direction.
 *
 * Nothing allocates, fails, keeps state or depends on the thread's floating-point mode. */
#ifndef PARITY_ORACLE_H
#define PARITY_ORACLE_H

#include "reference/vec_f128.h"
#include "scene/world/world.h"

typedef struct oracle_ray {
    vec3_f32 org, dir;
    float t_near, t_far;
} oracle_ray;

typedef enum oracle_shape { ORACLE_SPHERE, ORACLE_TRIANGLE, ORACLE_QUAD, ORACLE_PLANE } oracle_shape;

typedef struct oracle_primitive {
    oracle_shape shape;
    vec3_f32 v[4]; /* corners; of a sphere: v[0] is the centre; of a plane: v[0] a point, v[1] the normal */
    float radius;  /* of a sphere */
    vec3_f32 rest; /* of a sphere: is added to its centre, and radius_rest to its radius (world_sphere) */
    float radius_rest;
    const world_instance *instance; /* NULL: none. Borrowed */
} oracle_primitive;

/* A sphere's centre and radius in double, exact to the last digit. */
static inline vec3_f64 oracle_center(const oracle_primitive *p) {
    return add_f64(widen(p->v[0]), widen(p->rest));
}
static inline double oracle_radius(const oracle_primitive *p) {
    return (double)p->radius + (double)p->radius_rest;
}

/* Numbers are within 2^-100 of themselves, and exactly zero where the true number is. */
typedef struct oracle_answer {
    bool hit;
    bool parallel; /* the ray lies along the plane, or there is no such shape or ray: nothing below is set */
    bool line;     /* the whole line meets the shape, wherever t lies */
    unsigned part; /* quad: the triangle, 0 or 1, of a miss the one that came closer; sphere: 0 the smaller
                      root, 1 the larger */
    real_f128 t;   /* of the hit; for a miss: where the plane is met; the root that was rejected last; of a
                      sphere that the line misses, the closest approach */
    real_f128 other;                 /* sphere with line set: the other root */
    real_f128 above_near, below_far; /* t - t_near, t_far - t: both positive for a hit; not set when a
                                        sphere's line is false */
    real_f128
        weight[3]; /* of the triangle's corners A, B, C at t; they add to 1; for a quad, of the part's */
    /* At least 0 exactly where line is true. Triangle: the smallest weight. Quad: of a hit the smaller of the
     * two weights at the outer edges; of a miss the larger of both parts' smallest weights. Sphere: 1 - l²/R²
     * with l the line's distance from the centre. Plane: 1. */
    real_f128 edge;
} oracle_answer;

void oracle_ask(const oracle_ray *ray, const oracle_primitive *primitive, oracle_answer *answer);

/* How far inputs off by a relative u each move the t of an answer whose line is set, to first order: by at
 * most u times this. Infinite where t is not differentiable. Inputs are those given, to_object among them;
 * `inverted`: for a tracer that inverts to_world in its own precision, as Embree does. */
double oracle_condition(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                        bool inverted);

/* A primitive and its answer to one ray. */
typedef struct oracle_pair {
    oracle_primitive primitive;
    oracle_answer answer;
} oracle_pair;

/* -1, 0 or 1 as the t of a is less than, equal to or greater than that of b, exactly. Both must have line
 * set. */
int oracle_compare(const oracle_ray *ray, const oracle_pair *a, const oracle_pair *b);

#endif
