/* VARIANTS(NAME) defines NAME_at(): the variants of these kernels that this processor can run, from the
 * oldest instruction set to the newest; NULL past the last. */
#pragma once

#include "base/kernel.h"

#define VARIANTS(type)                                                                                       \
    KERNEL_DECLARE(type, type);                                                                              \
    static const type *type##_at(unsigned index) {                                                           \
        static const type *const all[] = KERNEL_SETS(type);                                                  \
        return index < kernel_levels() ? all[index] : NULL;                                                  \
    }
