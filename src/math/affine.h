/* Affine maps p' = M p + T, as 3 rows of 4. */
#pragma once

#include "math/vec.h"
#include <stdbool.h>

typedef struct affine_f64 {
    double m[3][4];
} affine_f64;

affine_f64 affine_identity(void);
/* From 3 rows of 4. */
void affine_load(affine_f64 *out, const double rows[12]);
static inline affine_f64 affine_widen(const float rows[3][4]) {
    affine_f64 out;
    for (int i = 0; i < 12; ++i) out.m[i / 4][i % 4] = (double)rows[i / 4][i % 4];
    return out;
}
/* From the first three rows of a matrix of 16 numbers, column by column, as in glTF. */
static inline affine_f64 affine_of_columns(const double m[16]) {
    affine_f64 out;
    for (int i = 0; i < 12; ++i) out.m[i / 4][i % 4] = m[i % 4 * 4 + i / 4];
    return out;
}
affine_f64 affine_translation(vec3_f64 t);
affine_f64 affine_scaling(vec3_f64 s);
/* Rotation by a quaternion (x, y, z, w), which need not be unit but must not be zero. */
affine_f64 affine_rotation(const double quaternion[4]);
/* Rotation by `angle` radians around `axis`, right-handed; the axis need not be unit. */
affine_f64 affine_rotation_axis(vec3_f64 axis, double angle);
/* First b, then a. */
affine_f64 affine_compose(const affine_f64 *a, const affine_f64 *b);
/* False when the map has no finite inverse. */
bool affine_invert(const affine_f64 *a, affine_f64 *out);
bool affine_is_identity(const affine_f64 *a);

static inline vec3_f64 affine_vector(const affine_f64 *a, vec3_f64 v) {
    return (vec3_f64){a->m[0][0] * v.x + a->m[0][1] * v.y + a->m[0][2] * v.z,
                      a->m[1][0] * v.x + a->m[1][1] * v.y + a->m[1][2] * v.z,
                      a->m[2][0] * v.x + a->m[2][1] * v.y + a->m[2][2] * v.z};
}
static inline vec3_f64 affine_point(const affine_f64 *a, vec3_f64 p) {
    return add_f64(affine_vector(a, p), (vec3_f64){a->m[0][3], a->m[1][3], a->m[2][3]});
}
/* The linear part changes volumes by this factor; below 0, it mirrors. */
static inline double affine_determinant(const affine_f64 *a) {
    return dot_f64(load_f64(a->m[0]), cross_f64(load_f64(a->m[1]), load_f64(a->m[2])));
}
/* Multiplies by the transpose of the linear part. With the inverse map, this transforms normals (without
 * normalising them). */
static inline vec3_f64 affine_transposed_vector(const affine_f64 *a, vec3_f64 v) {
    return (vec3_f64){a->m[0][0] * v.x + a->m[1][0] * v.y + a->m[2][0] * v.z,
                      a->m[0][1] * v.x + a->m[1][1] * v.y + a->m[2][1] * v.z,
                      a->m[0][2] * v.x + a->m[1][2] * v.y + a->m[2][2] * v.z};
}
