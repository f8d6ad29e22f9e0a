/* One hit in the coordinates of its object: what the primitive says of the point, whoever found it.
 *
 * Position and (u,v) are computed here from the ray and the primitive alone, so that every tracer, packet
 * width and grouping of rays that finds the same primitive gives the same pixel. */
#ifndef RENDER_LOCAL_HIT_H
#define RENDER_LOCAL_HIT_H

#include "scene/world.h"

typedef struct local_hit {
    vec3_f64 p;    /* on the surface, but for a few roundings of double */
    vec3_f64 n;    /* geometric normal, unit, as the shape defines its outside */
    vec3_f32 ns;   /* shading normal, unit */
    vec3_f32 lift; /* for a viewer outside: off the facet to the round surface its normals stand for (Hanika
                      2021) */
    vec3_f32 lift_inside; /* the same for a viewer inside */
    bool smooth;
    /* A ray that starts farther than this from the surface, its rounded origin taken as it is, and leaves, is
     * not found to meet it again. */
    double beside;
} local_hit;

typedef struct local_ray {
    vec3_f64 org, dir;
    float t_near;
} local_ray;

void local_sphere(const world_sphere *sphere, const local_ray *ray, local_hit *out);
void local_quad(const world_quad *quad, const local_ray *ray, local_hit *out);
/* lift: whether the points for shadow rays are wanted. */
void local_triangle(const fathom_mesh *mesh, uint32_t triangle, const local_ray *ray, bool lift,
                    local_hit *out);
void local_plane(const world_plane *plane, const local_ray *ray, local_hit *out);

#endif
