/* How far a tracer's position, normal and u, v are from the exact ones. */
#ifndef VERIFY_ERROR_H
#define VERIFY_ERROR_H

#include "verify/exact/oracle.h"

/* A hit as the tracer reports it, as in trace_hits and trace_fine. */
typedef struct error_said {
    double t;
    vec3_f32 normal; /* in the space of the primitive, of any length */
    double u, v;
} error_said;

/* All against the point of the ray at the exact t. */
typedef struct error_report {
    /* Between the points of the ray at both t, |t - exact| |d|, in units of the last place, as a float, of
     * the exact point's largest coordinate. */
    double position;
    /* The angle between the normals in the primitive's space, in units of 2^-24 rad, the last place of a
     * unit vector's largest components; pi for one that has no direction. */
    double normal;
    /* The larger of |u - exact| and |v - exact|, in units of 2^-24; negative for shapes without. u and v are
     * the weights of B and C; of a quad, bilinear along its sides as in reference/quad_text.h. */
    double uv;
} error_report;

/* The distance between floats around x. */
double error_ulp(double x);

/* `answer`: the oracle's of this ray and primitive, with line set. */
void error_measure(const oracle_ray *ray, const oracle_primitive *primitive, const oracle_answer *answer,
                   const error_said *said, error_report *out);

/* ---- counts of errors ---- */

/* Counts positive numbers of any size, for quantiles. The order of counting makes no difference. */
#define HISTOGRAM_BINS 640
#define HISTOGRAM_PER_OCTAVE 4
#define HISTOGRAM_FIRST (-80) /* the first bin begins at 2^-80 */

typedef struct histogram {
    uint64_t zeros, total;
    double largest; /* of all */
    uint64_t bins[HISTOGRAM_BINS];
} histogram;

/* value: at least 0; an infinite one counts as the largest. */
void histogram_add(histogram *h, double value);
void histogram_join(histogram *h, const histogram *other);
/* A number that at least the fraction q of all do not exceed: at most 2^(1/4) too large, and no larger than
 * the largest; 0: of none. */
double histogram_quantile(const histogram *h, double q);

#endif
