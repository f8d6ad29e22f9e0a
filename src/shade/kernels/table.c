#include "shade/kernels/kernel.h"

#define TEXT_OF(isa) #isa
#define TEXT(isa) TEXT_OF(isa)

const shade_kernels KERNEL(shade_kernels) = {
    .name = TEXT(KERNEL_ISA),
    .facet_gather = KERNEL(facet_gather),
    .quad_gather = KERNEL(quad_gather),
    .facets = KERNEL(facets),
    .surfaces = KERNEL(surfaces),
    .material_gather = KERNEL(material_gather),
    .light_evaluate = KERNEL(light_evaluate),
    .light_aim = KERNEL(light_aim),
    .bend_rays = KERNEL(bend_rays),
};
