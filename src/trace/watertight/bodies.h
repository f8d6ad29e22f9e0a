/* Closed bodies: the connected pieces of closed meshes, which divide space, and how many of them lie around
 * everything that a ray can meet. */
#ifndef TRACE_BODIES_H
#define TRACE_BODIES_H

#include "scene/mesh/closed.h"
#include "trace/tracer.h"

/* The outer side of a body, by the order of its corners. */
typedef enum facing { FACING_NONE, FACING_OUT, FACING_IN } facing;

/* The least and the largest number of closed bodies around something. */
#define BODIES_ANY 255
typedef struct depth_span {
    uint8_t low, high;
} depth_span;

/* One piece of a closed mesh; or an open mesh, a sphere, a quad: these face nowhere. */
typedef struct trace_body {
    facing facing;
    bool casts;        /* shadows, all of it */
    depth_span around; /* other bodies of its group, in front of its surface */
} trace_body;

typedef struct geometry_bodies {
    uint32_t first, count; /* in `all` */
    uint32_t *of_vertex;   /* a mesh of several pieces: the one of each vertex */
    bool vague;            /* one body for what may lie in several places: anything may be around it */
    bool closed;           /* some of them are */
    bool nested;           /* some of them lie inside of other bodies of the group */
} geometry_bodies;

/* A box around some closed bodies, as placed. */
typedef struct body_box {
    vec3_f32 lower, upper;
    uint8_t count; /* of bodies in it; BODIES_ANY: any number */
} body_box;

/* With more boxes than this, one holds them all: looking into each would take longer. */
#define BODIES_BOXES 16

typedef struct bodies {
    const trace_tracer *tracer;
    geometry_bodies *of; /* by the world's geometries */
    trace_body *all;
    size_t count;
    depth_span *around; /* by instance: outside of it */
    body_box boxes[BODIES_BOXES];
    unsigned box_count;
} bodies;

/* For tracers with `retry`, which must outlive it. `all` is NULL where nothing is closed. False when out of
 * memory; release in any case. */
bool bodies_find(const trace_tracer *tracer, bodies *out);
void bodies_release(bodies *b);

static inline const trace_body *bodies_at(const bodies *b, uint32_t geometry, uint32_t primitive) {
    const geometry_bodies *of = &b->of[geometry];
    if (of->count < 2) return &b->all[of->first];
    if (!of->of_vertex) return &b->all[of->first + primitive];
    return &b->all[of->first +
                   of->of_vertex[world_mesh(b->tracer->world, geometry)->indices[3 * (size_t)primitive]]];
}

/* Directions without a pattern that scenes share. A line meets an edge or a vertex with a probability of some
 * 10^-5, so of five it is never most. */
#define BODIES_PROBES 5
extern const float bodies_probes[BODIES_PROBES][3];

/* How many closed bodies lie around a point: of those that cast shadows, and of others. */
typedef struct body_counts {
    int casting, other;
} body_counts;

/* By the list of all crossings from the point in one direction: ways out less ways in. */
body_counts bodies_around(const bodies *b, const trace_crossings *list);

/* ---- between bodies.c, which finds the bodies, and bodies_around.c, which looks around them ---- */

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
