/* FLIP: the visible difference when alternating between two images on a screen, in [0,1] for each pixel
 * (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild, FLIP: A Difference Evaluator for
 * Alternating Images, 2020).
 *
 * This is LDR-FLIP after the display transform of sRGB: linear values are clamped to [0,1], the range of such
 * a screen. The encoding to sRGB and its inverse, the metric's first step, cancel. NaN counts as 0, as in
 * image files. The metric is symmetric in its two images. */
#pragma once

#include "image/compare/metric.h"

/* Pixels per degree of visual angle: 67 for a 4K screen 0.7 m wide, seen from 0.7 m, as in the paper. */
#define FLIP_PPD 67.0
#define FLIP_PPD_LEAST 1.0
#define FLIP_PPD_MOST 500.0

/* An image after the filters of the metric, for any number of comparisons. */
typedef struct flip_view flip_view;

/* NULL when out of memory. Release with flip_view_destroy(). ppd: in [FLIP_PPD_LEAST, FLIP_PPD_MOST]. */
flip_view *flip_view_create(const metric_image *img, double ppd);
void flip_view_destroy(flip_view *view);

/* The mean of the differences of all pixels. map: receives the differences, width × height values, unless
 * NULL. Both views must have the same size and ppd. */
double flip_mean(const flip_view *a, const flip_view *b, float *map);

/* ---- colour spaces; linear RGB has the primaries of sRGB, white is D65 ---- */

/* YCxCz, opponent colours linear in light (the paper's spatial filtering). */
void flip_opponent(const double rgb[3], double out[3]);
void flip_opponent_rgb(const double opponent[3], double out[3]);

/* CIE L*a*b* with the Hunt effect (dark colours look less saturated): a and b are multiplied by 0.01 L. */
void flip_hunt(const double rgb[3], double out[3]);

/* |ΔL| + √(Δa² + Δb²), for large differences (Abasi, Amani Tehran and Fairchild,
 * Distance metrics for very large color differences, 2019). */
double flip_hyab(const double a[3], const double b[3]);
