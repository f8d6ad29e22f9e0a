/* What the sources in this folder share; see base/kernel.h. Loops over indices are left to the compiler;
 * where it does not vectorise, registers are named: `wide` is as many floats as the instruction set has in
 * one, by the compilers' vectors. */
#ifndef SCENE_KERNELS_KERNEL_H
#define SCENE_KERNELS_KERNEL_H

#include "base/kernel.h"
#include "math/four.h"
#include "scene/kernels.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

bool KERNEL(vectors)(const float *values, size_t stride, size_t count, float lower[3], float upper[3]);
bool KERNEL(indices)(const uint32_t *indices, size_t count, uint32_t limit);
uint64_t KERNEL(boundary)(const uint32_t *triangles, size_t count);
bool KERNEL(areas)(const float *positions, size_t stride, const uint32_t *triangles, size_t count,
                   float *largest);

#if defined(__AVX512F__)
#define WIDE 16
#elif defined(__AVX2__)
#define WIDE 8
#else
#define WIDE 4
#endif
#define WIDE_FOURS (WIDE / 4)

typedef float wide __attribute__((vector_size(4 * WIDE)));
typedef int wide_marks __attribute__((vector_size(4 * WIDE))); /* each -1 or 0 */

FOUR_INLINE wide wide_load(const float *from) {
    wide v;
    memcpy(&v, from, sizeof v);
    return v;
}

/* a where marked, else b. */
FOUR_INLINE wide_marks wide_choose(wide_marks marks, wide_marks a, wide_marks b) {
    return (a & marks) | (b & ~marks);
}

/* gcc 12 makes four instructions of a choice, where there is one. */
FOUR_INLINE wide_marks wide_larger(wide_marks a, wide_marks b) {
#if defined(__AVX512F__)
    return (wide_marks)_mm512_max_epi32((__m512i)a, (__m512i)b);
#elif defined(__AVX2__)
    return (wide_marks)_mm256_max_epi32((__m256i)a, (__m256i)b);
#else
    return wide_choose(a > b, a, b);
#endif
}

#endif
