/* Camera rays of a pinhole, a thin lens or an orthographic camera. */
#pragma once

#include "math/inverse_root.h"
#include "math/lanes.h"
#include "scene/scene.h"

#include "trace/trace.h"

/* d(x, y) = corner + x across + y down, x and y in pixels from the image's top left; not normalised. For an
 * orthographic camera it is the ray's origin relative to the eye. */
typedef struct shade_camera {
    vec3_f32 eye;       /* in world coordinates */
    vec3_f64 exact_eye; /* before it was rounded to float */
    vec3_f64 corner, across, down;
    vec3_f64 view;                      /* unit, viewing direction */
    vec3_f64 right, up;                 /* unit */
    double lens_radius, focus_distance; /* a radius of 0: a pinhole */
    uint32_t blades;                    /* 0: a circular lens */
    double blade_rotation;
    bool parallel; /* orthographic: all rays have the direction `view` */
    bool clips;    /* rays see only what lies between two planes at these distances along `view` */
    double near_clip, far_clip; /* INFINITY: no far plane */
} shade_camera;

/* Width and height of the image plane at distance 1, or of an orthographic view. */
void camera_extent(const fathom_camera *camera, uint32_t width, uint32_t height, double *w, double *h);

void camera_prepare(const fathom_camera *camera, uint32_t width, uint32_t height, vec3_f64 origin,
                    shade_camera *out);

/* The direction through image position (x, y): Q(u,v) - O of the pinhole camera, v counted from the
 * bottom. */
static inline vec3_f64 camera_towards(const shade_camera *c, double x, double y) {
    return (vec3_f64){c->corner.x + x * c->across.x + y * c->down.x,
                      c->corner.y + x * c->across.y + y * c->down.y,
                      c->corner.z + x * c->across.z + y * c->down.z};
}

/* The same as a unit direction. */
static inline vec3_f32 camera_direction(const shade_camera *c, double x, double y) {
    vec3_f64 d = camera_towards(c, x, y);
    return narrow(scale_f64(inverse_root(dot_f64(d, d)), d));
}

/* The ray through image position (x, y). */
static inline void camera_ray(const shade_camera *c, double x, double y, vec3_f32 *org, vec3_f32 *dir) {
    *org = c->parallel ? narrow(add_f64(widen(c->eye), camera_towards(c, x, y))) : c->eye;
    *dir = c->parallel ? narrow(c->view) : camera_direction(c, x, y);
}

/* The distance along a ray from `from_eye` to the plane at `depth` along the view axis. */
static inline double camera_way_to(const shade_camera *c, double depth, vec3_f64 from_eye, vec3_f64 dir) {
    return (depth - dot_f64(from_eye, c->view)) / dot_f64(dir, c->view);
}

/* The image position of a point given relative to the eye. False: it is behind the camera. */
static inline bool camera_place(const shade_camera *c, vec3_f64 from_eye, double *x, double *y) {
    const double depth = dot_f64(from_eye, c->view);
    if (!(depth > 0)) return false;
    const vec3_f64 on = sub_f64(scale_f64(c->parallel ? 1 : 1 / depth, from_eye), c->corner);
    *x = dot_f64(on, c->across) / dot_f64(c->across, c->across);
    *y = dot_f64(on, c->down) / dot_f64(c->down, c->down);
    return true;
}

/* Positions of samples within the pixels of a 4 × 4 square, row by row: [0,1) from the top left. */
typedef struct square_samples {
    _Alignas(64) double x[LANES], y[LANES];
    bool alike; /* all pixels have the same sample position: only the first is set */
} square_samples;

/* A uniform point of the lens: x along `right` and y along `up`, as parts of the radius. u, v: two numbers in
 * [0,1). */
void camera_lens_point(const shade_camera *camera, double u, double v, double *x, double *y);

/* Converts a lane's pinhole ray to a thin-lens ray: from a point on the lens to the point where the pinhole
 * ray intersects the plane of focus. */
void camera_lane_through_lens(const shade_camera *camera, double u, double v, trace_rays *rays, uint32_t i);

/* The ray through image position (x, y) and the lens, in double: for cameras so far away that rounding their
 * rays to float where they stand would show. dir is unit. u, v: as above; a pinhole ignores them. */
void camera_exact_ray(const shade_camera *camera, double x, double y, double u, double v, vec3_f64 *org,
                      vec3_f64 *dir);

typedef struct camera_kernels {
    /* Rays through a square of 4 × 4 pixels, whose first pixel is (left, top), with t_far = infinity. */
    void (*rays)(const shade_camera *camera, float t_near, uint32_t left, uint32_t top,
                 const square_samples *at, trace_rays *out);
    /* camera_lane_through_lens() for all lanes. */
    void (*lens)(const shade_camera *camera, const double u[LANES], const double v[LANES], trace_rays *rays);
} camera_kernels;

const camera_kernels *camera_kernels_best(void);
