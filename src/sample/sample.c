#include "sample/sample.h"

/* The finaliser of SplitMix64 (Steele, Lea, Flood 2014): every bit of the result depends on every bit of the
 * input. */
static uint64_t mix(uint64_t h) {
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    return h ^ (h >> 31);
}

/* The first dimension has none of its own. */
static uint64_t key_hash(const sampler *s, sample_key key, sample_dimension dimension) {
    uint64_t pixel = mix(mix(s->seed + 0x9e3779b97f4a7c15u) ^ ((uint64_t)key.y << 32 | key.x));
    return dimension ? mix(pixel ^ (uint64_t)dimension * 0xd1342543de82ef95u) : pixel;
}

static double unit_from(uint32_t bits) { return bits * 0x1p-32; }

static void grid(uint32_t n, uint32_t index, double *u, double *v) {
    *u = (index % n + 0.5) / n;
    *v = (double)(index / n) / n + 0.5 / n;
}

static void stratified(uint32_t n, uint32_t index, uint64_t hash, double *u, double *v) {
    uint64_t h = mix(hash + index);
    *u = (index % n + unit_from((uint32_t)h)) / n;
    *v = (index / n + unit_from((uint32_t)(h >> 32))) / n;
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

static void sobol(uint32_t index, uint64_t hash, double *u, double *v) {
    uint32_t i = scramble(index, (uint32_t)hash);
    *u = unit_from(scramble(reverse_bits(i), (uint32_t)(hash >> 32)));
    *v = unit_from(scramble(sobol_second(i), (uint32_t)mix(hash + 1)));
}

void sample_2d(const sampler *s, sample_key key, sample_dimension dimension, double *u, double *v) {
    const fathom_pattern pattern = dimension == SAMPLE_PIXEL ? s->pattern : FATHOM_PATTERN_SOBOL;
    switch (pattern) {
    case FATHOM_PATTERN_GRID: grid(s->grid, key.index, u, v); break;
    case FATHOM_PATTERN_STRATIFIED: stratified(s->grid, key.index, key_hash(s, key, dimension), u, v); break;
    case FATHOM_PATTERN_SOBOL: sobol(key.index, key_hash(s, key, dimension), u, v); break;
    }
}
