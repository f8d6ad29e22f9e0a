#include "read/mesh/origin.h"

static double rounded_to(double x, double step) { return round(x / step) * step; }

vec3_f64 origin_for(const scene_bounds *bounds) {
    const vec3_f64 zero = {0, 0, 0};
    if (bounds_is_empty(bounds)) return zero;
    vec3_f64 center = bounds_center(bounds), half = scale_f64(0.5, sub_f64(bounds->upper, bounds->lower));
    double extent = fmax(half.x, fmax(half.y, half.z));
    double size = fmax(fabs(center.x), fmax(fabs(center.y), fabs(center.z))) + extent;
    if (!(extent > 0) || !(size > 16 * extent)) return zero;
    /* step = 2^k with e/2 < 2^k <= e; below the range of double's exact integers rounding changes nothing. */
    int exponent;
    frexp(extent, &exponent);
    double step = ldexp(1, exponent - 1);
    return (vec3_f64){rounded_to(center.x, step), rounded_to(center.y, step), rounded_to(center.z, step)};
}
