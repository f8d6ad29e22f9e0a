/* Shared by the sources in this folder; see base/kernel.h. */
#ifndef INTEGRATE_KERNELS_KERNEL_H
#define INTEGRATE_KERNELS_KERNEL_H

#include "base/kernel.h"

void KERNEL(append)(const void *from, unsigned rows, uint32_t lanes, void *to, unsigned at);

#endif
