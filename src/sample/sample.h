/* The random numbers of samples. Each number depends only on the sampler and on the sample's pixel, index and
 * dimension, so the order of work has no effect. */
#pragma once

#include <fathom/render.h>

#include "math/lanes.h"

#include <stdint.h>

/* The dimensions of a sample, two or three numbers each. */
typedef enum sample_dimension {
    SAMPLE_PIXEL, /* position in the pixel, from its top left corner */
    SAMPLE_LENS,  /* position on the lens */
    SAMPLE_TIME,  /* time while the shutter is open */
    SAMPLE_VERTEX /* the first vertex of a path: see sample_at_vertex() */
} sample_dimension;

/* The dimensions at each vertex of a path. */
typedef enum sample_purpose {
    SAMPLE_LIGHT,    /* a point on a light, and the light */
    SAMPLE_SCATTER,  /* a direction of scattering, and the lobe */
    SAMPLE_ROULETTE, /* whether the path continues */
    SAMPLE_PURPOSES
} sample_purpose;

static inline sample_dimension sample_at_vertex(uint32_t vertex, sample_purpose purpose) {
    return (sample_dimension)(SAMPLE_VERTEX + vertex * SAMPLE_PURPOSES + purpose);
}

typedef struct sample_key {
    uint32_t x, y, index; /* the pixel in the image, and the index of the sample in it */
} sample_key;

typedef struct sampler {
    fathom_pattern pattern; /* of SAMPLE_PIXEL; all other dimensions use the Sobol sequence */
    uint32_t grid;          /* n of the n × n patterns; index = row * n + column, modulo n * n */
    uint64_t seed;
} sampler;

/* Grid: the centre of a cell. Stratified: a hashed position in each cell. Sobol: point `index` of the
 * two-dimensional Sobol sequence, Owen-scrambled by a hash (Laine and Karras 2011; Burley 2020), with a
 * different scramble for each pixel and dimension. Any run of 2^k points that starts at a multiple of 2^k is
 * a (0,k,2)-net: all its elementary intervals are stratified at once. (u, v) lies in [0,1)². */
void sample_2d(const sampler *s, sample_key key, sample_dimension dimension, double *u, double *v);

/* The hash of a pixel, common to all its samples and dimensions. */
uint64_t sample_pixel_hash(const sampler *s, uint32_t x, uint32_t y);

typedef struct sample_kernels {
    /* sample_pixel_hash() of a square of 4 × 4 pixels, row by row. */
    void (*square)(const sampler *s, uint32_t left, uint32_t top, uint64_t *out);

    /* sample_2d() of sixteen pixels; SAMPLE_PIXEL only for the Sobol pattern. */
    void (*places)(const uint64_t pixel[LANES], uint32_t index, sample_dimension dimension, double *x,
                   double *y);

    /* sample_2d() of sixteen samples, rounded down to 24 bits, in a dimension other than SAMPLE_PIXEL. */
    void (*pairs)(const uint64_t pixel[LANES], const uint32_t index[LANES], uint32_t dimension, float *u,
                  float *v);

    /* The same with a third number. The number of points of a run of 2^k in each elementary box of 2 / 2^k is
     * 2: a (1,k,3)-net. In quarters of the third number, and quarters of them, the first two are
     * (0,k,2)-nets.
     */
    void (*triples)(const uint64_t pixel[LANES], const uint32_t index[LANES], uint32_t dimension, float *u,
                    float *v, float *w);
} sample_kernels;

const sample_kernels *sample_kernels_best(void);
