/* Which half of a quad a ray hits: the triangle (0,1,3) of its corners, or (2,3,1). */
#pragma once

#include "math/vec.h"

static inline bool half_has_area(vec3_f64 a, vec3_f64 b, vec3_f64 c) {
    vec3_f64 n = cross_f64(sub_f64(b, a), sub_f64(c, a));
    return (n.x != 0) | (n.y != 0) | (n.z != 0);
}

/* Negative in the second half: the sign of corner 0's weight in the first, d·((v1-o)×(v3-o)) / d·n, in
 * double. Both halves are coplanar up to the rounding of the corners, so next to the diagonal either half is
 * right. */
static inline double half_side(vec3_f64 v0, vec3_f64 v1, vec3_f64 v3, vec3_f64 org, vec3_f64 dir) {
    vec3_f64 normal = cross_f64(sub_f64(v1, v0), sub_f64(v3, v0));
    return dot_f64(dir, cross_f64(sub_f64(v1, org), sub_f64(v3, org))) * dot_f64(dir, normal);
}

/* True when the ray hits the second half. A half without area is never hit. */
static inline bool half_is_second(vec3_f64 v0, vec3_f64 v1, vec3_f64 v2, vec3_f64 v3, vec3_f64 org,
                                  vec3_f64 dir) {
    bool second = half_side(v0, v1, v3, org, dir) < 0;
    return (second && half_has_area(v2, v3, v1)) || !half_has_area(v0, v1, v3);
}
