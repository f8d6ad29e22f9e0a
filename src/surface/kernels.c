#include "surface/kernels.h"

#include "base/kernel.h"

KERNEL_BEST(surface_kernels)
