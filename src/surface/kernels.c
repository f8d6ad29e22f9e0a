#include "surface/kernels.h"

#include "base/kernel.h"

KERNEL_CHOICE(surface_kernels)
