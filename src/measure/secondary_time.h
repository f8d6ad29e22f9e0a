/* A render's rays by depth and kind: its own way of tracing them against single-ray calls and others. */
#ifndef BENCH_SECONDARY_TIME_H
#define BENCH_SECONDARY_TIME_H

#include "measure/secondary_rays.h"
#include "measure/statistics.h"
#include "measure/watch.h"

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
