/* What the sources in this folder share. Each is compiled once for every instruction set, KERNEL_ISA. */
#ifndef SHADE_KERNELS_KERNEL_H
#define SHADE_KERNELS_KERNEL_H

#include "shade/kernels.h"

#ifndef KERNEL_ISA
#define KERNEL_ISA plain
#endif
#define KERNEL_JOIN(name, isa) name##_##isa
#define KERNEL_NAME(name, isa) KERNEL_JOIN(name, isa)
#define KERNEL(name) KERNEL_NAME(name, KERNEL_ISA)

void KERNEL(camera_directions)(const shade_camera *camera, const double x[LANES], const double y[LANES],
                               lanes3 out);
void KERNEL(material_gather)(const scene_named_material *table, const surface_block *s, material_block *out);
void KERNEL(light_evaluate)(const shade_light *light, const surface_block *s, const material_block *m,
                            bool specular, light_block *out);
void KERNEL(bend_rays)(const surface_block *s, const material_block *m, bend_block *mirrored,
                       bend_block *refracted);

#endif
