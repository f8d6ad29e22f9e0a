/* Faults that many answers show and no single one does: errors too large on the whole or to one side, more
 * leaks than a tracer is known to have, surfaces met where a render's rays start, a unit roundoff that is
 * declared too large. */
#ifndef VERIFY_STATISTICS_H
#define VERIFY_STATISTICS_H

#include "trace/spec.h"
#include "verify/compare.h"

typedef struct statistics_finding {
    char words[256];
} statistics_finding;
typedef ARRAY(statistics_finding) statistics_findings;

/* Errors over condition number and unit roundoff. Correct tracers stay below 0.5 (median). The largest are
 * below 4, but where many inputs are exactly zero, which have no part in a condition number: 36 in scenes of
 * boxes. */
#define STATISTICS_MEDIAN 1.0
/* Limits the 99.9th percentile to a quarter of COMPARE_SHAPED: bounds add up 26 roundings and more of one
 * sign. As many that are independent and even within ±1 have a standard deviation of √(26 / 3) = 3, and
 * a 99.9th percentile of 10, less than a third. */
#define STATISTICS_HIGH 64.0
#define STATISTICS_LEAST 100 /* hits, or nothing is said */

/* The mean signed error of t, in units of roundoff, may be this much by rules of rounding alone (an
 * approximate reciprocal, a truncated product); it is tested at STATISTICS_SIGMAS standard errors, one-sided
 * level 1e-9 for each run. A hundred thousand runs of a correct tracer have a false alarm with a probability
 * of 1e-4. */
#define STATISTICS_BIAS 2.0
#define STATISTICS_SIGMAS 6.0

/* The share of a render's rays that may be excused at an end of their interval. Correct tracers had none in
 * 25,000 rays of the built-in scenes and of four scanned and modelled meshes. */
#define STATISTICS_ENDS 1e-3

/* A declared unit may be so many times the one that is measured: the 99th percentile of the constants. */
#define STATISTICS_UNIT 64.0

/* One tracer over one scene. False when out of memory, as below. */
bool statistics_run(const trace_spec *spec, const compare_family families[RAYS_FAMILIES],
                    statistics_findings *out);
/* One tracer over all scenes: `sum` of them. */
bool statistics_tracer(const trace_spec *spec, double unit, const compare_family *sum,
                       statistics_findings *out);

/* The mean of the signed errors of t, and its standard error. */
void statistics_bias(const compare_bias *bias, double *mean, double *error);
/* With none found in `rays`, the rate is below this with a probability of 95 %: -log(0.05) / rays. */
double statistics_power(uint64_t rays);

#endif
