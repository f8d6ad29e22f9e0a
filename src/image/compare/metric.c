#include "image/compare/metric.h"

#include <math.h>

#define RELATIVE_FLOOR 0.01 /* as in the literature, so that results are comparable */

static size_t pixels_of(const metric_image *a) { return (size_t)a->width * a->height; }

static bool is_finite_at(const metric_image *a, size_t i) {
    return isfinite(a->rgb[0][i]) && isfinite(a->rgb[1][i]) && isfinite(a->rgb[2][i]);
}

uint64_t metric_nonfinite(const metric_image *a, const metric_image *b) {
    uint64_t count = 0;
    for (size_t i = 0; i < pixels_of(a); ++i) count += !is_finite_at(a, i) || !is_finite_at(b, i);
    return count;
}

double metric_rmse(const metric_image *a, const metric_image *b) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        for (size_t i = 0; i < pixels_of(a); ++i) {
            double d = (double)a->rgb[c][i] - (double)b->rgb[c][i];
            sum += d * d;
        }
    }
    return isfinite(sum) ? sqrt(sum / (3 * (double)pixels_of(a))) : (double)INFINITY;
}

double metric_relmse(const metric_image *reference, const metric_image *test) {
    double sum = 0;
    bool finite = true; /* an infinite reference would make every relative difference 0 */
    for (int c = 0; c < 3; ++c) {
        for (size_t i = 0; i < pixels_of(reference); ++i) {
            double r = (double)reference->rgb[c][i], d = (double)test->rgb[c][i] - r;
            finite &= isfinite(r) != 0;
            sum += d * d / (r * r + RELATIVE_FLOOR);
        }
    }
    return finite && isfinite(sum) ? sum / (3 * (double)pixels_of(reference)) : (double)INFINITY;
}
