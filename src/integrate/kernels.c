#include "integrate/kernels.h"

#include "base/kernel.h"

KERNEL_CHOICE(integrate_kernels)
