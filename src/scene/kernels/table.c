#include "scene/kernels/kernel.h"

#define TEXT_OF(isa) #isa
#define TEXT(isa) TEXT_OF(isa)

const scene_kernels KERNEL(scene_kernels) = {
    .name = TEXT(KERNEL_ISA),
    .vectors = KERNEL(vectors),
    .indices = KERNEL(indices),
    .boundary = KERNEL(boundary),
    .areas = KERNEL(areas),
};
