/* The numbers that a sample is made of. Each is a function of the sampler and of the sample's pixel, index
 * and dimension alone, so that no order of work changes any. */
#ifndef SAMPLE_SAMPLE_H
#define SAMPLE_SAMPLE_H

#include <fathom/render.h>

#include <stdint.h>

/* What the numbers are for, two of them each. */
typedef enum sample_dimension {
    SAMPLE_PIXEL /* where in its pixel a sample lies, from the top left */
} sample_dimension;

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

#endif
