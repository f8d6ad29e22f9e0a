/* What the files of `fathom validate` share. */
#ifndef CLI_VALIDATE_H
#define CLI_VALIDATE_H

#include "cli/args.h"
#include "verify/compare.h"
#include "verify/extremes/extremes.h"
#include "verify/light/shading.h"

#include <jansson.h>

typedef struct validate_settings {
    const char *scene; /* NULL: the built-in ones */
    args_list tracers;
    uint64_t rays, seed;
    uint64_t sample;
    bool isa;          /* Embree once with each instruction set */
    unsigned families; /* bit i: rays_family i */
    unsigned threads;
    const char *json, *failures, *replay, *report;
    bool quiet, verbose, allow_outside;
    bool extremes;      /* the grid of extreme cases besides */
    bool tracers_given; /* else `tracers` are the default ones */
} validate_settings;

/* One tracer over one scene. */
typedef struct validate_run {
    char *scene, *spec; /* as asked for */
    char tracer[64];    /* as the tracer calls itself */
    compare_result result;
    double seconds;
} validate_run;

typedef ARRAY(validate_run) validate_runs;

/* All that was found. */
typedef struct validate_results {
    validate_runs runs;
    extremes_rows extremes;
    extremes_failures extremes_failures;
    shading_rows shading;
    shading_images images;
} validate_results;

/* A scene and what is made of it. */
typedef struct validate_stage {
    fathom_scene *scene;
    world *world;
    search *search;
    rays_source *source;
    extremes_scene *extreme; /* not NULL: it owns all of the above */
} validate_stage;

/* Names of extreme cases: this, the group, a colon, the number. */
#define VALIDATE_EXTREME "extreme:"

/* ---- validate_stage.c ---- */

/* `name`: a built-in scene, an extreme case or a file. Release with validate_stage_close() whatever comes
 * back. */
fathom_status validate_stage_open(fathom_context *context, const char *name, validate_stage *out);
void validate_stage_close(validate_stage *stage);
/* text must outlive the subject; release its tracer with trace_destroy(). */
fathom_status validate_subject(fathom_context *context, const validate_stage *stage, const char *text,
                               compare_subject *out, trace_tracer **tracer);

/* ---- validate_print.c ---- */
compare_family validate_sum(const validate_run *run);
/* Spent tracing closest hits, by one thread. */
double validate_ns_per_ray(const validate_run *run);
void validate_print(const validate_runs *runs, const validate_settings *settings);
/* To --json and --report, whichever was asked for. */
fathom_status validate_write_json(fathom_context *context, const validate_results *results,
                                  const validate_settings *settings);

/* ---- validate_isa.c ---- */

/* Room for the words of tracers. */
typedef struct validate_isas {
    char text[ARGS_LIST_MAX][256];
} validate_isas;

/* Takes each tracer of Embree's apart into one for each instruction set that the processor has. `room` must
 * outlive the settings. */
fathom_status validate_each_isa(fathom_context *context, validate_settings *settings, validate_isas *room);
/* "AVX2"; NULL for other tracers than Embree. */
const char *validate_isa_of(const validate_run *run);
void validate_print_isas(const validate_runs *runs);

/* ---- validate_failures.c ---- */
fathom_status validate_write_failures(fathom_context *context, const validate_results *results,
                                      const validate_settings *settings);
/* The first rays with a wrong answer, each as a line of --failures. */
json_t *validate_failures_json(const validate_run *run);
/* FATHOM_CHECK_FAILED when any ray's answer is still wrong. */
fathom_status validate_replay(fathom_context *context, const validate_settings *settings);

/* ---- validate_report.c ---- */

/* Whether the page can be written, before any work is done for it. */
fathom_status validate_check_report(fathom_context *context, const validate_settings *settings);

#endif
