#include "scene/kernels.h"

#include "base/kernel.h"

KERNEL_DECLARE(scene_kernels, scene_kernels);

const scene_kernels *scene_kernels_at(unsigned index) {
    static const scene_kernels *const all[] = KERNEL_SETS(scene_kernels);
    return index < kernel_levels() ? all[index] : NULL;
}

const scene_kernels *scene_kernels_best(void) { return scene_kernels_at(kernel_levels() - 1); }
