/* How far a tracer's arithmetic may be off: forward error bounds, each a constant times a condition number
 * times the unit roundoff. */
#ifndef PARITY_VERDICT_BOUND_H
#define PARITY_VERDICT_BOUND_H

#include "verify/verdict/verdict.h"

typedef struct verdict_bound {
    double t;     /* of t, in its units */
    double edge;  /* of oracle_answer.edge */
    double aside; /* in world coordinates, of where the ray passes */
} verdict_bound;

/* The bound for an answer that is not parallel. */
verdict_bound verdict_bound_of(const verdict_tracer *tracer, const oracle_ray *ray,
                               const oracle_primitive *primitive, const oracle_answer *answer);

/* The bound of a reported t: verdict_bound.t, or infinite where the tracer has lost the normal. */
double verdict_reported(const verdict_tracer *tracer, const oracle_primitive *primitive,
                        const verdict_bound *bound);

/* The largest verdict_bound.aside of anything within `extent` of the world's origin. */
double verdict_aside(const verdict_tracer *tracer, const world *w, const oracle_ray *ray, double extent);

/* Whether rounding may bring a ray that is exactly parallel to the primitive's plane into it. */
bool verdict_in_plane(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *primitive);

/* Whether the tracer's floats cannot hold what this intersection takes: t above the largest of them, or a
 * coordinate above what it takes, of the ray in any space of the world or of the primitive. */
bool verdict_beyond(const verdict_tracer *tracer, const world *w, const oracle_ray *ray,
                    const oracle_primitive *primitive, double t);

/* The error of t allowed whatever its condition: VERDICT_ULPS, of a double at least, and flushed
 * denormals. */
double verdict_rounding(const verdict_tracer *tracer, double t);

/* The ray's direction in the primitive's space. */
vec3_f32 verdict_object_direction(const oracle_ray *ray, const oracle_primitive *primitive);

/* The constants, for reports. */
double verdict_constant(oracle_shape shape);

#endif
