/* Medians, means, straight lines: what measurements are told by. */
#ifndef BENCH_STATISTICS_H
#define BENCH_STATISTICS_H

#include <stddef.h>

/* Sorts the values. Of an even number the mean of the middle two; NAN of none. */
double median_of(double *values, size_t count);

/* Sorts the values. Between two of them in proportion (type 7 of Hyndman and Fan 1996); NAN of none. */
typedef struct quartiles {
    double low, median, high;
} quartiles;
quartiles quartiles_of(double *values, size_t count);

/* The t with P(|T| <= t) = 0.95 for Student's distribution of so many degrees of freedom, within 0.001;
 * infinite for 0. */
double student_95(size_t freedom);

/* A mean with its 95 % interval, mean ± student_95(n - 1) s / √n of the sample deviation s; the half width is
 * infinite for a single value, NAN for none. */
typedef struct mean_interval {
    double mean, half;
} mean_interval;
mean_interval mean_of(const double *values, size_t count);

/* y = intercept + slope x by least squares: slope = Σ (x - x̄)(y - ȳ) / Σ (x - x̄)². Both are NAN when there
 * are no two different x. */
typedef struct line_fit {
    double slope, intercept;
} line_fit;
line_fit line_through(const double *x, const double *y, size_t count);

/* Half of the 95 % interval of the slope, student_95(n - 2) √(Σ r² / (n - 2) / Σ (x - x̄)²) with what the line
 * leaves, r; infinite for less than three points. */
double line_slope_half(const double *x, const double *y, size_t count);

#endif
