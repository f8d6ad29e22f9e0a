/* Judges a tracer's answer by the exact one. */
#ifndef PARITY_VERDICT_H
#define PARITY_VERDICT_H

#include "trace/spec.h"
#include "verify/search/search.h"

typedef enum verdict {
    VERDICT_AGREE,       /* the oracle's primitive, t within VERDICT_ULPS; or a miss where it says miss */
    VERDICT_TIE,         /* another primitive, whose exact t is the same or too near for the precision */
    VERDICT_EDGE,        /* right for a ray moved by less than the precision can tell, past an edge */
    VERDICT_RANGE,       /* t too near an end of the interval for the precision */
    VERDICT_CONDITIONED, /* the oracle's primitive, t off by no more than the bound of verdict_bound.h */
    VERDICT_BEYOND,      /* numbers that leave the range of the tracer's floats: see verdict_beyond() */
    VERDICT_LEAK, /* what a tracer is known to miss: a surface at an edge or vertex though it goes on at the
                     other side; by directions whose reciprocals it clamps */
    VERDICT_WRONG,
    VERDICT_COUNT
} verdict;

/* "agree" … */
const char *verdict_name(verdict v);

/* t may be off by so many units of its own rounding before its condition matters. */
#define VERDICT_ULPS 2

typedef struct verdict_tracer {
    double unit;   /* roundoff of its arithmetic: 2^-24 for float */
    bool inverted; /* inverts to_world itself, as Embree does */
    bool leaks;    /* misses surfaces at edges and vertices; else that is wrong */
    unsigned
        seen; /* bit i: oracle_shape i, whose sides it forms from corners as seen from the ray's origin */
    double clamped; /* components of directions below this count as this where boxes are tested; 0: none */
    bool strict;    /* its own t lies in the open interval, for the shapes that are not `seen` */
    double largest; /* takes no ray and no primitive with a coordinate above; 0: any float */
} verdict_tracer;

/* The tracer's answer: ids as in trace_hits, geometry FATHOM_NONE for a miss. */
typedef struct verdict_answer {
    uint32_t geometry, primitive, instance;
    double t, t_low; /* their sum: as the tracer computed it */
} verdict_answer;

typedef struct verdict_report {
    verdict verdict;
    bool measured;    /* the line meets the primitive, so that t has an error; what follows is set */
    double exact_t;   /* of the primitive that the tracer named */
    double t_error;   /* |t - exact_t| */
    double t_signed;  /* t - exact_t */
    double bound;     /* that t was held against */
    double condition; /* of exact_t: a relative change of u in all inputs moves it by at most u times this */
    oracle_primitive primitive;
    oracle_answer exact;
} verdict_report;

/* The properties of a tracer by its specification. */
verdict_tracer verdict_tracer_of(const trace_spec *spec, double unit);

/* Judges one closest hit. `room` is for searches and is written over. False when out of memory. */
bool verdict_closest(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                     const verdict_answer *answer, search_result *room, verdict_report *out);

/* Judges whether anything that casts a shadow is met: AGREE, EDGE, RANGE, BEYOND, LEAK or WRONG, with the
 * same meanings. `hint`: the tracer's closest hit, which is likely what it met; or NULL. False when out of
 * memory. */
bool verdict_any(const search *s, const world *w, const verdict_tracer *tracer, const oracle_ray *ray,
                 bool met, const verdict_answer *hint, search_result *room, verdict *out);

/* ---- verdict_bound.c: forward error bounds, each a constant times a condition number times the unit
 * roundoff ----
 */

typedef struct verdict_bound {
    double t;     /* of t, in its units */
    double edge;  /* of oracle_answer.edge */
    double aside; /* in world coordinates, of where the ray passes */
    double weight,
        normal; /* of u and v; of the normal's direction in radians: verdict_bound_all() sets them */
} verdict_bound;

/* The bound for an answer that is not parallel. */
verdict_bound verdict_bound_of(const verdict_tracer *tracer, const oracle_ray *ray,
                               const oracle_primitive *primitive, const oracle_answer *answer);

/* The bound of a reported t: verdict_bound.t, or infinite where the tracer has lost the normal. */
double verdict_reported(const verdict_tracer *tracer, const oracle_primitive *primitive,
                        const verdict_bound *bound);

/* The largest verdict_bound.aside of anything within `extent` of the world's origin. */
double verdict_aside(const verdict_tracer *tracer, const world *w, const oracle_ray *ray, double extent);

/* True when rounding may bring a ray that is exactly parallel to the primitive's plane into it. */
bool verdict_in_plane(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *primitive);

/* True when the tracer's floats cannot hold what this intersection takes: t above the largest of them, or a
 * coordinate above what it takes, of the ray in any space of the world or of the primitive. */
bool verdict_beyond(const verdict_tracer *tracer, const world *w, const oracle_ray *ray,
                    const oracle_primitive *primitive, double t);

/* The error of t allowed whatever its condition: VERDICT_ULPS, of a double at least, and flushed
 * denormals. */
double verdict_rounding(const verdict_tracer *tracer, double t);

/* The ray's direction in the primitive's space. */
vec3_f32 verdict_object_direction(const oracle_ray *ray, const oracle_primitive *primitive);

/* Also sets `weight` and `normal`, of a hit that lies on the primitive. */
verdict_bound verdict_bound_all(const verdict_tracer *tracer, const oracle_ray *ray,
                                const oracle_primitive *primitive, const oracle_answer *answer);

/* True when every intersector gets this t without rounding: the ray runs along an axis by a power of two and
 * meets, at right angles, a primitive with few digits whose weights have few, too. Then the ends of the
 * interval are not in doubt either. */
bool verdict_is_exact(const verdict_tracer *tracer, const oracle_ray *ray, const oracle_primitive *primitive,
                      const oracle_answer *answer);

/* The constants, for reports. */
double verdict_constant(oracle_shape shape);

#endif
