/* The exact oracle: whether and where a ray hits a primitive, and by which margin, in real-number geometry of
 * the same floats that tracers get.
 *
 * It computes in integers (exact.h), without rounding, and rounds once at the end. So all signs are right,
 * and zero is exactly zero.
 *
 * Definitions. A hit has t in the open interval (t_near, t_far), in units of |dir|. Triangles are closed:
 * their edges and vertices belong to them; rays in the triangle's plane miss; triangles without area are
 * never hit. A quad is the triangles (0,1,3) and (2,3,1). A sphere is hit if its discriminant is at least 0,
 * at the smaller root if that is in the interval, else at the larger; its radius must be above 0. A plane
 * consists of the points with (P - point) · normal = 0; parallel rays miss. In an instance, the ray is
 * transformed by to_object, row by row, without rounding. Input that is not finite always misses (but t_near
 * and t_far may be infinite), and so does a zero direction.
 *
 * No function allocates, fails, keeps state or depends on the thread's floating-point mode. */
#pragma once

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
    vec3_f32 rest; /* of a sphere: added to its centre, as radius_rest to its radius (world_sphere) */
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

/* Number of corners: 3 or 4, or 1 for the centre of a sphere and the point of a plane. */
static inline unsigned oracle_corners(const oracle_primitive *p) {
    return p->shape == ORACLE_QUAD ? 4 : p->shape == ORACLE_TRIANGLE ? 3 : 1;
}
/* The corners A, B, C of a triangle, or of a quad's part. */
static inline void oracle_part(const oracle_primitive *p, unsigned part, vec3_f32 out[3]) {
    static const unsigned char of_triangle[3] = {0, 1, 2}, of_quad[2][3] = {{0, 1, 3}, {2, 3, 1}};
    const unsigned char *corner = p->shape == ORACLE_QUAD ? of_quad[part] : of_triangle;
    for (int k = 0; k < 3; ++k) out[k] = p->v[corner[k]];
}

/* Numbers have a relative error of at most 2^-100; they are exactly zero if the true number is. */
typedef struct oracle_answer {
    bool hit;
    bool parallel; /* the ray is parallel to the plane, or the shape or ray is invalid: nothing below is
                      set */
    bool line;     /* the infinite line hits the shape, whatever t is */
    unsigned part; /* quad: the triangle, 0 or 1; for a miss, the closer one. Sphere: 0 for the smaller root,
                      1 for the larger */
    real_f128 t;   /* of the hit. For a miss: of the intersection with the plane; sphere: of the root that was
                      rejected last, or of the closest approach if the line misses */
    real_f128 other;                 /* sphere with line set: the other root */
    real_f128 above_near, below_far; /* t - t_near, t_far - t: both positive for a hit; not set if `line` of a
                                        sphere is false */
    real_f128 weight[3]; /* of the triangle's corners A, B, C at t, with sum 1; for a quad, of its `part` */
    /* Signed margin: at least 0 if and only if `line` is true. Triangle: the smallest weight. Quad: for a
     * hit, the smaller of the two weights at the outer edges, if the ray is not parallel to the other part;
     * for a miss, the larger of both parts' smallest weights. Sphere: 1 - l²/R² with l the line's distance
     * from the centre. Plane: 1. */
    real_f128 edge;
} oracle_answer;

void oracle_ask(const oracle_ray *ray, const oracle_primitive *primitive, oracle_answer *answer);

/* Condition number: if each input has a relative error of u, t changes by at most u times this, to first
 * order. For answers with `line` set. Infinite if t is not differentiable. Inputs are all given numbers,
 * including to_object; `inverted`: for a tracer that inverts to_world in its own precision, as Embree
 * does. */
double oracle_condition(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                        bool inverted);

/* A primitive and its answer for one ray. */
typedef struct oracle_pair {
    oracle_primitive primitive;
    oracle_answer answer;
} oracle_pair;

/* Compares exactly: -1, 0 or 1 if the t of a is less than, equal to or greater than that of b. Both must have
 * `line` set. */
int oracle_compare(const oracle_ray *ray, const oracle_pair *a, const oracle_pair *b);
