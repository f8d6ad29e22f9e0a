/* Sixteen numbers from anywhere in an array: gcc 12 makes single loads of such loops, so the instructions are
 * asked for by name. */
#ifndef SHADE_KERNELS_GATHER_H
#define SHADE_KERNELS_GATHER_H

#include "shade/surface.h"

#if defined(__AVX2__)
#include <immintrin.h>
#endif

/* out[i] = from[at[i]], of any numbers of 32 bits. */
static inline void gather(const void *from, const int32_t at[LANES], void *out) {
#if defined(__AVX512F__)
    __m512i places = _mm512_loadu_si512(at);
    _mm512_storeu_si512(out, _mm512_i32gather_epi32(places, from, sizeof(float)));
#elif defined(__AVX2__)
    for (int half = 0; half < 2; ++half) {
        __m256i places = _mm256_loadu_si256((const __m256i *)(const void *)at + half);
        _mm256_storeu_si256((__m256i *)out + half,
                            _mm256_i32gather_epi32((const int *)from, places, sizeof(float)));
    }
#else
    for (int i = 0; i < LANES; ++i) ((uint32_t *)out)[i] = ((const uint32_t *)from)[at[i]];
#endif
}

#endif
