/* A tracer's specification in words: "linear:f64", "embree:user:high:16", "./mine.so". A kind, then
 * options in any order, at most one of each sort. */
#ifndef TRACE_SPEC_H
#define TRACE_SPEC_H

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
    TRACE_SHAPES_TRIANGLES, /* Embree's triangles, in robust scenes two for each quad; spheres ours */
    TRACE_SHAPES_USER       /* all ours */
} trace_shapes;

typedef enum trace_scene_flags {
    TRACE_SCENE_ROBUST,
    TRACE_SCENE_DEFAULT,
    TRACE_SCENE_COMPACT
} trace_scene_flags;

/* Build time against tracing time. No settled hit depends on it. */
typedef enum trace_quality {
    TRACE_QUALITY_AUTO, /* by expected_rays */
    TRACE_QUALITY_LOW,
    TRACE_QUALITY_MEDIUM,
    TRACE_QUALITY_HIGH
} trace_quality;

/* How rays reach Embree. No packet is wider than the processor's kernels. */
typedef enum trace_calls {
    TRACE_CALLS_AUTO, /* by trace_options.width */
    TRACE_CALLS_1,
    TRACE_CALLS_4,
    TRACE_CALLS_8,
    TRACE_CALLS_16
} trace_calls;

typedef enum trace_ties {
    TRACE_SETTLED, /* one answer, however rays are grouped: embree_settle.c */
    TRACE_RAW      /* Embree's answers as they are */
} trace_ties;

typedef struct trace_spec {
    trace_kind kind;
    trace_precision precision; /* linear, bvh */
    trace_shapes shapes;       /* embree, like all fields that follow */
    trace_scene_flags flags;
    trace_quality quality;
    trace_calls calls;
    trace_ties ties;
    isa_set isa;      /* the most that Embree may use; the processor may have less */
    const char *path; /* plugin: as given; not owned */
} trace_spec;

/* FATHOM_BAD_USAGE says which word is wrong and which there are. A text that ends in ".so" is a file; `text`
 * must then outlive `out`. "reference" is "linear", NULL "embree". */
fathom_status trace_spec_parse(fathom_context *context, const char *text, trace_spec *out);

#endif
