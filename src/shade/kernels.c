#include "shade/kernels.h"

#include "base/kernel.h"

KERNEL_DECLARE(shade_kernels, shade_kernels);

const shade_kernels *shade_kernels_at(unsigned index) {
    static const shade_kernels *const all[] = KERNEL_SETS(shade_kernels);
    return index < kernel_levels() ? all[index] : NULL;
}

const shade_kernels *shade_kernels_best(void) { return shade_kernels_at(kernel_levels() - 1); }
