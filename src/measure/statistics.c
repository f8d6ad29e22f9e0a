#include "measure/statistics.h"

#include <math.h>
#include <stdlib.h>

static int by_value(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double quantile_of(const double *sorted, size_t count, double q) {
    double at = q * (double)(count - 1);
    size_t below = (size_t)at, above = below + 1 < count ? below + 1 : below;
    return sorted[below] + (at - (double)below) * (sorted[above] - sorted[below]);
}

quartiles quartiles_of(double *values, size_t count) {
    if (!count) return (quartiles){(double)NAN, (double)NAN, (double)NAN};
    qsort(values, count, sizeof *values, by_value);
    return (quartiles){quantile_of(values, count, 0.25), quantile_of(values, count, 0.5),
                       quantile_of(values, count, 0.75)};
}

/* A table up to 30; beyond it, the expansion about the normal quantile z = 1.95996 (Abramowitz and Stegun
 * 26.7.5), whose third term is below 0.004. */
double student_95(size_t freedom) {
    static const double table[31] = {INFINITY, 12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365,
                                     2.306,    2.262,  2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
                                     2.120,    2.110,  2.101, 2.093, 2.086, 2.080, 2.074, 2.069,
                                     2.064,    2.060,  2.056, 2.052, 2.048, 2.045, 2.042};
    if (freedom <= 30) return table[freedom];
    double z = 1.959964, n = (double)freedom;
    return z + (z * z * z + z) / (4 * n) + (5 * pow(z, 5) + 16 * pow(z, 3) + 3 * z) / (96 * n * n);
}

mean_interval mean_of(const double *values, size_t count) {
    if (!count) return (mean_interval){(double)NAN, (double)NAN};
    double sum = 0, squares = 0;
    for (size_t i = 0; i < count; ++i) sum += values[i];
    double mean = sum / (double)count;
    if (count == 1) return (mean_interval){mean, INFINITY};
    for (size_t i = 0; i < count; ++i) squares += (values[i] - mean) * (values[i] - mean);
    double deviation = sqrt(squares / (double)(count - 1));
    return (mean_interval){mean, student_95(count - 1) * deviation / sqrt((double)count)};
}

line_fit line_through(const double *x, const double *y, size_t count) {
    double mean_x = 0, mean_y = 0, across = 0, along = 0, left = 0;
    for (size_t i = 0; i < count; ++i) mean_x += x[i] / (double)count, mean_y += y[i] / (double)count;
    for (size_t i = 0; i < count; ++i) {
        across += (x[i] - mean_x) * (x[i] - mean_x);
        along += (x[i] - mean_x) * (y[i] - mean_y);
    }
    line_fit fit = {(double)NAN, (double)NAN, count < 3 ? (double)INFINITY : (double)NAN};
    if (!(across > 0)) return fit;
    fit.slope = along / across, fit.intercept = mean_y - fit.slope * mean_x;
    if (count < 3) return fit;
    for (size_t i = 0; i < count; ++i) {
        const double r = y[i] - fit.intercept - fit.slope * x[i];
        left += r * r;
    }
    fit.half = student_95(count - 2) * sqrt(left / (double)(count - 2) / across);
    return fit;
}

power_fit power_through(const double *x, const double *y, size_t count) {
    double *logs = malloc(2 * (count + 1) * sizeof *logs);
    power_fit fit = {(double)NAN, INFINITY, (double)NAN, 0};
    if (!logs) return fit;
    double *lx = logs, *ly = logs + count;
    for (size_t i = 0; i < count; ++i) {
        if (!(x[i] > 0) || !(y[i] > 0)) continue;
        lx[fit.count] = log(x[i]), ly[fit.count++] = log(y[i]);
    }
    line_fit line = line_through(lx, ly, fit.count);
    fit.exponent = line.slope, fit.half = line.half, fit.scale = exp(line.intercept);
    free(logs);
    return fit;
}

/* ---- progress of a measurement ---- */

static double at(const bench_watch *watch, double share) {
    return watch->from + (watch->to - watch->from) * share;
}

void bench_watch_tell(const bench_watch *watch, double done, double total) {
    if (watch && watch->tell && total > 0) watch->tell(watch->user, at(watch, done / total));
}

bench_watch bench_watch_part(const bench_watch *watch, double from, double to) {
    if (!watch) return (bench_watch){.tell = NULL};
    return (bench_watch){watch->tell, watch->user, at(watch, from), at(watch, to)};
}
