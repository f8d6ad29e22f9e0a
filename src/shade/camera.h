/* The pinhole camera as rays. */
#ifndef SHADE_CAMERA_H
#define SHADE_CAMERA_H

#include "scene/scene.h"

/* d(x, y) = corner + x across + y down, x and y in pixels from the image's top left; not yet unit. */
typedef struct shade_camera {
    vec3_f32 eye; /* in the world's coordinates */
    vec3_f64 corner, across, down;
    vec3_f64 view; /* unit, the way the camera looks */
} shade_camera;

void camera_prepare(const fathom_camera *camera, uint32_t width, uint32_t height, vec3_f64 origin,
                    shade_camera *out);

/* Towards image position (x, y): Q(u,v) - O of the pinhole, v counted from the bottom. */
static inline vec3_f64 camera_towards(const shade_camera *c, double x, double y) {
    return (vec3_f64){c->corner.x + x * c->across.x + y * c->down.x,
                      c->corner.y + x * c->across.y + y * c->down.y,
                      c->corner.z + x * c->across.z + y * c->down.z};
}

/* The same as a unit direction. */
vec3_f32 camera_direction(const shade_camera *c, double x, double y);

/* 1 / sqrt(square) where the square is within these: float's root, off by e < 2^-22, and one step of
 * Newton's, which leaves 3/2 e^2 < 2^-43. Directions become float afterwards, so that is as good as all of
 * double's digits, in a third of the time. */
#define CAMERA_LEAST_SQUARE 0x1p-100f
#define CAMERA_MOST_SQUARE 0x1p100f
static inline double camera_inverse_length(double square) {
    double rough = (double)(1 / sqrtf((float)square));
    return rough * (1.5 - 0.5 * square * rough * rough);
}

#endif
