/* Transforms that change with time.
 *
 * A transform is decomposed into M = T R S: a translation, a rotation, and an upper triangular matrix S of
 * scale and shear, found by Gram-Schmidt from the columns. S mirrors if M does. Between two keys, T and S are
 * interpolated linearly, and R on the shortest arc of unit quaternions (Shoemake 1985). */
#pragma once

#include "math/affine.h"
#include "scene/scene.h"

typedef struct motion_parts {
    double scale[3], skew[3]; /* S: its diagonal; its entries xy, xz and yz */
    double turn[4];           /* R: a unit quaternion, the real part first */
    double shift[3];          /* T */
} motion_parts;

/* The map must have an inverse. */
motion_parts motion_take_apart(const affine_f64 *map);
affine_f64 motion_put_together(const motion_parts *parts);
/* The unit quaternion at u in [0, 1] of the shorter arc from a to b, which need not be unit. Any order of
 * the four numbers. If one of both is zero, the other counts. */
void motion_slerp(const double a[4], const double b[4], double u, double out[4]);
/* Interpolates from a to b at u in [0, 1], with the rotation on the arc. */
motion_parts motion_between(const motion_parts *a, const motion_parts *b, double u);
/* The same with the rotation on the chord: the quaternion is interpolated linearly and normalised. This is a
 * rotation too, and for arcs of a few degrees its speed is almost constant. Embree interpolates such arcs
 * this way. */
motion_parts motion_on_chord(const motion_parts *a, const motion_parts *b, double u);
/* The cosine of half the angle between two rotations, >= 0. */
double motion_turn_cosine(const motion_parts *a, const motion_parts *b);

/* ---- keys ---- */

/* The key k before `time`, and the fraction u of the way to key k + 1. u is 0 at a key, before the first and
 * after the last. */
uint32_t motion_key(const double *times, uint32_t count, double time, double *u);

/* True when the rows of the keys that matter while the shutter is open differ: one row for each key. */
bool motion_keys_differ(const double *times, uint32_t count, const double shutter[2], const void *rows,
                        size_t row_bytes);

/* The transform of an instance at a time. It is exactly the matrix of a key if the instance does not move at
 * that time, or if the time is the key's. */
affine_f64 motion_place(const fathom_instance *instance, double time);
/* True when the instance moves while the shutter is open. */
bool motion_is_moving(const fathom_instance *instance, const double shutter[2]);
/* The bounds of an instance on its way while the shutter is open. `inside`: the bounds of its group. */
scene_bounds motion_bounds(const fathom_instance *instance, const double shutter[2],
                           const scene_bounds *inside);

/* Interpolates the positions, or the normals, of a mesh with keys at a time. rows: those of all keys, `count`
 * floats per key. */
void motion_rows(const fathom_mesh *mesh, const float *rows, size_t count, double time, float *out);

/* The camera at a time. The result has no keys. */
fathom_camera motion_camera(const fathom_camera *camera, double time);
bool motion_camera_moves(const fathom_camera *camera);
/* The camera of an image as a whole: when the shutter opens, or halfway without motion blur. The result has
 * no keys. */
fathom_camera motion_camera_shown(const fathom_camera *camera, bool blurred);

/* Checks that the times of keys are finite and ascending. */
fathom_status motion_check_keys(fathom_context *context, const double *times, uint32_t count);
/* Replaces both arrays by copies that the scene owns. `numbers` may be NULL. */
fathom_status motion_copy_keys(fathom_scene *scene, uint32_t count, size_t numbers_each, const double **times,
                               const double **numbers);
