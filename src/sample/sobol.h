/* Owen-scrambled Sobol numbers, of one sample: what sample_2d() and its kernel share. */
#ifndef SAMPLE_SOBOL_H
#define SAMPLE_SOBOL_H

#include <stdint.h>

/* The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every bit of the result depends on every bit of the
 * input. */
static inline uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    return h ^ (h >> 31);
}

static inline uint32_t reverse_bits(uint32_t v) {
    v = (v >> 1 & 0x55555555u) | (v & 0x55555555u) << 1;
    v = (v >> 2 & 0x33333333u) | (v & 0x33333333u) << 2;
    v = (v >> 4 & 0x0f0f0f0fu) | (v & 0x0f0f0f0fu) << 4;
    v = (v >> 8 & 0x00ff00ffu) | (v & 0x00ff00ffu) << 8;
    return v >> 16 | v << 16;
}

/* A permutation of 32-bit numbers in which each bit is changed by lower ones only: on reversed bits that is a
 * nested uniform scramble. */
static inline uint32_t scramble(uint32_t v, uint32_t seed) {
    v = reverse_bits(v);
    v += seed;
    v ^= v * 0x6c50b47cu;
    v ^= v * 0xb82f1e52u;
    v ^= v * 0xc7afe638u;
    v ^= v * 0x8d22f6e6u;
    return reverse_bits(v);
}

/* The second dimension of the Sobol sequence, of the primitive polynomial x + 1. Bit i of the index adds row
 * i of Pascal's triangle modulo 2, the highest bit first: the triangle of 2^k rows is that of 2^(k-1) rows
 * three times, so the sum takes five steps. */
static inline uint32_t sobol_second(uint32_t index) {
    uint32_t v = reverse_bits(index);
    v ^= (v & 0x55555555u) << 1;
    v ^= (v & 0x33333333u) << 2;
    v ^= (v & 0x0f0f0f0fu) << 4;
    v ^= (v & 0x00ff00ffu) << 8;
    v ^= (v & 0x0000ffffu) << 16;
    return v;
}

#endif
