/* Between bodies.c, which finds the bodies, and bodies_around.c, which looks around them. */
#ifndef TRACE_BODIES_FINDER_H
#define TRACE_BODIES_FINDER_H

#include "scene/mesh/closed.h"
#include "trace/watertight/bodies.h"

/* Bodies and instances whose surroundings are looked at, a few microseconds each. */
#define LOOKS_MOST 1024
/* Points on each. */
#define SAMPLES 8

typedef struct sample {
    uint32_t geometry, primitive;
} sample;

typedef struct owned_box {
    body_box box;
    uint32_t owner; /* a geometry, or an instance: these count on after all geometries */
} owned_box;

typedef struct finder {
    bodies *out;
    const world *world;
    const trace_retry *retry;
    closed_how *closed;         /* by geometry */
    sample (*samples)[SAMPLES]; /* by body */
    ARRAY(owned_box) boxes;     /* around closed bodies of the group at hand */
    unsigned looks;
    trace_crossings room;
} finder;

/* The k-th point on the sample's surface, spread over it. */
vec3_f32 finder_point(const world *w, const sample *at, unsigned k);

static inline uint32_t finder_body(const finder *f, uint32_t geometry, uint32_t primitive) {
    return (uint32_t)(bodies_at(f->out, geometry, primitive) - f->out->all);
}

/* Bodies around a point before the crossing less those around one behind it: -1, 0 or 1. */
int bodies_step_out(const bodies *b, const trace_crossing *c);

/* Sets what lies around all bodies and instances, and boxes. False when out of memory. */
bool finder_around(finder *f);

#endif
