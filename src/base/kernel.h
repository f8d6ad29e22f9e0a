/* Kernels: loops over blocks of sixteen lanes, in folders named `kernels`. Each source is compiled for every
 * instruction set, and the best one of the processor is chosen at run time. All variants give bit-identical
 * results: the compiler may not contract or reorder operations, and each operation rounds as in IEEE 754.
 *
 * Loops over lanes use forms that gcc vectorises: no branches, no conditional loads, no outputs that may
 * alias, no selection of floats by a comparison of doubles. */
#pragma once

#include "base/isa.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifndef KERNEL_ISA
#define KERNEL_ISA plain
#endif
#define KERNEL_JOIN(name, isa) name##_##isa
#define KERNEL_NAME(name, isa) KERNEL_JOIN(name, isa)
#define KERNEL(name) KERNEL_NAME(name, KERNEL_ISA)

/* The kernel tables of a module, from the oldest instruction set to the newest. */
#if defined(__x86_64__)
#define KERNEL_SETS(table)                                                                                   \
    { &table##_plain, &table##_avx2, &table##_avx512 }
#define KERNEL_DECLARE(type, table) extern const type table##_plain, table##_avx2, table##_avx512
#else
#define KERNEL_SETS(table)                                                                                   \
    { &table##_plain }
#define KERNEL_DECLARE(type, table) extern const type table##_plain
#endif

/* Defines NAME_best() for kernel tables of type NAME. The module's header declares it. */
#define KERNEL_BEST(type)                                                                                    \
    KERNEL_DECLARE(type, type);                                                                              \
    const type *type##_best(void) {                                                                          \
        static const type *const all[] = KERNEL_SETS(type);                                                  \
        return all[kernel_levels() - 1];                                                                     \
    }

/* For __attribute__((target(…))) of one function. clang ignores an attribute that names a preferred width. */
#if defined(__clang__)
#define KERNEL_TARGET_AVX512 "avx512f,avx512vl,avx512dq,avx512bw"
#else
#define KERNEL_TARGET_AVX512 "avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512"
#endif

/* The number of variants that may run on this machine, at least 1. */
static inline unsigned kernel_levels(void) {
    return isa_usable(ISA_AVX512) ? 3 : (isa_usable(ISA_AVX2) ? 2 : 1);
}

/* Returns a if all bits of mask are 1, b if all are 0, without a branch; reads both. */
static inline float chosen(uint32_t mask, float a, float b) {
    uint32_t x, y;
    memcpy(&x, &a, sizeof x), memcpy(&y, &b, sizeof y);
    x = (x & mask) | (y & ~mask);
    memcpy(&a, &x, sizeof a);
    return a;
}
