/* Where in a pixel the samples lie. Each position depends on pixel, index and seed alone. */
#ifndef MATH_SAMPLING_H
#define MATH_SAMPLING_H

#include <stdint.h>

/* Offsets from the pixel's lower corner, in [0,1). n × n samples: index = row * n + column. */
void sample_grid(uint32_t n, uint32_t index, double *dx, double *dy);
/* The same cells, a position in each by hash. */
void sample_stratified(uint32_t n, uint32_t index, uint32_t x, uint32_t y, uint64_t seed, double *dx,
                       double *dy);
/* Point `index` of the two-dimensional Sobol sequence, Owen-scrambled by hash (Laine and Karras 2011; Burley
 * 2020), with another scramble for each pixel: any run of 2^k points from a multiple of 2^k is stratified in
 * all ways at once. */
void sample_sobol(uint32_t index, uint32_t x, uint32_t y, uint64_t seed, double *dx, double *dy);

#endif
