/* From hits to surface points, sixteen at once; see base/kernel.h. */
#ifndef SURFACE_KERNELS_H
#define SURFACE_KERNELS_H

#include "scene/world/world.h"
#include "surface/local.h"
#include "surface/surface.h"

typedef struct surface_kernels {
    /* Sixteen rays, given in the mesh's space, and the triangles of the mesh that they met, with normals
     * where it has any. Indices and vertices must lie within 2^31 numbers. */
    void (*facet_gather)(const fathom_mesh *mesh, const uint32_t triangle[LANES], const float org[3][LANES],
                         const float dir[3][LANES], facet_block *f, local_block *b);

    /* The same for the halves that they met of quads, none of them flat, by the index of the quad. */
    void (*quad_gather)(const world_quad *quads, const uint32_t primitive[LANES], const float org[3][LANES],
                        const float dir[3][LANES], facet_block *f, local_block *b);

    /* Points and normals of the lanes that met triangles; the other lanes stay. lifted: whether the points
     * for shadow rays are wanted. */
    void (*facets)(const facet_block *f, bool lifted, local_block *b);

    /* Rays of the world to the space of an instance that rests, and hits of these lanes, as bits, from it. */
    void (*rays_to_object)(const world_instance *instance, local_block *b);
    void (*hits_to_world)(const world_instance *instance, uint32_t lanes, local_block *b);

    /* Hits, in the world's coordinates by now, to points without material and count. automatic: rays begin
     * off the surface by the point's error; else on it. */
    void (*surfaces)(const local_block *b, bool automatic, surface_block *s);

    /* Where rays to lights begin: on the viewer's side, lifted off the facet, or, in lanes whose `behind` is
     * all ones, on the other. */
    void (*starts)(const surface_block *s, const uint32_t behind[LANES], float (*origin)[LANES]);
} surface_kernels;

const surface_kernels *surface_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const surface_kernels *surface_kernels_at(unsigned index);

#endif
