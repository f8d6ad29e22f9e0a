/* Quartiles, means, and straight lines through measurements. */
#pragma once

#include <stddef.h>

/* Sorts the values. Interpolates linearly between two values (type 7 of Hyndman and Fan 1996); NAN for no
 * values. */
typedef struct quartiles {
    double low, median, high;
} quartiles;
quartiles quartiles_of(double *values, size_t count);

/* The t with P(|T| <= t) = 0.95 for Student's distribution with `freedom` degrees of freedom, within 0.001;
 * infinite for 0. */
double student_95(size_t freedom);

/* A mean with its 95 % interval: mean ± student_95(n - 1) s / √n, with the sample standard deviation s.
 * `half` is infinite for a single value, NAN for none. */
typedef struct mean_interval {
    double mean, half;
} mean_interval;
mean_interval mean_of(const double *values, size_t count);

/* y = intercept + slope x by least squares: slope = Σ (x - x̄)(y - ȳ) / Σ (x - x̄)². Both are NAN unless
 * there are two different x. The 95 % interval of the slope is slope ± half, infinite for fewer than three
 * points: half = student_95(n - 2) √(Σ r² / (n - 2) / Σ (x - x̄)²), with r the residuals of the line. */
typedef struct line_fit {
    double slope, intercept, half;
} line_fit;
line_fit line_through(const double *x, const double *y, size_t count);

/* y ∝ x^exponent, by least squares of the logarithms; the 95 % interval is exponent ± half. Ignores pairs
 * that are not positive; NAN if fewer than two different pairs are left. */
typedef struct power_fit {
    double exponent, half, scale; /* y = scale · x^exponent */
    size_t count;
} power_fit;
power_fit power_through(const double *x, const double *y, size_t count);

/* ---- progress of a measurement ---- Reported between the timed parts, never during them. */

typedef struct bench_watch {
    void (*tell)(void *user, double fraction); /* NULL: no progress is wanted */
    void *user;
    double from, to; /* the measurement's range of the whole, within [0,1] */
} bench_watch;

/* Reports `done` of `total`, in any unit proportional to time; watch may be NULL. */
void bench_watch_tell(const bench_watch *watch, double done, double total);
/* A watch for the part of the measurement between two fractions; if `watch` is NULL, it reports to nobody. */
bench_watch bench_watch_part(const bench_watch *watch, double from, double to);
