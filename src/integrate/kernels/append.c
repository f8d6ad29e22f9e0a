/* Copies lanes of blocks to consecutive positions. */
#include "base/kernel.h"
#include "integrate/kernels/kernel.h"
#include "math/lanes.h"

#if defined(__AVX512F__)
#include <immintrin.h>

void KERNEL(append)(const void *from, unsigned rows, uint32_t lanes, void *to, unsigned at) {
    const __mmask16 mine = (__mmask16)lanes;
    const __mmask16 full = (__mmask16)((1u << __builtin_popcount(lanes)) - 1);
    const uint32_t *source = from;
    uint32_t *out = (uint32_t *)to + at;
    for (unsigned r = 0; r < rows; ++r, source += LANES, out += LANES)
        _mm512_mask_storeu_epi32(out, full, _mm512_maskz_compress_epi32(mine, _mm512_loadu_si512(source)));
}

#else

void KERNEL(append)(const void *from, unsigned rows, uint32_t lanes, void *to, unsigned at) {
    if (lanes == (1u << LANES) - 1) {
        memmove(to, from, rows * LANES * sizeof(uint32_t));
        return;
    }
    for (; lanes; lanes &= lanes - 1, ++at) {
        const uint32_t *source = (const uint32_t *)from + __builtin_ctz(lanes);
        uint32_t *out = (uint32_t *)to + at;
        for (unsigned r = 0; r < rows; ++r) out[r * LANES] = source[r * LANES];
    }
}

#endif
