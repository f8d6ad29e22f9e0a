/* Owen-scrambled Sobol points of one sample, shared by sample_2d() and its kernel. */
#pragma once

#include "math/mix.h"

#include <stdint.h>

/* `seed` has already passed through mix_bits(). */
static inline uint64_t pixel_hash(uint64_t seed, uint32_t x, uint32_t y) {
    return mix_bits(seed ^ ((uint64_t)y << 32 | x));
}

static inline uint32_t reverse_bits(uint32_t v) {
    v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
    v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
    v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
    v = (v >> 8 & 0x00ff00ffu) | (v & 0x00ff00ffu) << 8;
    return v >> 16 | v << 16;
}

/* A permutation of 32-bit numbers in which each bit is changed by lower bits only. On reversed bits it is a
 * nested uniform (Owen) scramble. */
static inline uint32_t permute(uint32_t v, uint32_t seed) {
    v += seed;
    v ^= v * 0x6c50b47cu;
    v ^= v * 0xb82f1e52u;
    v ^= v * 0xc7afe638u;
    v ^= v * 0x8d22f6e6u;
    return v;
}

/* The second dimension of the Sobol sequence, with the primitive polynomial x + 1, in reversed bits. Bit i of
 * the index adds row i of Pascal's triangle modulo 2, the highest bit first. The triangle of 2^k rows
 * consists of three copies of the triangle of 2^(k-1) rows, so five steps compute the sum. The first
 * dimension is the index itself. */
static inline uint32_t sobol_second(uint32_t index) {
    uint32_t v = index;
    v ^= v >> 1 & 0x55555555u;
    v ^= v >> 2 & 0x33333333u;
    v ^= v >> 4 & 0x0f0f0f0fu;
    v ^= v >> 8 & 0x00ff00ffu;
    v ^= v >> 16;
    return v;
}

/* Divides the polynomial in each block of 4n bits by (x² + x + 1)^n = x^2n + x^n + 1, where n is a power of
 * 2: the remainder becomes the lower half, the quotient the upper one. low: 2n bits of each block, lowest: n.
 */
static inline uint32_t divide_blocks(uint32_t v, unsigned n, uint32_t low, uint32_t lowest) {
    const uint32_t high = v >> 2 * n & low, q = high ^ (high >> n & lowest);
    return ((v ^ q ^ q << n) & low) | q << 2 * n;
}

/* The third dimension, with the primitive polynomial x² + x + 1, in reversed bits. The bits of the index are
 * the coefficients of a polynomial over GF(2). Its digits to the base x² + x + 1, two bits each and the
 * lowest first, are those of the point (Niederreiter 1988). */
static inline uint32_t sobol_third(uint32_t index) {
    uint32_t v = divide_blocks(index, 8, 0x0000ffffu, 0x000000ffu);
    v = divide_blocks(v, 4, 0x00ff00ffu, 0x000f000fu);
    v = divide_blocks(v, 2, 0x0f0f0f0fu, 0x03030303u);
    return divide_blocks(v, 1, 0x33333333u, 0x11111111u);
}

/* The index of a point in the order of its pixel and dimension. */
static inline uint32_t sobol_shuffle(uint32_t index, uint64_t hash) {
    return reverse_bits(permute(reverse_bits(index), (uint32_t)hash));
}

/* The coordinates of point k = sobol_shuffle(), each scrambled. */
static inline void sobol_point(uint32_t k, uint64_t hash, uint32_t *u, uint32_t *v) {
    *u = reverse_bits(permute(k, (uint32_t)(hash >> 32)));
    *v = reverse_bits(permute(sobol_second(k), (uint32_t)mix_bits(hash + 1)));
}
static inline uint32_t sobol_point_third(uint32_t k, uint64_t hash) {
    return reverse_bits(permute(sobol_third(k), (uint32_t)mix_bits(hash + 2)));
}
