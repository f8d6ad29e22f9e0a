/* Faults that only show in many results together: errors that are too large on average or biased, more leaks
 * than the tracer is known to have, self-intersections of a render's rays, and a declared unit roundoff that
 * is too large. */
#pragma once

#include "trace/spec.h"
#include "verify/compare.h"

typedef struct statistics_finding {
    char words[256];
} statistics_finding;
typedef ARRAY(statistics_finding) statistics_findings;

/* Limit of the median of errors divided by (condition number times unit roundoff). Correct tracers stay below
 * 0.5. Their largest errors are below 4, or up to 36 in scenes of boxes: there many inputs are exactly zero,
 * and zeros add nothing to a condition number. */
#define STATISTICS_MEDIAN 1.0
/* Limit of the 99.9th percentile: a quarter of COMPARE_SHAPED. Bounds add at least 26 roundings of one sign.
 * The same number of independent roundings, uniform in ±1, has a standard deviation of √(26 / 3) = 3 and a
 * 99.9th percentile of 10, less than a third of the bound. */
#define STATISTICS_HIGH 64.0
#define STATISTICS_LEAST 100 /* minimum number of hits for a finding */

/* Limit of the mean signed error of t, in units of roundoff. Such a bias can come from the rounding method
 * alone (an approximate reciprocal, a truncated product). The test uses STATISTICS_SIGMAS standard errors, a
 * one-sided level of 1e-9 per run. A hundred thousand runs of a correct tracer have a false alarm with a
 * probability of 1e-4. */
#define STATISTICS_BIAS 2.0
#define STATISTICS_SIGMAS 6.0

/* Limit of the fraction of a render's rays with the verdict RANGE. Correct tracers had none in 25,000 rays of
 * the built-in scenes and of four scanned and modelled meshes. */
#define STATISTICS_ENDS 1e-3

/* Limit of the declared unit divided by the measured one, which is the 99th percentile of the constants. */
#define STATISTICS_UNIT 64.0

/* Checks one tracer on one scene. False when out of memory, as below. */
bool statistics_run(const trace_spec *spec, const compare_family families[RAYS_FAMILIES],
                    statistics_findings *out);
/* Checks one tracer on all scenes; `sum`: of their families. */
bool statistics_tracer(const trace_spec *spec, double unit, const compare_family *sum,
                       statistics_findings *out);

/* The mean of the signed errors of t, and its standard error. */
void statistics_bias(const compare_bias *bias, double *mean, double *error);
/* If none of `rays` rays fails, the rate of failures is below this with 95 % confidence: 1 - 0.05^(1/rays).
 */
double statistics_power(uint64_t rays);
