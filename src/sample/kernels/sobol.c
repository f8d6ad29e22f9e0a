/* sample_2d() for sixteen samples at once. */
#include "sample/sobol.h"
#include "base/kernel.h"
#include "sample/sample.h"

/* Rounded down, so that 1 is never reached. */
static inline float unit_from(uint32_t bits) { return (float)(int32_t)(bits >> 8) * 0x1p-24f; }

static void pairs(const uint64_t pixel[LANES], const uint32_t index[LANES], uint32_t dimension,
                  float *restrict u, float *restrict v) {
    const uint64_t of = dimension * 0xd1342543de82ef95u;
    uint32_t low[LANES], high[LANES], third[LANES];
    for (int i = 0; i < LANES; ++i) {
        const uint64_t hash = mix(pixel[i] ^ of), more = mix(hash + 1);
        low[i] = (uint32_t)hash, high[i] = (uint32_t)(hash >> 32), third[i] = (uint32_t)more;
    }
    for (int i = 0; i < LANES; ++i) {
        const uint32_t k = scramble(index[i], low[i]);
        u[i] = unit_from(scramble(reverse_bits(k), high[i]));
        v[i] = unit_from(scramble(sobol_second(k), third[i]));
    }
}

const sample_kernels KERNEL(sample_kernels) = {.pairs = pairs};
