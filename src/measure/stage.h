/* A scene that is built once and rendered repeatedly, with the rendering timed separately. */
#pragma once

#include "integrate/integrator.h"
#include "scene/world/world.h"
#include "trace/trace.h"

#include <fathom/render.h>

/* Seconds of processor time of all threads together, and wall-clock seconds. Processor time is more reliable
 * while other work shares the machine. */
typedef enum bench_clock { BENCH_CPU, BENCH_WALL, BENCH_CLOCKS } bench_clock;

typedef struct bench_seconds {
    double by[BENCH_CLOCKS];
} bench_seconds;

bench_seconds bench_now(void);
bench_seconds bench_since(const bench_seconds *start);

typedef struct bench_stage {
    fathom_scene *scene;
    world *world;
    trace_tracer *tracer; /* NULL until stage_build() */
    fathom_settings settings;
    bench_seconds build; /* of the tracer only */
} bench_stage;

/* Always takes ownership of the scene: release with stage_close(), whatever the status. The whole image is
 * rendered, without AOVs. */
fathom_status stage_open(fathom_context *context, fathom_scene *scene, const fathom_settings *settings,
                         bench_stage *out);
/* Builds the settings' tracer, as for a long render. */
fathom_status stage_build(fathom_context *context, bench_stage *stage);
void stage_close(bench_stage *stage);

typedef struct stage_shot {
    fathom_pattern pattern;
    uint32_t spp;
    uint64_t seed;
} stage_shot;

typedef struct stage_cost {
    double plan;           /* wall-clock seconds before the first ray */
    bench_seconds seconds; /* only generating, tracing, shading and summing */
    ray_counts rays;
} stage_cost;

/* One complete render, with its own plan, into a film that matches the settings. recorded: NULL, or the
 * record that the tracer fills: the plan's rays are removed from it. */
struct job_options;
struct record;
fathom_status stage_film(fathom_context *context, const world *w, const trace_tracer *tracer,
                         const fathom_settings *settings, const struct job_options *options,
                         fathom_film *film, struct record *recorded, stage_cost *cost);

/* rgb: room for three planes of the image; may be NULL. progress as in fathom_render(). */
fathom_status stage_render(fathom_context *context, const bench_stage *stage, const stage_shot *shot,
                           fathom_progress_fn progress, void *user, float *rgb, stage_cost *cost);
