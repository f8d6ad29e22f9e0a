/* What the sources in this folder share. Each is compiled once for every instruction set, KERNEL_ISA. */
#ifndef SHADE_KERNELS_KERNEL_H
#define SHADE_KERNELS_KERNEL_H

#include "shade/kernels.h"

#include <string.h>

#ifndef KERNEL_ISA
#define KERNEL_ISA plain
#endif
#define KERNEL_JOIN(name, isa) name##_##isa
#define KERNEL_NAME(name, isa) KERNEL_JOIN(name, isa)
#define KERNEL(name) KERNEL_NAME(name, KERNEL_ISA)

/* Loops over lanes keep to forms that gcc vectorises: no branch, no load that depends on a condition, outputs
 * that alias nothing, no choice of floats by a comparison of doubles. */

/* mask is all ones or 0: a or b, both of them read. */
static inline float chosen(uint32_t mask, float a, float b) {
    uint32_t x, y;
    memcpy(&x, &a, sizeof x), memcpy(&y, &b, sizeof y);
    x = (x & mask) | (y & ~mask);
    memcpy(&a, &x, sizeof a);
    return a;
}

void KERNEL(camera_directions)(const shade_camera *camera, const double x[LANES], const double y[LANES],
                               lanes3 out);
void KERNEL(facets)(const facet_block *f, bool lifted, local_block *restrict b);
void KERNEL(surfaces)(const local_block *b, bool automatic, surface_block *restrict s);
void KERNEL(material_gather)(const scene_named_material *table, const surface_block *s,
                             material_block *restrict out);
void KERNEL(light_evaluate)(const shade_light *light, const surface_block *s, const material_block *m,
                            bool specular, light_block *restrict out);
void KERNEL(bend_rays)(const surface_block *s, const material_block *m, bend_block *restrict mirrored,
                       bend_block *restrict refracted);

#endif
