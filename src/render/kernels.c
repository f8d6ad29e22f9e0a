#include "render/kernels.h"

#include "base/kernel.h"

KERNEL_DECLARE(render_kernels, render_kernels);

const render_kernels *render_kernels_at(unsigned index) {
    static const render_kernels *const all[] = KERNEL_SETS(render_kernels);
    return index < kernel_levels() ? all[index] : NULL;
}

const render_kernels *render_kernels_best(void) { return render_kernels_at(kernel_levels() - 1); }
