/* Statistical tests: the probability that a difference is only random. */
#pragma once

#include <stddef.h>

/* A mean with its standard error and the degrees of freedom of that error. */
typedef struct sample_mean {
    double mean, error, freedom;
} sample_mean;

/* P(|T| >= |t|) for Student's distribution; freedom: degrees of freedom, > 0. */
double student_p(double t, double freedom);

/* The p-value of the smallest of n independent p-values: 1 - (1-p)^n (Šidák). For positively dependent tests
 * it is an upper bound. */
double sidak(double p, double n);
/* The level of each of n tests for which their joint level is `level`. */
double sidak_level(double level, double n);

/* Probability of a difference from `value` at least as large as this one. Differences up to `allowance` may
 * come from rounding and are ignored. */
double mean_p(sample_mean a, double value, double allowance);
/* Compares two means with unequal errors (Welch 1947). */
double welch_p(sample_mean a, sample_mean b, double allowance);
