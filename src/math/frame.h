/* Frames: an origin and three orthonormal axes. */
#pragma once

#include "math/affine.h"

typedef struct frame_f64 {
    vec3_f64 origin, x, y, z;
} frame_f64;

/* z along z_hint, y near y_hint: z = z'/|z'|, x = y'×z/|y'×z|, y = z×x. A y_hint that is zero or (nearly)
 * parallel to z is replaced by the coordinate axis along which z has its smallest component. The result is
 * always right-handed and orthonormal. A zero z_hint counts as (0,0,1). */
frame_f64 frame_from(vec3_f64 origin, vec3_f64 z_hint, vec3_f64 y_hint);

/* The map from the frame to the space that it lies in. */
static inline affine_f64 frame_affine(const frame_f64 *f) {
    return (affine_f64){{{f->x.x, f->y.x, f->z.x, f->origin.x},
                         {f->x.y, f->y.y, f->z.y, f->origin.y},
                         {f->x.z, f->y.z, f->z.z, f->origin.z}}};
}
