/* One hit in the coordinates of its object, where there is no kernel for sixteen: see surface/local.h. */
#ifndef SURFACE_LOCAL_HIT_H
#define SURFACE_LOCAL_HIT_H

#include "scene/world/world.h"

/* As a lane of local_block. */
typedef struct local_hit {
    vec3_f64 p, n;
    vec3_f32 ns;
    double self_hit;
} local_hit;

typedef struct local_ray {
    vec3_f64 org, dir;
    float t_near;
} local_ray;

void local_sphere(const world_sphere *sphere, const local_ray *ray, local_hit *out);
void local_plane(const world_plane *plane, const local_ray *ray, local_hit *out);

#endif
