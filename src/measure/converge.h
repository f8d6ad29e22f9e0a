/* Image error against run time: what each second buys, by antialiasing pattern. */
#ifndef BENCH_CONVERGE_H
#define BENCH_CONVERGE_H

#include "base/array.h"
#include "measure/stage.h"
#include "measure/statistics.h"

typedef enum converge_metric {
    CONVERGE_RMSE,
    CONVERGE_RELMSE,
    CONVERGE_FLIP,
    CONVERGE_METRICS
} converge_metric;

#define CONVERGE_PATTERNS 3
#define CONVERGE_STEPS_MAX 9 /* 1, 4, 16, … 65536 samples a pixel */
#define CONVERGE_SEEDS_MAX 100

/* One image. */
typedef struct converge_run {
    unsigned round; /* images of a round share a seed */
    unsigned step;  /* 4^step samples a pixel */
    fathom_pattern pattern;
    bench_seconds seconds;
    uint64_t rays, nonfinite; /* pixels that are not finite */
    double errors[CONVERGE_METRICS];
} converge_run;

/* The mean of two halves of the Sobol pattern with seeds that nothing else has. Each half has a variance v,
 * so they differ by 2v and their mean has v/2: its RMSE is half of that between them, its relative MSE a
 * quarter. For FLIP, which is not linear, the difference between the halves is a bound.
 *
 * An image closer to the reference than the halves are to each other is marked and left out of fits and
 * tables: more than half of its RMSE is the reference's own. */
typedef struct converge_reference {
    uint32_t spp; /* of each half */
    bench_seconds seconds;
    uint64_t nonfinite;
    double halves[CONVERGE_METRICS], own[CONVERGE_METRICS];
} converge_reference;

/* All images of one pattern and spp. */
typedef struct converge_point {
    uint32_t spp;
    bench_seconds seconds;           /* medians */
    double errors[CONVERGE_METRICS]; /* geometric means, as for fits of logarithms */
    bool below[CONVERGE_METRICS];    /* marked: closer than the halves are */
} converge_point;

/* b in error ∝ seconds^b: for each seed the slope of ln error over ln seconds by least squares, then the mean
 * of all seeds with its interval. The regular pattern has no seed: its rounds differ in time alone. */
typedef struct converge_slope {
    mean_interval slope;
    double scale;    /* error = scale · seconds^b by all points, for drawing */
    unsigned points; /* in each fit */
} converge_slope;

typedef struct converge_curve {
    fathom_pattern pattern;
    converge_point points[CONVERGE_STEPS_MAX];
    converge_slope slopes[CONVERGE_METRICS][BENCH_CLOCKS];
} converge_curve;

typedef struct converge_result {
    unsigned rounds, steps;
    converge_reference reference;
    ARRAY(converge_run) runs;
    converge_curve curves[CONVERGE_PATTERNS];
} converge_result;

typedef struct converge_options {
    unsigned rounds;                               /* [1, CONVERGE_SEEDS_MAX] */
    uint32_t max_spp;                              /* [1, 65536] */
    uint32_t half_spp;                             /* of each half of the reference */
    uint64_t seed;                                 /* of the first round; the next have the next */
    double ppd;                                    /* for FLIP */
    bool (*progress)(void *user, double fraction); /* false stops; may be NULL */
    void *user;
} converge_options;

/* "rmse", "relmse", "flip"; "grid", "stratified", "sobol". */
const char *converge_metric_name(converge_metric metric);
const char *converge_pattern_name(fathom_pattern pattern);

/* Renders the patterns in turn, so that a machine that slows down slows all. The stage is built. Always
 * release with converge_free(). FATHOM_INTERRUPTED keeps the whole rounds, or the steps of the first one that
 * all patterns have. */
fathom_status converge_measure(fathom_context *context, const bench_stage *stage,
                               const converge_options *options, converge_result *out);
void converge_free(converge_result *result);

/* Points, marks and slopes from runs and reference. */
void converge_summarise(converge_result *result);

#define CONVERGE_ROWS 5
/* The error that patterns reach in the same time, or the time they need for the same error: between the
 * counted points, along straight lines in log-log; NAN where there are none. */
typedef struct converge_row {
    double at; /* seconds of processor time, or the error */
    double values[CONVERGE_PATTERNS];
} converge_row;
/* Rows where all patterns have values, evenly over the logarithm: 0 or CONVERGE_ROWS. */
size_t converge_equal_time(const converge_result *result, converge_metric metric,
                           converge_row out[CONVERGE_ROWS]);
size_t converge_equal_error(const converge_result *result, converge_metric metric,
                            converge_row out[CONVERGE_ROWS]);

#endif
