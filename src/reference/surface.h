/* Frames on shapes. */
#ifndef REFERENCE_SURFACE_H
#define REFERENCE_SURFACE_H

#include "math/frame.h"

/* The frame at the point p of a sphere: z is the outward normal n, with n = (sin θ cos φ, sin θ sin φ, cos
 * θ); x = (-sin φ, cos φ, 0) along growing φ, y = n×x = (-cos θ cos φ, -cos θ sin φ, sin θ) against growing
 * θ. Orthonormal and right-handed everywhere: at the poles φ counts as 0. p need not lie on the sphere
 * exactly; at the centre n is +z. */
static inline frame_f64 sphere_frame_f64(vec3_f64 center, vec3_f64 p) {
    vec3_f64 n = normalize_f64(sub_f64(p, center));
    if (!(dot_f64(n, n) > 0)) n = vec_f64(0, 0, 1);
    double r = length_f64(vec_f64(n.x, n.y, 0));
    vec3_f64 x = r > 0 ? vec_f64(-n.y / r, n.x / r, 0) : vec_f64(0, 1, 0);
    frame_f64 frame = {p, x, cross_f64(n, x), n};
    return frame;
}

#endif
