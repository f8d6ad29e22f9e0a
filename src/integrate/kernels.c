#include "integrate/kernels.h"

#include "base/kernel.h"
#include "integrate/path/path_kernels.h"

KERNEL_BEST(integrate_kernels)
KERNEL_BEST(path_kernels)
