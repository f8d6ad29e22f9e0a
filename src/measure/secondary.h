/* The rays of a render by depth and kind, and what each way of tracing them costs. */
#ifndef BENCH_SECONDARY_H
#define BENCH_SECONDARY_H

#include "integrate/plan.h"
#include "measure/replay.h"
#include "measure/statistics.h"

/* Camera rays and eight bounces; deeper rays are left out. */
#define SECONDARY_DEPTHS 9

typedef enum secondary_kind {
    SECONDARY_CAMERA, /* depth 0 alone */
    SECONDARY_MIRRORED,
    SECONDARY_REFRACTED,
    SECONDARY_SHADOW, /* from the hits of the depth's rays */
    SECONDARY_KINDS
} secondary_kind;

const char *secondary_name(secondary_kind kind);

/* Each call as the render makes it, but for one that holds both kinds, which becomes two. */
typedef struct secondary_rays {
    record of[SECONDARY_DEPTHS][SECONDARY_KINDS];
} secondary_rays;

/* The first samples of waves from all over the image, until each depth and kind has `enough` or the image
 * ends. The plan's tracer is the real one. Release with secondary_free(). */
fathom_status secondary_record(fathom_context *context, const render_plan *plan, uint64_t enough,
                               secondary_rays *out);
void secondary_free(secondary_rays *rays);

/* The rays of each call in the order of their directions' octants, within these of their origins along a
 * Morton curve. False when out of memory. */
bool secondary_sorted(const record *from, record *out);

/* ---- the render's own way of tracing them against single-ray calls and others ---- */

#define SECONDARY_REPEATS_MAX 1000

typedef enum secondary_way {
    SECONDARY_RENDER, /* trace_closest() and trace_any(), as the render calls them */
    SECONDARY_SINGLE, /* the others are Embree's calls alone: one ray each */
    SECONDARY_4,
    SECONDARY_8,
    SECONDARY_8_COHERENT, /* the kernels for coherent packets */
    SECONDARY_16,
    SECONDARY_16_COHERENT,
    SECONDARY_RENDER_SORTED, /* the same rays sorted beforehand, which is not timed */
    SECONDARY_SINGLE_SORTED,
    SECONDARY_WAYS
} secondary_way;

const char *secondary_way_name(secondary_way way);

/* Processor time of one thread. */
typedef struct secondary_row {
    uint32_t depth;
    secondary_kind kind;
    uint64_t rays, met;           /* met: by single rays */
    quartiles ns[SECONDARY_WAYS]; /* a ray */
    quartiles to_single;          /* the render's way over single rays, repetition by repetition */
} secondary_row;

typedef struct secondary_time {
    secondary_row rows[SECONDARY_DEPTHS * SECONDARY_KINDS];
    size_t count; /* of those that have rays */
} secondary_time;

/* The tracer must have a bare form; watch may be NULL. */
fathom_status secondary_measure(fathom_context *context, const trace_tracer *tracer,
                                const secondary_rays *rays, unsigned repeats, const bench_watch *watch,
                                secondary_time *out);

#endif
