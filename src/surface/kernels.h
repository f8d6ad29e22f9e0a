/* Computes surface points from hits, sixteen at once; see base/kernel.h. */
#pragma once

#include "scene/world/world.h"
#include "surface/local.h"
#include "surface/surface.h"

typedef struct surface_kernels {
    /* Gathers sixteen rays, given in the mesh's space, and the triangles of the mesh that they hit, with
     * normals if it has any. Indices and vertices must lie within 2^31 numbers. */
    void (*facet_gather)(const fathom_mesh *mesh, const uint32_t triangle[LANES], const float org[3][LANES],
                         const float dir[3][LANES], facet_block *f, local_block *b);

    /* Same for quads, by the index of the quad: gathers the halves that the rays hit. No quad may be flat. */
    void (*quad_gather)(const world_quad *quads, const uint32_t primitive[LANES], const float org[3][LANES],
                        const float dir[3][LANES], facet_block *f, local_block *b);

    /* Computes points and normals of the lanes that hit triangles; other lanes stay. lifted: also compute
     * `lift`. */
    void (*facets)(const facet_block *f, bool lifted, local_block *b);

    /* Transforms world rays to the space of an instance that does not move, and the hits of these lanes
     * (bits) back to the world. */
    void (*rays_to_object)(const world_instance *instance, local_block *b);
    void (*hits_to_world)(const world_instance *instance, uint32_t lanes, local_block *b);

    /* Computes surface points from hits in world coordinates; does not set material and count. automatic:
     * rays start off the surface by the point's error; else on it. */
    void (*surfaces)(const local_block *b, bool automatic, surface_block *s);

    /* Origins of rays to lights in these directions: on the viewer's side, at `lift` if the light is below
     * the facet's horizon; on the other side in lanes whose `behind` is all ones. */
    void (*starts)(const surface_block *s, const lanes3 direction, const uint32_t behind[LANES],
                   float (*origin)[LANES]);
} surface_kernels;

const surface_kernels *surface_kernels_best(void);
