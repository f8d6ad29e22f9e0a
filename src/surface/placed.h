/* Transforms between an instance's object space and world space, in double. Inline, so that single lanes and
 * the 16-lane kernel get the same bits.
 *
 * Errors, with u = 2^-24: the origin s of a ray is transformed to object space, o_i = Σ A_ij s_j + T_i, and
 * rounded there. Our own tracers use A and T of to_object with one rounding, u |o_i|. Embree inverts to_world
 * in float: its A has the error E_ij (to_object_error). Its T = -A t, with t the translation of to_world, has
 * this error and three roundings of its products; transforming s adds three more. Since A s + T = A (s - t),
 * E is multiplied by |s - t|. The sum on axis i is Σ_j E_ij |s_j - t_j| + 6 u Σ_j |A_ij| (|s_j| + |t_j|). A
 * distance e along the object's normal n is e / |Aᵀn| in the world, where the normal is Aᵀn / |Aᵀn|. */
#pragma once

#include "scene/world/world.h"

#include <math.h>

static inline vec3_f64 placed_vector(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[0][1] * v.y + (double)m[0][2] * v.z,
                      (double)m[1][0] * v.x + (double)m[1][1] * v.y + (double)m[1][2] * v.z,
                      (double)m[2][0] * v.x + (double)m[2][1] * v.y + (double)m[2][2] * v.z};
}

static inline vec3_f64 placed_shift(const float m[3][4]) {
    return (vec3_f64){(double)m[0][3], (double)m[1][3], (double)m[2][3]};
}

static inline vec3_f64 placed_point(const float m[3][4], vec3_f64 p) {
    return add_f64(placed_vector(m, p), placed_shift(m));
}

/* Mᵀ v. With M = to_object it transforms an object's normal to world space. The result is not unit: a
 * distance e along the object's unit normal is e divided by its length in the world. */
static inline vec3_f64 placed_normal(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[1][0] * v.y + (double)m[2][0] * v.z,
                      (double)m[0][1] * v.x + (double)m[1][1] * v.y + (double)m[2][1] * v.z,
                      (double)m[0][2] * v.x + (double)m[1][2] * v.y + (double)m[2][2] * v.z};
}

static inline vec3_f64 placed_absolute(vec3_f64 v) { return (vec3_f64){fabs(v.x), fabs(v.y), fabs(v.z)}; }

/* Upper bound of a tracer's error along the object's unit normal n when it transforms a world point to object
 * space. */
static inline double placed_carried_along(const world_instance *instance, vec3_f64 n, vec3_f64 p) {
    const vec3_f64 shift = placed_shift(instance->to_world), from = placed_absolute(sub_f64(p, shift)),
                   sum = add_f64(placed_absolute(p), placed_absolute(shift));
    const double along[3] = {fabs(n.x), fabs(n.y), fabs(n.z)};
    double error = 0;
    for (int i = 0; i < 3; ++i) {
        const float *a = instance->to_object[i], *e = instance->to_object_error[i];
        const double products =
            fabs((double)a[0]) * sum.x + fabs((double)a[1]) * sum.y + fabs((double)a[2]) * sum.z;
        const double map = (double)e[0] * from.x + (double)e[1] * from.y + (double)e[2] * from.z;
        error += along[i] * (map + 6 * 0x1p-24 * products);
    }
    return error;
}

/* One lane of local_block. */
typedef struct placed_hit {
    vec3_f64 p, n;
    double self_hit;
    vec3_f32 ns, lift;
} placed_hit;

/* Object to world. The result is the point that the rounded to_object maps to the object's point: to_world is
 * its inverse up to a few u, so after one Newton step the error is of the order u². */
static inline placed_hit placed_to_world(const world_instance *instance, placed_hit h) {
    const float(*m)[4] = instance->to_world, (*inverse)[4] = instance->to_object;
    const vec3_f64 near = placed_point(m, h.p), n = placed_normal(inverse, h.n),
                   ns = placed_normal(inverse, widen(h.ns)),
                   p = add_f64(near, placed_vector(m, sub_f64(h.p, placed_point(inverse, near))));
    const double length = sqrt(dot_f64(n, n));
    return (placed_hit){.p = p,
                        .n = scale_f64(1 / length, n),
                        .self_hit = (h.self_hit + placed_carried_along(instance, h.n, p)) / length,
                        .ns = narrow(scale_f64(1 / sqrt(dot_f64(ns, ns)), ns)),
                        .lift = narrow(placed_vector(m, widen(h.lift)))};
}
