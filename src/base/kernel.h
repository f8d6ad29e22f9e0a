/* Kernels: loops over blocks of sixteen lanes, in folders named `kernels`. Each source is compiled for every
 * instruction set, and the processor's best is chosen at run time. All give the same bits: nothing is
 * contracted or reordered, and each operation rounds as in IEEE 754.
 *
 * Loops over lanes use forms that gcc vectorises: no branch, no conditional load, no aliasing outputs, no
 * choice of floats by a comparison of doubles. */
#ifndef BASE_KERNEL_H
#define BASE_KERNEL_H

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

/* The tables of a module's kernels, from the oldest set. */
#if defined(__x86_64__)
#define KERNEL_SETS(table)                                                                                   \
    { &table##_plain, &table##_avx2, &table##_avx512 }
#define KERNEL_DECLARE(type, table) extern const type table##_plain, table##_avx2, table##_avx512
#else
#define KERNEL_SETS(table)                                                                                   \
    { &table##_plain }
#define KERNEL_DECLARE(type, table) extern const type table##_plain
#endif

/* Defines NAME_best() for tables of type NAME, which their module's header declares. */
#define KERNEL_BEST(type)                                                                                    \
    KERNEL_DECLARE(type, type);                                                                              \
    const type *type##_best(void) {                                                                          \
        static const type *const all[] = KERNEL_SETS(type);                                                  \
        return all[kernel_levels() - 1];                                                                     \
    }

/* The same, and NAME_at(), which tests hold against each other. */
#define KERNEL_CHOICE(type)                                                                                  \
    KERNEL_BEST(type)                                                                                        \
    const type *type##_at(unsigned index) {                                                                  \
        static const type *const all[] = KERNEL_SETS(type);                                                  \
        return index < kernel_levels() ? all[index] : NULL;                                                  \
    }

/* For __attribute__((target(…))) of one function. clang ignores an attribute that names a preferred width. */
#if defined(__clang__)
#define KERNEL_TARGET_AVX512 "avx512f,avx512vl,avx512dq,avx512bw"
#else
#define KERNEL_TARGET_AVX512 "avx512f,avx512vl,avx512dq,avx512bw,prefer-vector-width=512"
#endif

/* How many of them may run here, at least 1. */
static inline unsigned kernel_levels(void) {
    return isa_usable(ISA_AVX512) ? 3 : (isa_usable(ISA_AVX2) ? 2 : 1);
}

/* a if mask is all ones, b if it is 0; reads both. */
static inline float chosen(uint32_t mask, float a, float b) {
    uint32_t x, y;
    memcpy(&x, &a, sizeof x), memcpy(&y, &b, sizeof y);
    x = (x & mask) | (y & ~mask);
    memcpy(&a, &x, sizeof a);
    return a;
}

#endif
