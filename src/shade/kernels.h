/* Shading over blocks of sixteen; see base/kernel.h. */
#ifndef SHADE_KERNELS_H
#define SHADE_KERNELS_H

#include "scene/world/world.h"
#include "shade/bend.h"
#include "shade/camera.h"
#include "shade/light.h"
#include "shade/local.h"
#include "shade/material.h"

typedef struct shade_kernels {
    const char *name; /* "plain", "avx2", "avx512" */

    /* Sixteen rays, given in the mesh's space, and the triangles of the mesh that they met, with
     * normals where it has any. Indices and vertices must lie within 2^31 numbers. */
    void (*facet_gather)(const fathom_mesh *mesh, const uint32_t triangle[LANES], const float org[3][LANES],
                         const float dir[3][LANES], facet_block *f, local_block *b);

    /* The same for the halves that they met of quads, none of them flat, by the index of the quad. */
    void (*quad_gather)(const world_quad *quads, const uint32_t primitive[LANES], const float org[3][LANES],
                        const float dir[3][LANES], facet_block *f, local_block *b);

    /* Points and normals of the lanes that met triangles; the other lanes stay. lifted: whether the points
     * for shadow rays are wanted. */
    void (*facets)(const facet_block *f, bool lifted, local_block *b);

    /* Hits, in the world's coordinates by now, to points but for weight, slot, material and count. automatic:
     * rays begin off the surface by the point's error; else on it. */
    void (*surfaces)(const local_block *b, bool automatic, surface_block *s);

    /* Loads the materials of the block's points. `table` is indexed by material id. */
    void (*material_gather)(const scene_named_material *table, const surface_block *s, material_block *out);

    void (*light_evaluate)(const shade_light *light, const surface_block *s, const material_block *m,
                           light_block *out);

    /* Sets directions and distances of shadow rays by their origins; light_evaluate() does so, too. */
    void (*light_aim)(const shade_light *light, light_block *b);

    /* Mirror: r = -v + 2(n·v)n, weight k_r. Refraction by Snell's law with eta = 1/ior on entering and ior on
     * leaving, weight k_t; on total internal reflection the mirrored ray gets k_t as well. With
     * `fresnel`, k_r and k_t are scaled by the unpolarised dielectric reflectance F and 1 - F; on total
     * internal reflection F is 1, so k_r alone is left. Where a shading normal would send a ray through the
     * surface, the geometric normal replaces it. */
    void (*bend_rays)(const surface_block *s, const material_block *m, bend_block *mirrored,
                      bend_block *refracted);
} shade_kernels;

const shade_kernels *shade_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const shade_kernels *shade_kernels_at(unsigned index);

#endif
