/* Tests of statistics: how likely a difference is by chance alone. */
#ifndef VERIFY_LAWS_STATISTICS_H
#define VERIFY_LAWS_STATISTICS_H

#include <stddef.h>

/* A mean with its standard error and the degrees of freedom that the error is known by. */
typedef struct sample_mean {
    double mean, error, freedom;
} sample_mean;

/* P(|T| >= |t|) by Student's distribution of so many degrees of freedom, > 0. */
double student_p(double t, double freedom);

/* The p-value of the smallest of n independent p-values: 1 - (1-p)^n (Šidák). It bounds that of tests whose
 * errors go together. */
double sidak(double p, double n);
/* The level of each of n tests that makes their level together `level`. */
double sidak_level(double level, double n);

/* P of a difference from a value as large as this one, or larger. Differences up to `allowance`, which
 * rounding may make, do not count. */
double mean_p(sample_mean a, double value, double allowance);
/* Compares two means with unequal errors (Welch 1947). */
double welch_p(sample_mean a, sample_mean b, double allowance);

#endif
