#include "math/frame.h"

/* The coordinate axis along which v has its smallest component. Its cross product with v has a length of at
 * least sqrt(2/3) |v|. */
static vec3_f64 axis_least_along(vec3_f64 v) {
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    if (x <= y && x <= z) return (vec3_f64){1, 0, 0};
    return y <= z ? (vec3_f64){0, 1, 0} : (vec3_f64){0, 0, 1};
}

frame_f64 frame_from(vec3_f64 origin, vec3_f64 z_hint, vec3_f64 y_hint) {
    frame_f64 f = {.origin = origin, .z = normalize_f64(z_hint)};
    if (length_f64(f.z) == 0) f.z = (vec3_f64){0, 0, 1};
    vec3_f64 side = cross_f64(normalize_f64(y_hint), f.z);
    /* Both factors are unit vectors, so each product has a rounding error of 2^-53. If the length is below
     * 2^-26, fewer than half of the digits of the direction are correct. */
    if (!(length_f64(side) > 0x1p-26)) side = cross_f64(axis_least_along(f.z), f.z);
    f.x = normalize_f64(side);
    f.y = cross_f64(f.z, f.x);
    return f;
}
