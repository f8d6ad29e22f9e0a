#include "math/sampling.h"

/* The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every bit of the result depends on every bit of the
 * input. */
static uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    return h ^ (h >> 31);
}

static uint64_t pixel_hash(uint32_t x, uint32_t y, uint64_t seed) {
    return mix(mix(seed + 0x9e3779b97f4a7c15u) ^ ((uint64_t)y << 32 | x));
}

static double unit_from(uint32_t bits) { return bits * 0x1p-32; }

void sample_grid(uint32_t n, uint32_t index, double *dx, double *dy) {
    *dx = (index % n + 0.5) / n;
    *dy = (double)(index / n) / n + 0.5 / n;
}

void sample_stratified(uint32_t n, uint32_t index, uint32_t x, uint32_t y, uint64_t seed, double *dx,
                       double *dy) {
    uint64_t h = mix(pixel_hash(x, y, seed) + index);
    *dx = (index % n + unit_from((uint32_t)h)) / n;
    *dy = (index / n + unit_from((uint32_t)(h >> 32))) / n;
}

static uint32_t reverse_bits(uint32_t v) {
    v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
    v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
    v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
    v = (v >> 8 & 0x00ff00ffu) | (v & 0x00ff00ffu) << 8;
    return v >> 16 | v << 16;
}

/* A permutation of 32-bit numbers in which each bit is changed by lower ones only: on reversed bits that is a
 * nested uniform scramble. */
static uint32_t scramble(uint32_t v, uint32_t seed) {
    v = reverse_bits(v);
    v += seed;
    v ^= v * 0x6c50b47cu;
    v ^= v * 0xb82f1e52u;
    v ^= v * 0xc7afe638u;
    v ^= v * 0x8d22f6e6u;
    return reverse_bits(v);
}

/* The second dimension of the Sobol sequence: direction numbers from the primitive polynomial x + 1. */
static uint32_t sobol_second(uint32_t index) {
    uint32_t v = 1u << 31, result = 0;
    for (; index; index >>= 1, v ^= v >> 1) result ^= index & 1 ? v : 0;
    return result;
}

void sample_sobol(uint32_t index, uint32_t x, uint32_t y, uint64_t seed, double *dx, double *dy) {
    uint64_t h = pixel_hash(x, y, seed), h2 = mix(h + 1);
    uint32_t i = scramble(index, (uint32_t)h);
    *dx = unit_from(scramble(reverse_bits(i), (uint32_t)(h >> 32)));
    *dy = unit_from(scramble(sobol_second(i), (uint32_t)h2));
}
