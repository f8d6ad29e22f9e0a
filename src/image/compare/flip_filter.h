/* Filters of FLIP, each a product of one along rows and one along columns. Beyond the border lies what is on
 * it. */
#ifndef IMAGE_FLIP_FILTER_H
#define IMAGE_FLIP_FILTER_H

#include <stddef.h>
#include <stdint.h>

#define FLIP_RADIUS_MOST 80 /* at FLIP_PPD_MOST a filter reaches 68 pixels */

typedef struct flip_kernel {
    int radius;
    double weights[2 * FLIP_RADIUS_MOST + 1]; /* the middle one at [radius] */
} flip_kernel;

typedef struct flip_size {
    size_t width, height;
} flip_size;

/* exp(-x² / (2 sigma²)), x in pixels up to the radius; sums to one. */
flip_kernel flip_gauss(double sigma, int radius);
/* Its first derivative, which finds edges, and its second, which finds points and lines: positive weights sum
 * to one, and negative ones to minus one. */
flip_kernel flip_edge(double sigma, int radius);
flip_kernel flip_point(double sigma, int radius);

/* out is neither of the other two; line has room for a row and two radii. */
void flip_along_rows(const double *in, flip_size size, const flip_kernel *k, double *line, double *out);
void flip_along_columns(const double *in, flip_size size, const flip_kernel *k, double *out);

#endif
