/* Frames: an origin and three orthonormal axes. */
#pragma once

#include "math/vec.h"

typedef struct frame_f64 {
    vec3_f64 origin, x, y, z;
} frame_f64;

/* z along z_hint, y near y_hint: z = z'/|z'|, x = y'×z/|y'×z|, y = z×x. A y_hint that is zero or (nearly)
 * parallel to z is replaced by the coordinate axis along which z has its smallest component. The result is
 * always right-handed and orthonormal. A zero z_hint counts as (0,0,1). */
frame_f64 frame_from(vec3_f64 origin, vec3_f64 z_hint, vec3_f64 y_hint);
