/* Measures how true the stated errors of renders are: how often the 95 % interval of a pixel's channel
 * holds the true value, and whether the mean of images over seeds is the true image's. */
#ifndef BENCH_COVERAGE_H
#define BENCH_COVERAGE_H

#include "measure/stage.h"

/* Values of which the interval was asked, and those whose interval held the truth. */
typedef struct coverage_count {
    uint64_t values, held;
} coverage_count;

typedef struct coverage_row {
    double target; /* error; 0: even samples */
    uint32_t spp;  /* of even samples, or the most */
    double mean_spp;
    double light; /* mean of the images over that of the reference */
    double t;     /* (mean - truth) / its standard error, over seeds */
    uint32_t seeds;
    /* By error.doubt: render.h. The last: all samples of a square are alike, so that the error is a bound on
     * what was not seen, or 0. */
    coverage_count trusted, doubtful, alike;
} coverage_row;

#define COVERAGE_ROWS 4

typedef struct coverage_options {
    uint32_t seeds, max_spp, reference_spp; /* max_spp: a power of two, at least 4 */
    uint64_t seed;
    bool (*progress)(void *user, double fraction); /* false stops; may be NULL */
    void *user;
} coverage_options;

/* Even samples, 16 and 64 a pixel, by path tracing alone, and samples to an error of 0.1 and 0.05. Returns
 * rows in `out` and how many they are in `count`. The stage need not be built. */
fathom_status coverage_measure(fathom_context *context, const bench_stage *stage,
                               const coverage_options *options, coverage_row out[COVERAGE_ROWS],
                               unsigned *count);

#endif
