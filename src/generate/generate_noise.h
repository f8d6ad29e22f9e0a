/* Gradient noise and random numbers from integer hashes. Uses only + - * / and square roots in double, so
 * every processor gives the same bits. */
#pragma once

#include "math/vec.h"
#include <stdint.h>

typedef struct noise_value {
    double value;
    vec3_f64 gradient; /* derivative of the value with respect to the point */
} noise_value;

/* Maximum number of octaves. Each octave doubles the frequency and rotates the lattice, so that its axes are
 * not visible. */
#define NOISE_MAX_OCTAVES 24

/* Perlin's gradient noise with the quintic fade (Improving Noise, 2002) and its exact gradient: about [-1,1],
 * zero on the integer lattice, for coordinates below 2^31. The gradient of noise_2d() is in x and y. */
noise_value noise_3d(uint32_t seed, vec3_f64 p);
noise_value noise_2d(uint32_t seed, double x, double y);

/* Sum of gain^k noise_3d(2^k p), k < octaves. */
noise_value noise_fbm(uint32_t seed, vec3_f64 p, unsigned octaves, double gain);

/* The same in the plane, but octaves have a lower weight where the slope is already steep, as if eroded:
 * crests are rough and valleys smooth. */
double noise_eroded(uint32_t seed, double x, double y, unsigned octaves, double gain);

/* The number of octaves, starting at `frequency`, whose waves are longer than `shortest`; at least one. */
unsigned noise_octaves(double frequency, double shortest);

/* A sequence of random numbers (splitmix64); any initial state is valid. */
typedef struct noise_random {
    uint64_t state;
} noise_random;

noise_random noise_random_from(uint64_t seed, uint64_t stream);
double random_unit(noise_random *random);                             /* [0,1) */
double random_between(noise_random *random, double low, double high); /* [low,high) */
vec3_f64 random_in_ball(noise_random *random);                        /* uniform in the unit ball */
vec3_f64 random_direction(noise_random *random);                      /* uniform on the unit sphere */
vec3_f64 random_turn(noise_random *random); /* uniform on the unit circle in the plane y = 0 */
