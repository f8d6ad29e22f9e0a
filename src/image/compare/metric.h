/* Differences of two images in linear RGB, computed in double.
 *
 * An image is three planes of values, top row first. A pixel that is not finite in either image makes RMSE
 * and relative MSE infinite, has the largest error 1 in FLIP, and is counted by metric_nonfinite(). */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct metric_image {
    const float *rgb[3];
    uint32_t width, height;
} metric_image;

/* Pixels with a NaN or an infinity in a channel of either image. */
uint64_t metric_nonfinite(const metric_image *a, const metric_image *b);

/* √(Σ (a - b)² / n) over the n values of all channels. */
double metric_rmse(const metric_image *a, const metric_image *b);

/* Σ (test - reference)² / (reference² + 0.01) / n over values, so that differences are relative to the
 * reference (Rousselle, Knaus and Zwicker, Adaptive sampling and reconstruction using greedy error
 * minimization, 2011). */
double metric_relmse(const metric_image *reference, const metric_image *test);
