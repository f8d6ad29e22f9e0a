/* From what a tracer found to the surface point that shading sees, and from which rays leave. */
#ifndef RENDER_SURFACE_POINT_H
#define RENDER_SURFACE_POINT_H

#include "render/local_hit.h"
#include "shade/surface.h"
#include "trace/trace.h"

/* A ray, and what it met. */
typedef struct ray_hit {
    vec3_f32 org, dir;
    float t_near;
    uint32_t geometry, primitive, instance; /* as in trace_hits */
} ray_hit;

ray_hit ray_hit_load(const trace_block *block, size_t lane);

/* The point in the world's coordinates. lift: whether the points for shadow rays are wanted. */
void surface_point(const world *w, const ray_hit *ray, bool lift, local_hit *out);

/* Fills a lane but for weight, slot and material. automatic: rays begin off the surface by the point's error;
 * else on it. */
void surface_set(surface_block *s, size_t lane, const ray_hit *ray, const local_hit *hit, bool automatic);

#endif
