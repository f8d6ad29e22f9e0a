/* Image error against run time, for each antialiasing pattern. */
#pragma once

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
    uint64_t rays, nonfinite; /* nonfinite: number of pixels that are not finite */
    double errors[CONVERGE_METRICS];
} converge_run;

/* The mean of two halves, rendered with the Sobol pattern and seeds that no other image has. If each half has
 * the variance v, the variance of their difference is 2v and that of their mean is v/2. So the RMSE of the
 * mean is half of the RMSE between the halves, and its relative MSE a quarter. FLIP is not linear; its
 * difference between the halves is an upper bound.
 *
 * An image is marked if it is closer to the reference than the halves are to each other: then more than half
 * of its RMSE is the reference's own. Fits and tables leave marked images out. */
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
    double errors[CONVERGE_METRICS]; /* geometric means, because fits use logarithms */
    bool below[CONVERGE_METRICS];    /* marked: closer to the reference than the halves are to each other */
} converge_point;

/* b in error ∝ seconds^b: for each seed the least-squares slope of ln error against ln seconds, then the mean
 * over all seeds with its interval. The regular pattern has no seed: its rounds differ only in time. */
typedef struct converge_slope {
    mean_interval slope;
    double scale;    /* error = scale · seconds^b, geometric mean over the seeds; for drawing */
    unsigned points; /* number of points in each fit */
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
    unsigned rounds;   /* [1, CONVERGE_SEEDS_MAX] */
    uint32_t max_spp;  /* [1, 65536] */
    uint32_t half_spp; /* of each half of the reference */
    uint64_t seed;     /* of the first round; increases by 1 for each further round */
    double ppd;        /* pixels per degree, for FLIP */
    bool (*progress)(void *user, double fraction); /* false stops; may be NULL */
    void *user;
} converge_options;

/* "rmse", "relmse", "flip"; "grid", "stratified", "sobol". */
const char *converge_metric_name(converge_metric metric);
const char *converge_pattern_name(fathom_pattern pattern);

/* Renders the patterns in turn, so that a machine that slows down affects all patterns. The stage must be
 * built. Always release with converge_free(). FATHOM_INTERRUPTED keeps the complete rounds; in the first
 * round, it keeps the steps that all patterns have. */
fathom_status converge_measure(fathom_context *context, const bench_stage *stage,
                               const converge_options *options, converge_result *out);
void converge_free(converge_result *result);

/* Computes points, marks and slopes from the runs and the reference. */
void converge_summarise(converge_result *result);

#define CONVERGE_ROWS 5
/* The error of each pattern after the same time, or (by_error) its time for the same error. Interpolated
 * between the points that count, along straight lines in log-log; NAN outside them. */
typedef struct converge_row {
    double at; /* seconds of processor time, or an error */
    double values[CONVERGE_PATTERNS];
} converge_row;
/* Rows in the range where all patterns have values, at equal distances on a logarithmic scale. Returns 0 or
 * CONVERGE_ROWS. */
size_t converge_equal(const converge_result *result, converge_metric metric, bool by_error,
                      converge_row out[CONVERGE_ROWS]);
