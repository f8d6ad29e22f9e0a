/* Placements that change with time.
 *
 * A placement is taken apart into M = T R S: a translation, a rotation, and a stretch S that is an upper
 * triangle, as Gram and Schmidt find it from the columns; S mirrors where M does. Between two keys T and S
 * move linearly, R on the shortest arc of unit quaternions (Shoemake 1985). */
#ifndef SCENE_MOTION_H
#define SCENE_MOTION_H

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
/* The arc from a to b at u in [0, 1]. */
motion_parts motion_between(const motion_parts *a, const motion_parts *b, double u);
/* The same with the rotation on the chord, made unit: rigid too, and for arcs of a few degrees next to
 * evenly fast. It is what Embree does with such. */
motion_parts motion_on_chord(const motion_parts *a, const motion_parts *b, double u);
/* The cosine of half the angle between two rotations, >= 0. */
double motion_turn_cosine(const motion_parts *a, const motion_parts *b);

/* ---- keys ---- */

/* The key before `time` and how far it is to the next: key k at u = 0, or between k and k + 1. */
uint32_t motion_key(const double *times, uint32_t count, double time, double *u);

/* The place of an instance at a time: the very matrix of a key where it rests there. */
affine_f64 motion_place(const fathom_instance *instance, double time);
/* True when the instance moves in the camera's shutter time. */
bool motion_is_moving(const fathom_instance *instance, const double shutter[2]);
/* The bounds of an instance's group, `inside`, at the shutter's ends and at the keys between. */
scene_bounds motion_bounds(const fathom_instance *instance, const double shutter[2],
                           const scene_bounds *inside);

/* The positions, or the normals, of a mesh with keys at a time: `count` numbers. rows: those of all keys. */
void motion_rows(const fathom_mesh *mesh, const float *rows, size_t count, double time, float *out);

/* The camera at a time, without keys. */
fathom_camera motion_camera(const fathom_camera *camera, double time);
bool motion_camera_moves(const fathom_camera *camera);

/* Checks the times of keys; `numbers` of them are all to be finite, unless NULL. */
fathom_status motion_check_keys(fathom_context *context, const double *times, uint32_t count,
                                const double *numbers, size_t number_count);
/* Copies of both, owned by the scene. */
fathom_status motion_copy_keys(fathom_scene *scene, uint32_t count, size_t numbers_each, const double **times,
                               const double **numbers);

#endif
