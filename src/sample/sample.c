#include "sample/sample.h"

#include "base/kernel.h"
#include "sample/sobol.h"

uint64_t sample_pixel_hash(const sampler *s, uint32_t x, uint32_t y) {
    return pixel_hash(mix_bits(s->seed + 0x9e3779b97f4a7c15u), x, y);
}

/* The first dimension uses the hash of the pixel itself. */
static uint64_t key_hash(const sampler *s, sample_key key, sample_dimension dimension) {
    const uint64_t pixel = sample_pixel_hash(s, key.x, key.y);
    return dimension ? mix_bits(pixel ^ (uint64_t)dimension * 0xd1342543de82ef95u) : pixel;
}

static double unit_from(uint32_t bits) { return bits * 0x1p-32; }

static void grid(uint32_t n, uint32_t index, double *u, double *v) {
    *u = (index % n + 0.5) / n;
    *v = (double)(index / n % n) / n + 0.5 / n;
}

static void stratified(uint32_t n, uint32_t index, uint64_t hash, double *u, double *v) {
    uint64_t h = mix_bits(hash + index);
    *u = (index % n + unit_from((uint32_t)h)) / n;
    *v = (index / n % n + unit_from((uint32_t)(h >> 32))) / n;
}

static void sobol(uint32_t index, uint64_t hash, double *u, double *v) {
    uint32_t a, b;
    sobol_point(sobol_shuffle(index, hash), hash, &a, &b);
    *u = unit_from(a), *v = unit_from(b);
}

void sample_2d(const sampler *s, sample_key key, sample_dimension dimension, double *u, double *v) {
    const fathom_pattern pattern = dimension == SAMPLE_PIXEL ? s->pattern : FATHOM_PATTERN_SOBOL;
    switch (pattern) {
    case FATHOM_PATTERN_GRID: grid(s->grid, key.index, u, v); break;
    case FATHOM_PATTERN_STRATIFIED: stratified(s->grid, key.index, key_hash(s, key, dimension), u, v); break;
    case FATHOM_PATTERN_SOBOL: sobol(key.index, key_hash(s, key, dimension), u, v); break;
    }
}

KERNEL_BEST(sample_kernels)
