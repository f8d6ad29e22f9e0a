/* Random numbers for tests: the same on every machine. */
#pragma once

#include "math/vec.h"

#include <math.h>
#include <stdint.h>

typedef struct random_state {
    uint64_t counter;
} random_state;

/* splitmix64 (Steele, Lea, Flood 2014). */
static inline uint64_t random_bits(random_state *r) {
    uint64_t z = r->counter += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}
/* [0,1) */
static inline double random_unit(random_state *r) { return (double)(random_bits(r) >> 11) * 0x1p-53; }
static inline double random_in(random_state *r, double low, double high) {
    return low + (high - low) * random_unit(r);
}
/* Between low and high, evenly in its logarithm. */
static inline double random_log(random_state *r, double low, double high) {
    return exp(random_in(r, log(low), log(high)));
}
/* In the cube [-size,size]³. */
static inline vec3_f32 random_point(random_state *r, double size) {
    return vec_f32((float)random_in(r, -size, size), (float)random_in(r, -size, size),
                   (float)random_in(r, -size, size));
}
/* Unit vectors, all alike. */
static inline vec3_f64 random_direction(random_state *r) {
    const double z = random_in(r, -1, 1), phi = random_in(r, 0, 2 * M_PI), s = sqrt(1 - z * z);
    return vec_f64(s * cos(phi), s * sin(phi), z);
}
