/* Errors of a tracer's position, normal and u, v. */
#pragma once

#include "verify/exact/oracle.h"

/* A hit as reported by the tracer in trace_hits and trace_fine. */
typedef struct error_said {
    double t;
    vec3_f32 normal; /* in the space of the primitive, of any length */
    double u, v;
} error_said;

/* Errors relative to the ray's point at the exact t. */
typedef struct error_report {
    /* Distance between the ray's points at both t, |t - exact| |d|, in float ulps of the exact point's
     * largest coordinate. */
    double position;
    /* The angle between the normals in the primitive's space, in units of 2^-24 rad, the last place of a unit
     * vector's largest components; pi for a normal without direction. */
    double normal;
    /* The larger of |u - exact| and |v - exact|, in units of 2^-24; negative for shapes without u and v.
     * These are the weights of B and C; for a quad, bilinear along its sides as in reference/quad_text.h. */
    double uv;
} error_report;

/* The distance between floats around x. */
double error_ulp(double x);

/* `answer`: the oracle's, for this ray and primitive, with `line` set. */
void error_measure(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                   const error_said *said, error_report *out);

/* ---- counts of errors ---- */

/* Counts positive numbers of any size, for quantiles. The result does not depend on the order. */
#define HISTOGRAM_BINS 640
#define HISTOGRAM_PER_OCTAVE 4
#define HISTOGRAM_FIRST (-80) /* the first bin begins at 2^-80 */

typedef struct histogram {
    uint64_t zeros, total;
    double largest; /* maximum of all values */
    uint64_t bins[HISTOGRAM_BINS];
} histogram;

/* value: at least 0; infinity goes to the last bin. */
void histogram_add(histogram *h, double value);
void histogram_join(histogram *h, const histogram *other);
/* Upper bound of the q-quantile: at most 2^(1/4) too large, and not above `largest`. 0 if there are no
 * values. */
double histogram_quantile(const histogram *h, double q);
