/* The numbers that a sample is made of. Each is a function of the sampler and of the sample's pixel, index
 * and dimension alone, so that no order of work changes any. */
#ifndef SAMPLE_SAMPLE_H
#define SAMPLE_SAMPLE_H

#include <fathom/render.h>

#include "math/lanes.h"

#include <stdint.h>

/* The uses of the numbers, two numbers each. */
typedef enum sample_dimension {
    SAMPLE_PIXEL, /* where in its pixel a sample lies, from the top left */
    SAMPLE_LENS,  /* where a ray leaves the lens */
    SAMPLE_TIME,  /* when the shutter is open */
    SAMPLE_VERTEX /* the first of a path's vertices: see sample_at_vertex() */
} sample_dimension;

/* The uses of numbers at a vertex of a path. */
typedef enum sample_purpose {
    SAMPLE_LIGHT,    /* a point on a light */
    SAMPLE_SCATTER,  /* a direction */
    SAMPLE_CHOICE,   /* which light, and which lobe */
    SAMPLE_ROULETTE, /* whether the path goes on */
    SAMPLE_PURPOSES
} sample_purpose;

static inline sample_dimension sample_at_vertex(uint32_t vertex, sample_purpose purpose) {
    return (sample_dimension)(SAMPLE_VERTEX + vertex * SAMPLE_PURPOSES + purpose);
}

typedef struct sample_key {
    uint32_t x, y, index; /* the pixel, in the image, and which of its samples */
} sample_key;

typedef struct sampler {
    fathom_pattern pattern; /* of SAMPLE_PIXEL; all others follow Sobol's sequence */
    uint32_t grid;          /* n of the n × n patterns; index = row * n + column */
    uint64_t seed;
} sampler;

/* Grid: the cells' centres. Stratified: a place in each cell by hash. Sobol: point `index` of the
 * two-dimensional Sobol sequence, Owen-scrambled by hash (Laine and Karras 2011; Burley 2020), with another
 * scramble for each pixel and dimension: any run of 2^k points from a multiple of 2^k is stratified in all
 * ways at once. (u, v) lies in [0,1)². */
void sample_2d(const sampler *s, sample_key key, sample_dimension dimension, double *u, double *v);

/* The part of a key that all dimensions of a pixel share. */
uint64_t sample_pixel_hash(const sampler *s, uint32_t x, uint32_t y);

typedef struct sample_kernels {
    /* sample_pixel_hash() of a square of 4 × 4 pixels, row by row. */
    void (*square)(const sampler *s, uint32_t left, uint32_t top, uint64_t *out);

    /* sample_2d() of sixteen pixels in SAMPLE_PIXEL, where the pattern is Sobol's. */
    void (*places)(const uint64_t pixel[LANES], uint32_t index, double *x, double *y);

    /* sample_2d() of sixteen samples, rounded down to 24 bits, in a dimension other than SAMPLE_PIXEL. */
    void (*pairs)(const uint64_t pixel[LANES], const uint32_t index[LANES], uint32_t dimension, float *u,
                  float *v);
} sample_kernels;

const sample_kernels *sample_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const sample_kernels *sample_kernels_at(unsigned index);

#endif
