/* Checks a tracer's hit against the exact one. */
#pragma once

#include "trace/spec.h"
#include "verify/search/search.h"

typedef enum verdict {
    VERDICT_AGREE,       /* the oracle's primitive and t within VERDICT_ULPS; or both miss */
    VERDICT_TIE,         /* another primitive; its exact t is equal, or too close to distinguish in this
                            precision */
    VERDICT_EDGE,        /* correct for a ray moved past an edge, by less than the precision resolves */
    VERDICT_RANGE,       /* t is closer to an end of the interval than the precision resolves */
    VERDICT_CONDITIONED, /* the oracle's primitive; the error of t is within verdict_bound */
    VERDICT_BEYOND,      /* numbers exceed the range of the tracer's floats: see verdict_beyond() */
    VERDICT_LEAK, /* a known miss of this tracer: a surface at an edge or vertex that continues on the other
                     side; also for directions whose reciprocals it clamps */
    VERDICT_WRONG,
    VERDICT_COUNT
} verdict;

/* "agree" … */
const char *verdict_name(verdict v);

/* Allowed error of t, in units of its own rounding, whatever its condition. */
#define VERDICT_ULPS 2

typedef struct verdict_tracer {
    double unit;   /* roundoff of its arithmetic: 2^-24 for float */
    bool inverted; /* inverts to_world itself, as Embree does */
    bool leaks;    /* may miss surfaces at edges and vertices; if false, such a miss is wrong */
    unsigned
        seen; /* bit i: for oracle_shape i, it computes the sides from corners relative to the ray's origin */
    double clamped; /* in box tests, it clamps direction components to at least this; 0: it does not */
    bool strict;    /* its reported t always lies in the open interval, for shapes that are not `seen` */
    double largest; /* it ignores rays and primitives with larger coordinates; 0: no limit */
} verdict_tracer;

/* The tracer's hit: ids as in trace_hits; geometry is FATHOM_NONE for a miss. */
typedef struct verdict_answer {
    uint32_t geometry, primitive, instance;
    double t, t_low; /* t + t_low: t as the tracer computed it */
} verdict_answer;

typedef struct verdict_report {
    verdict verdict;
    bool measured;    /* the line hits the primitive, so t has an error; the fields below are set */
    double exact_t;   /* for the primitive that the tracer reported */
    double t_error;   /* |t - exact_t| */
    double t_signed;  /* t - exact_t */
    double bound;     /* bound that t_error was compared with */
    double condition; /* of exact_t: a relative change of u in all inputs moves it by at most u times this */
    oracle_primitive primitive;
    oracle_answer exact;
} verdict_report;

/* The properties of the tracer with this specification. */
verdict_tracer verdict_tracer_of(const trace_spec *spec, double unit);

/* Checks one closest hit. `room` is working memory for searches. False when out of memory. */
bool verdict_closest(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                     const verdict_answer *answer, search_result *room, verdict_report *out);

/* Checks an any-hit query on shapes that cast a shadow. *out: AGREE, EDGE, RANGE, BEYOND, LEAK or WRONG, with
 * the same meanings. `hint`: the tracer's closest hit, which the query probably hit too; or NULL. False when
 * out of memory. */
bool verdict_any(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                 bool met, const verdict_answer *hint, search_result *room, verdict *out);

/* ---- verdict_bound.c: forward error bounds: constant × condition number × unit roundoff ---- */

typedef struct verdict_bound {
    double t;     /* of t, in its units */
    double edge;  /* of oracle_answer.edge */
    double aside; /* of the ray's position at the primitive, in world coordinates */
    double weight,
        normal; /* of u and v; of the normal's direction, in radians. Only verdict_bound_all() sets them */
} verdict_bound;

/* The bound for an answer that is not `parallel`. */
verdict_bound verdict_bound_of(const verdict_tracer *tracer, const oracle_ray *ray,
                               const oracle_primitive *primitive, const oracle_answer *answer);

/* The bound of a reported t: verdict_bound.t, or infinity if rounding leaves the tracer without a usable
 * normal. */
double verdict_reported(const verdict_tracer *tracer, const oracle_primitive *primitive,
                        const verdict_bound *bound);

/* The largest verdict_bound.aside of any primitive within `extent` of the world's origin. */
double verdict_aside(const verdict_tracer *tracer, const world *w, const oracle_ray *ray, double extent);

/* True when rounding may move a ray that is exactly parallel to the primitive's plane into that plane. */
bool verdict_in_plane(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *primitive);

/* True when this intersection exceeds the tracer's floats: t is above the largest float, or a coordinate of
 * the primitive or of the ray (in any space) is above verdict_tracer.largest. */
bool verdict_beyond(const verdict_tracer *tracer, const world *w, const oracle_ray *ray,
                    const oracle_primitive *primitive, double t);

/* The error of t that is allowed whatever its condition: VERDICT_ULPS (at least those of double), plus
 * flushed denormals. */
double verdict_rounding(const verdict_tracer *tracer, double t);

/* Like verdict_bound_of(), and also sets `weight` and `normal`, for a hit that lies on the primitive. */
verdict_bound verdict_bound_all(const verdict_tracer *tracer, const oracle_ray *ray,
                                const oracle_primitive *primitive, const oracle_answer *answer);

/* The constants, for reports. */
double verdict_constant(oracle_shape shape);
