/* From what a tracer found to the surface points that shading sees, and from which rays leave. Sixteen hits
 * are gathered, then computed together. */
#ifndef RENDER_SURFACE_POINT_H
#define RENDER_SURFACE_POINT_H

#include "scene/world.h"
#include "shade/kernels.h"
#include "trace/trace.h"

/* A ray, and what it met. */
typedef struct ray_hit {
    vec3_f32 org, dir;
    float t_near;
    uint32_t geometry, primitive, instance; /* as in trace_hits */
} ray_hit;

ray_hit ray_hit_load(const trace_block *block, size_t lane);

typedef struct surface_gather {
    local_block local;
    facet_block facets;
    ray_hit hits[LANES];
    unsigned count;
    uint32_t instances; /* bit i: lane i is in an instance */
    bool faceted;       /* some lane met a triangle */
    bool normals;       /* shading normals are wanted */
} surface_gather;

/* An empty one. normals: whether shading normals are wanted; always: they are computed where no mesh has any,
 * too, for measuring. */
void surface_gather_begin(surface_gather *g, bool normals, bool always);
/* Adds a hit; there must be room. */
void surface_gather_add(surface_gather *g, const world *w, const ray_hit *ray);
/* Asks the processor's cache for what surface_gather_add() will read of the triangles that a traced block
 * met: where their corners are, then the corners themselves, for which the former must have come. */
void surface_fetch_indices(const world *w, const trace_block *block, unsigned lanes, bool normals);
void surface_fetch_corners(const world *w, const trace_block *block, unsigned lanes, bool normals);
/* Fills the first g->count lanes of s but for weight, slot, material and count, and what g->local says of
 * them in the world's coordinates; all other lanes get something finite. lift: whether the points for shadow
 * rays are wanted. automatic: rays begin off the surface by the point's error; else on it. */
void surface_gather_end(surface_gather *g, const world *w, const shade_kernels *kernels, bool lift,
                        bool automatic, surface_block *s);

#endif
