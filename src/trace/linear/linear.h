/* Linear search: the block of rays as the hand-written intersectors take it, and the forms that can be
 * chosen. */
#ifndef TRACE_LINEAR_H
#define TRACE_LINEAR_H

#include "reference/reference.h"
#include "trace/trace.h"

/* Up to 16 rays in the space of the geometry at hand. Lanes that are not in use hold zeros. */
typedef struct linear_rays {
    vec3_f32 org[TRACE_WIDTH], dir[TRACE_WIDTH];
    float t_min[TRACE_WIDTH], t_max[TRACE_WIDTH];
    /* What the watertight test takes, as it is and lane by lane: the origin turned, the shear. */
    triangle_ray_f32 ray[TRACE_WIDTH];
    float ox[TRACE_WIDTH], oy[TRACE_WIDTH], oz[TRACE_WIDTH], sx[TRACE_WIDTH], sy[TRACE_WIDTH];
    unsigned axis_lanes[3]; /* bit i: lane i has this axis */
} linear_rays;

/* One precision and form. Each call tests the lanes whose bits are set against one primitive and returns the
 * bits of those that meet it, with their hits. */
typedef struct linear_form {
    const char *name;
    unsigned (*sphere)(const linear_rays *rays, unsigned lanes, const world_sphere *sphere,
                       reference_hit_f32 *hits);
    unsigned (*quad)(const linear_rays *rays, unsigned lanes, const world_quad *quad,
                     reference_hit_f32 *hits);
    unsigned (*triangle)(const linear_rays *rays, unsigned lanes, const vec3_f32 v[3],
                         reference_hit_f32 *hits);
} linear_form;

extern const linear_form linear_robust_f32;

/* Fills what follows from org and dir. */
void linear_rays_prepare(linear_rays *rays);

#endif
