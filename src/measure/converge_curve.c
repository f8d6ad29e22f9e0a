#include "measure/converge.h"

#include <math.h>
#include <stddef.h>

/* ---- points ---- */

static double geometric_mean(const double *values, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += log(values[i]);
    return exp(sum / (double)count);
}

static size_t runs_of(const converge_result *result, fathom_pattern pattern, unsigned step,
                      const converge_run *out[CONVERGE_SEEDS_MAX]) {
    size_t count = 0;
    for (size_t i = 0; i < result->runs.count && count < CONVERGE_SEEDS_MAX; ++i) {
        const converge_run *run = &result->runs.items[i];
        if (run->pattern == pattern && run->step == step) out[count++] = run;
    }
    return count;
}

static converge_point point_of(const converge_result *result, fathom_pattern pattern, unsigned step) {
    const converge_run *runs[CONVERGE_SEEDS_MAX];
    size_t count = runs_of(result, pattern, step, runs);
    double values[CONVERGE_SEEDS_MAX];
    converge_point point = {.spp = 1u << (2 * step)};
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        for (size_t i = 0; i < count; ++i) values[i] = runs[i]->seconds.by[c];
        point.seconds.by[c] = median_of(values, count);
    }
    for (int m = 0; m < CONVERGE_METRICS; ++m) {
        for (size_t i = 0; i < count; ++i) values[i] = runs[i]->errors[m];
        point.errors[m] = geometric_mean(values, count);
        point.below[m] = point.errors[m] < result->reference.halves[m];
    }
    return point;
}

bool converge_point_counts(const converge_point *point, converge_metric metric) {
    return point->errors[metric] > 0 && isfinite(point->errors[metric]) && !point->below[metric];
}

/* ---- slopes ---- */

/* Logarithms of the counted points of one round. */
static size_t take_round(const converge_result *result, const converge_curve *curve, unsigned round,
                         int metric, int clock, double *x, double *y) {
    size_t count = 0;
    for (unsigned step = 0; step < result->steps; ++step) {
        const converge_run *runs[CONVERGE_SEEDS_MAX];
        if (!converge_point_counts(&curve->points[step], (converge_metric)metric)) continue;
        size_t there = runs_of(result, curve->pattern, step, runs);
        for (size_t i = 0; i < there; ++i) {
            if (runs[i]->round != round) continue;
            x[count] = log(runs[i]->seconds.by[clock]), y[count] = log(runs[i]->errors[metric]);
            ++count;
        }
    }
    return count;
}

static converge_slope slope_of(const converge_result *result, const converge_curve *curve, int metric,
                               int clock) {
    double x[CONVERGE_STEPS_MAX], y[CONVERGE_STEPS_MAX], slopes[CONVERGE_SEEDS_MAX], intercept = 0;
    size_t points = 0;
    for (unsigned round = 0; round < result->rounds; ++round) {
        points = take_round(result, curve, round, metric, clock, x, y);
        line_fit fit = line_through(x, y, points);
        slopes[round] = fit.slope;
        intercept += fit.intercept / result->rounds;
    }
    return (converge_slope){mean_of(slopes, result->rounds), exp(intercept), (unsigned)points};
}

void converge_summarise(converge_result *result) {
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        converge_curve *curve = &result->curves[p];
        curve->pattern = (fathom_pattern)p;
        for (unsigned step = 0; step < result->steps; ++step)
            curve->points[step] = point_of(result, curve->pattern, step);
        for (int m = 0; m < CONVERGE_METRICS; ++m) {
            for (int c = 0; c < BENCH_CLOCKS; ++c) curve->slopes[m][c] = slope_of(result, curve, m, c);
        }
    }
}

/* ---- equal time, equal error ---- */

typedef struct place {
    double seconds, error;
} place;

static size_t places_of(const converge_result *result, const converge_curve *curve, converge_metric metric,
                        place out[CONVERGE_STEPS_MAX]) {
    size_t count = 0;
    for (unsigned step = 0; step < result->steps; ++step) {
        const converge_point *point = &curve->points[step];
        if (converge_point_counts(point, metric))
            out[count++] = (place){point->seconds.by[BENCH_CPU], point->errors[metric]};
    }
    return count;
}

/* Along the first straight line that passes over x, in logarithms. */
static double interpolate(const place *places, size_t count, bool by_error, double x) {
    for (size_t i = 0; i + 1 < count; ++i) {
        const place *a = &places[i], *b = a + 1;
        double from = by_error ? a->error : a->seconds, to = by_error ? b->error : b->seconds;
        if (x < fmin(from, to) || x > fmax(from, to) || from == to) continue;
        double first = by_error ? a->seconds : a->error, second = by_error ? b->seconds : b->error;
        return first * pow(second / first, log(x / from) / log(to / from));
    }
    return (double)NAN;
}

static size_t equal_rows(const converge_result *result, converge_metric metric, bool by_error,
                         converge_row out[CONVERGE_ROWS]) {
    place places[CONVERGE_PATTERNS][CONVERGE_STEPS_MAX];
    size_t counts[CONVERGE_PATTERNS];
    double low = 0, high = INFINITY; /* what all patterns have */
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        counts[p] = places_of(result, &result->curves[p], metric, places[p]);
        double least = INFINITY, most = 0;
        for (size_t i = 0; i < counts[p]; ++i) {
            double x = by_error ? places[p][i].error : places[p][i].seconds;
            least = fmin(least, x), most = fmax(most, x);
        }
        low = fmax(low, least), high = fmin(high, most);
    }
    if (!(low > 0 && low < high)) return 0;
    for (size_t row = 0; row < CONVERGE_ROWS; ++row) {
        double part = ((double)row + 0.5) / CONVERGE_ROWS;
        if (by_error) part = 1 - part; /* from what is had soonest */
        out[row].at = low * pow(high / low, part);
        for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
            out[row].values[p] = interpolate(places[p], counts[p], by_error, out[row].at);
    }
    return CONVERGE_ROWS;
}

size_t converge_equal_time(const converge_result *result, converge_metric metric,
                           converge_row out[CONVERGE_ROWS]) {
    return equal_rows(result, metric, false, out);
}

size_t converge_equal_error(const converge_result *result, converge_metric metric,
                            converge_row out[CONVERGE_ROWS]) {
    return equal_rows(result, metric, true, out);
}
