/* Points of a round lens, and the rays through them, shared by single rays and blocks. */
#pragma once

#include "camera/camera.h"

#include <math.h>

/* Sine and cosine by Taylor's series. For |t| <= pi / 4 the terms left out are below 5e-17. */
static inline double lens_sin(double t) {
    const double s = t * t;
    double sum = -1.0 / 1307674368000;
    sum = sum * s + 1.0 / 6227020800;
    sum = sum * s - 1.0 / 39916800;
    sum = sum * s + 1.0 / 362880;
    sum = sum * s - 1.0 / 5040;
    sum = sum * s + 1.0 / 120;
    sum = sum * s - 1.0 / 6;
    return t + t * s * sum;
}

static inline double lens_cos(double t) {
    const double s = t * t;
    double sum = 1.0 / 20922789888000;
    sum = sum * s - 1.0 / 87178291200;
    sum = sum * s + 1.0 / 479001600;
    sum = sum * s - 1.0 / 3628800;
    sum = sum * s + 1.0 / 40320;
    sum = sum * s - 1.0 / 720;
    sum = sum * s + 1.0 / 24;
    sum = sum * s - 0.5;
    return 1 + s * sum;
}

/* Maps the square to the disc by rings of equal area (Shirley and Chiu 1997). */
static inline void lens_disc(double u, double v, double *x, double *y) {
    const double a = 2 * u - 1, b = 2 * v - 1;
    const bool wide = fabs(a) > fabs(b);
    const double r = wide ? a : b, other = wide ? b : a;
    const double angle = 0.78539816339744831 * (other / (r != 0 ? r : 1));
    const double along = r * lens_cos(angle), aside = r * lens_sin(angle);
    *x = wide ? along : aside, *y = wide ? aside : along;
}

/* The ray from the point (x, y) of a lens of radius 1 to where the pinhole ray along d meets the plane of
 * focus. */
static inline void lens_ray(const shade_camera *c, double x, double y, vec3_f64 d, vec3_f64 *from_eye,
                            vec3_f64 *dir) {
    const vec3_f64 focus = scale_f64(c->focus_distance / dot_f64(d, c->view), d);
    *from_eye = madd_f64(scale_f64(c->lens_radius * x, c->right), c->lens_radius * y, c->up);
    *dir = normalize_f64(sub_f64(focus, *from_eye));
}
