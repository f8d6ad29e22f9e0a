/* Numbers of sixteen samples at once. */
#include "sample/sobol.h"
#include "base/kernel.h"
#include "sample/sample.h"

/* Rounded down to 24 bits, so that the result is below 1. */
static inline float unit_from(uint32_t bits) { return (float)(int32_t)(bits >> 8) * 0x1p-24f; }

static void square(const sampler *s, uint32_t left, uint32_t top, uint64_t *restrict out) {
    const uint64_t seed = mix_bits(s->seed + 0x9e3779b97f4a7c15u);
    for (uint32_t i = 0; i < LANES; ++i) out[i] = pixel_hash(seed, left + i % 4, top + i / 4);
}

static void places(const uint64_t pixel[LANES], uint32_t index, sample_dimension dimension,
                   double *restrict x, double *restrict y) {
    const uint64_t of = dimension * 0xd1342543de82ef95u;
    uint64_t hash[LANES];
    uint32_t u[LANES], v[LANES];
    for (int i = 0; i < LANES; ++i) hash[i] = dimension ? mix_bits(pixel[i] ^ of) : pixel[i];
    for (int i = 0; i < LANES; ++i) sobol_point(sobol_shuffle(index, hash[i]), hash[i], &u[i], &v[i]);
    for (int i = 0; i < LANES; ++i) x[i] = u[i] * 0x1p-32, y[i] = v[i] * 0x1p-32;
}

static void pairs(const uint64_t pixel[LANES], const uint32_t index[LANES], uint32_t dimension,
                  float *restrict u, float *restrict v) {
    const uint64_t of = dimension * 0xd1342543de82ef95u;
    for (int i = 0; i < LANES; ++i) {
        const uint64_t hash = mix_bits(pixel[i] ^ of);
        uint32_t a, b;
        sobol_point(sobol_shuffle(index[i], hash), hash, &a, &b);
        u[i] = unit_from(a), v[i] = unit_from(b);
    }
}

static void triples(const uint64_t pixel[LANES], const uint32_t index[LANES], uint32_t dimension,
                    float *restrict u, float *restrict v, float *restrict w) {
    const uint64_t of = dimension * 0xd1342543de82ef95u;
    for (int i = 0; i < LANES; ++i) {
        const uint64_t hash = mix_bits(pixel[i] ^ of);
        const uint32_t k = sobol_shuffle(index[i], hash);
        uint32_t a, b;
        sobol_point(k, hash, &a, &b);
        u[i] = unit_from(a), v[i] = unit_from(b), w[i] = unit_from(sobol_point_third(k, hash));
    }
}

const sample_kernels KERNEL(sample_kernels) = {
    .square = square, .places = places, .pairs = pairs, .triples = triples};
