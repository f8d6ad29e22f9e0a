/* A tracer's specification as text: "linear:f64", "embree:user:high:16", "./mine.so". A kind, then options in
 * any order, at most one per field of trace_spec. */
#pragma once

#include "base/isa.h"
#include "base/status.h"

typedef enum trace_kind {
    TRACE_LINEAR, /* every ray against every primitive */
    TRACE_BVH,    /* the hand-written bounding volume hierarchy */
    TRACE_EMBREE,
    TRACE_PLUGIN /* a shared library: fathom/plugin.h */
} trace_kind;

typedef enum trace_precision { TRACE_F32, TRACE_F64, TRACE_F128 } trace_precision;

/* The intersector of each shape: Embree's own, or ours as user geometry. */
typedef enum trace_shapes {
    TRACE_SHAPES_TRIANGLES, /* Embree's triangles, in robust scenes also two for each quad; spheres ours */
    TRACE_SHAPES_USER       /* all ours */
} trace_shapes;

typedef enum trace_scene_flags {
    TRACE_SCENE_ROBUST,
    TRACE_SCENE_DEFAULT,
    TRACE_SCENE_COMPACT
} trace_scene_flags;

/* Trades build time for tracing time. Settled hits do not depend on it. */
typedef enum trace_quality {
    TRACE_QUALITY_AUTO, /* by expected_rays */
    TRACE_QUALITY_LOW,
    TRACE_QUALITY_MEDIUM,
    TRACE_QUALITY_HIGH
} trace_quality;

/* Rays per Embree call. No packet is wider than the processor's kernels. */
typedef enum trace_calls {
    TRACE_CALLS_AUTO, /* by trace_options.width */
    TRACE_CALLS_1,
    TRACE_CALLS_4,
    TRACE_CALLS_8,
    TRACE_CALLS_16
} trace_calls;

typedef enum trace_ties {
    TRACE_SETTLED, /* the hit does not depend on the grouping of rays: embree_settle.c */
    TRACE_RAW      /* Embree's hits, unchanged */
} trace_ties;

typedef struct trace_spec {
    trace_kind kind;
    trace_precision precision; /* linear, bvh */
    trace_shapes shapes;       /* embree, like all fields that follow */
    trace_scene_flags flags;
    trace_quality quality;
    trace_calls calls;
    trace_ties ties;
    isa_set isa;      /* the widest that Embree may use; the processor may have less */
    const char *path; /* plugin: as given; not owned */
} trace_spec;

/* FATHOM_BAD_USAGE: the message names the wrong word and lists the valid ones. A text that ends in ".so" is a
 * file name; `text` must then outlive `out`. "reference" means "linear", NULL "embree". */
fathom_status trace_spec_parse(fathom_context *context, const char *text, trace_spec *out);
