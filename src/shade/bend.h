/* Mirrored and refracted rays. */
#ifndef SHADE_BEND_H
#define SHADE_BEND_H

#include "shade/surface.h"

/* Rays that leave sixteen points; weight 0 where none does. */
typedef struct bend_block {
    _Alignas(64) lanes3 origin;
    lanes3 direction; /* unit */
    float weight[3][LANES];
} bend_block;

/* Mirror: r = -v + 2(n·v)n, weight k_r. Refraction by Snell's law with eta = 1/ior on entering and ior on
 * leaving, weight k_t; on total internal reflection k_t goes to the mirrored ray, with k_r. With `fresnel`,
 * k_r and k_t are scaled by the unpolarised dielectric reflectance F and 1 - F. Directions that a bent
 * shading normal would send through the surface are taken about the geometric normal. */
void bend_rays(const surface_block *s, const material_block *m, bend_block *mirrored, bend_block *refracted);

#endif
