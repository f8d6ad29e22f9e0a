/* From the space of an instance's objects to the world's and back, in double. Inline: lanes one by one and
 * the kernel of sixteen have the same bits.
 *
 * With u = 2^-24, in an instance the start of a ray is carried to object space, o_i = Σ A_ij s_j + T_i, and
 * rounded there. Our own tracers do that with A and T = to_object as given and one rounding, u |o_i|. Embree
 * inverts to_world in float: its A is off by E_ij (to_object_error), and its T = -A t, with t the translation
 * of to_world, by that and by three roundings of its products; three more enter when the start is carried. As
 * A s + T = A (s - t), E counts by |s - t|: in all Σ_j E_ij |s_j - t_j| + 6 u Σ_j |A_ij| (|s_j| + |t_j|) on
 * axis i. A distance e along the object's normal n is e / |Aᵀn| in the world, whose normal is Aᵀn / |Aᵀn|. */
#ifndef SURFACE_PLACED_H
#define SURFACE_PLACED_H

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

/* Mᵀ v. An object's normal in the world, where M is to_object, not unit: a distance e along the unit normal
 * is e over its length there. */
static inline vec3_f64 placed_normal(const float m[3][4], vec3_f64 v) {
    return (vec3_f64){(double)m[0][0] * v.x + (double)m[1][0] * v.y + (double)m[2][0] * v.z,
                      (double)m[0][1] * v.x + (double)m[1][1] * v.y + (double)m[2][1] * v.z,
                      (double)m[0][2] * v.x + (double)m[1][2] * v.y + (double)m[2][2] * v.z};
}

static inline vec3_f64 placed_absolute(vec3_f64 v) { return (vec3_f64){fabs(v.x), fabs(v.y), fabs(v.z)}; }

/* The most that a tracer errs along the object's unit normal n when it carries a point of the world to object
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

/* As a lane of local_block. */
typedef struct placed_hit {
    vec3_f64 p, n;
    double self_hit;
    vec3_f32 ns, lift;
} placed_hit;

/* Object to world: to the point that to_object, as it was rounded, carries to the object's: to_world is its
 * inverse but for some u, so what is left after one step of Newton's is of the order u². */
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

#endif
