/* What the sources in this folder share; see base/kernel.h. */
#ifndef SHADE_KERNELS_KERNEL_H
#define SHADE_KERNELS_KERNEL_H

#include "base/kernel.h"
#include "shade/kernels.h"

void KERNEL(facet_gather)(const fathom_mesh *mesh, const uint32_t triangle[LANES], const float org[3][LANES],
                          const float dir[3][LANES], facet_block *restrict f, local_block *restrict b);
void KERNEL(quad_gather)(const world_quad *quads, const uint32_t primitive[LANES], const float org[3][LANES],
                         const float dir[3][LANES], facet_block *restrict f, local_block *restrict b);
void KERNEL(facets)(const facet_block *f, bool lifted, local_block *restrict b);
void KERNEL(surfaces)(const local_block *b, bool automatic, surface_block *restrict s);
void KERNEL(material_gather)(const scene_named_material *table, const surface_block *s,
                             material_block *restrict out);
void KERNEL(light_evaluate)(const shade_light *light, const surface_block *s, const material_block *m,
                            light_block *restrict out);
void KERNEL(light_aim)(const shade_light *light, light_block *b);
void KERNEL(bend_rays)(const surface_block *s, const material_block *m, bend_block *restrict mirrored,
                       bend_block *restrict refracted);

#endif
