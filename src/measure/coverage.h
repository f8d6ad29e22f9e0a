/* Measures how accurate the stated errors of renders are: how often the 95 % interval of a pixel's channel
 * contains the true value, and whether the mean of images over seeds equals the mean of the true image. */
#pragma once

#include "measure/stage.h"

/* The number of values that were checked, and of those inside their interval. */
typedef struct coverage_count {
    uint64_t values, held;
} coverage_count;

typedef struct coverage_row {
    double target; /* error; 0: uniform samples */
    uint32_t spp;  /* samples a pixel; with a target, the maximum */
    double mean_spp;
    double light; /* mean of the images divided by the mean of the reference */
    double t;     /* (mean - truth) / standard error of the mean, over seeds */
    uint32_t seeds;
    /* Classified by error.doubt (fathom/render.h). alike: all samples of a pixel are alike, so its error is
     * an upper bound on unseen light, or 0. */
    coverage_count trusted, doubtful, alike;
} coverage_row;

#define COVERAGE_ROWS 4

typedef struct coverage_options {
    uint32_t seeds, max_spp, reference_spp; /* max_spp: a power of two, at least 4 */
    uint64_t seed;
    bool (*progress)(void *user, double fraction); /* false stops; may be NULL */
    void *user;
} coverage_options;

/* Measures uniform sampling with 16 and 64 samples a pixel (path tracing only), and sampling to an error of
 * 0.1 and 0.05. Writes *count rows to `out`. The stage need not be built. */
fathom_status coverage_measure(fathom_context *context, const bench_stage *stage,
                               const coverage_options *options, coverage_row out[COVERAGE_ROWS],
                               unsigned *count);
