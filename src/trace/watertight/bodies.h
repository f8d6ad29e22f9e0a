/* Closed bodies are the connected pieces of closed meshes. This module finds them, and how many of them lie
 * around each surface that a ray can hit. */
#pragma once

#include "scene/mesh/closed.h"
#include "trace/tracer.h"

/* The outer side of a body, by the order of its corners. */
typedef enum facing { FACING_NONE, FACING_OUT, FACING_IN } facing;

/* Minimum and maximum number of closed bodies around something. */
#define BODIES_ANY 255
typedef struct depth_span {
    uint8_t low, high;
} depth_span;

/* One piece of a closed mesh. Also an open mesh, a sphere or a quad: these have FACING_NONE. */
typedef struct trace_body {
    facing facing;
    bool casts;        /* shadows, all of it */
    depth_span around; /* number of other bodies of its group, in front of its surface */
} trace_body;

typedef struct geometry_bodies {
    uint32_t first, count; /* in `all` */
    uint32_t *of_vertex;   /* mesh of several pieces: the piece of each vertex */
    bool vague;  /* one body represents several pieces or primitives, so the number of bodies around it varies
                  */
    bool closed; /* some of its bodies are closed */
    bool nested; /* some of its bodies lie inside other bodies of the group */
} geometry_bodies;

/* Bounding box of some closed bodies, in world space. */
typedef struct body_box {
    vec3_f32 lower, upper;
    uint8_t count; /* of bodies in it; BODIES_ANY: any number */
} body_box;

/* With more boxes than this, one box is used for all: testing each would take longer. */
#define BODIES_BOXES 16

typedef struct bodies {
    const trace_tracer *tracer;
    geometry_bodies *of; /* by the world's geometries */
    trace_body *all;
    size_t count;
    depth_span *around; /* by instance: number of bodies around the whole instance */
    body_box boxes[BODIES_BOXES];
    unsigned box_count;
} bodies;

/* For tracers with `retry`; the tracer must outlive `out`. out->all is NULL if nothing is closed. False when
 * out of memory; call bodies_release() in any case. */
bool bodies_find(const trace_tracer *tracer, bodies *out);
void bodies_release(bodies *b);

static inline const trace_body *bodies_at(const bodies *b, uint32_t geometry, uint32_t primitive) {
    const geometry_bodies *of = &b->of[geometry];
    if (of->count < 2) return &b->all[of->first];
    if (!of->of_vertex) return &b->all[of->first + primitive];
    return &b->all[of->first +
                   of->of_vertex[world_mesh(b->tracer->world, geometry)->indices[3 * (size_t)primitive]]];
}

/* Irregular directions, unlikely to match a pattern in a scene. A line hits an edge or a vertex with a
 * probability of about 10^-5, so most of the five never do. */
#define BODIES_PROBES 5
extern const float bodies_probes[BODIES_PROBES][3];

/* How many closed bodies lie around a point: of those that cast shadows, and of others. */
typedef struct body_counts {
    int casting, other;
} body_counts;

/* Computed from the list of all crossings from the point in one direction: exits minus entries. */
body_counts bodies_around(const bodies *b, const trace_crossings *list);

/* ---- shared by bodies.c (finds the bodies) and bodies_around.c (counts bodies around them) ---- */

/* Maximum number of bodies and instances whose surroundings are sampled, a few microseconds each. */
#define LOOKS_MOST 1024
/* Sample points on each. */
#define SAMPLES 8

typedef struct sample {
    uint32_t geometry, primitive;
} sample;

typedef struct owned_box {
    body_box box;
    uint32_t owner; /* index of a geometry, or number of geometries + index of an instance */
} owned_box;

typedef struct finder {
    bodies *out;
    const world *world;
    const trace_retry *retry;
    closed_how *closed;         /* by geometry */
    sample (*samples)[SAMPLES]; /* by body */
    ARRAY(owned_box) boxes;     /* around closed bodies of the current group */
    unsigned looks;
    trace_crossings room;
} finder;

/* The k-th point on the sample's surface, spread over it. */
vec3_f32 finder_point(const world *w, const sample *at, unsigned k);

static inline uint32_t finder_body(const finder *f, uint32_t geometry, uint32_t primitive) {
    return (uint32_t)(bodies_at(f->out, geometry, primitive) - f->out->all);
}

/* Number of bodies around a point before the crossing minus that behind it: -1, 0 or 1. */
int bodies_step_out(const bodies *b, const trace_crossing *c);

/* Sets `around` of all bodies and instances, and the boxes. False when out of memory. */
bool finder_around(finder *f);
