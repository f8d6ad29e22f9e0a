/* Shared by the files of `fathom validate`. */
#pragma once

#include "cli/command.h"
#include "cli/json_text.h"
#include "verify/compare.h"
#include "verify/extremes/case.h"
#include "verify/light/shading.h"
#include "verify/recorded.h"
#include "verify/statistics.h"

typedef struct validate_settings {
    command_common common;
    const char *scene; /* NULL: the built-in ones */
    args_list tracers;
    uint64_t rays, seed;
    uint64_t sample;
    double power; /* error rate to detect by comparing two tracers; 0: none; < 0: times the default, with a
                     limit */
    bool heavy;
    unsigned families; /* bit i: rays_family i */
    unsigned threads;  /* threads that check rays */
    const char *json, *failures, *replay, *report;
    bool verbose;
    bool light;         /* check laws of light instead of rays */
    double light_error; /* standard error of these checks */
    const char *light_only;
    bool extremes;      /* also run the grid of extreme cases */
    bool tracers_given; /* false: `tracers` are the default ones */
} validate_settings;

/* One tracer over one scene. */
typedef struct validate_run {
    char *scene, *spec; /* as requested */
    char tracer[64];    /* name that the tracer reports */
    trace_spec kind;    /* points into `spec` for its path */
    double unit;        /* unit roundoff that the tracer declares */
    compare_result result;
    statistics_findings findings;
    double seconds;
} validate_run;

typedef ARRAY(validate_run) validate_runs;

/* A built-in scene that a tracer does not support. */
typedef struct validate_skip {
    char spec[128], scene[32];
} validate_skip;

/* All results. */
typedef struct validate_results {
    validate_runs runs;
    ARRAY(validate_skip) skips;
    extremes_rows extremes;
    extremes_failures extremes_failures;
    shading_rows shading;
    double start; /* clock_seconds() at the start */
} validate_results;

/* Name of an extreme case: this prefix, the group, a colon, the number. */
#define VALIDATE_EXTREME "extreme:"

/* ---- validate_run.c ---- */

/* Checks all tracers over all scenes. Appends their runs, and the scenes that a tracer does not support. */
fathom_status validate_run_all(fathom_context *context, const validate_settings *settings,
                               validate_results *results);

/* ---- validate_stage.c ---- */

/* `name`: a built-in scene, an extreme case or a file. Release with judged_close(), whatever the status. */
fathom_status validate_stage_open(fathom_context *context, const char *name, judged_scene *out);
/* text must outlive the subject; release its tracer with trace_destroy(). */
fathom_status validate_subject(fathom_context *context, const judged_scene *stage, const char *text,
                               compare_subject *out, trace_tracer **tracer);

/* Other tracers of the same kind, over another scene. They exist before, next to and after the checked
 * tracer; one more is built repeatedly at the same time. They reveal state that builds share by mistake. */
typedef struct validate_decoys validate_decoys;
/* Call validate_decoys_begin() before the checked tracer is created, and validate_decoys_add() after. The
 * text must outlive the decoys. */
fathom_status validate_decoys_begin(fathom_context *context, const char *text, validate_decoys **out);
fathom_status validate_decoys_add(fathom_context *context, validate_decoys *decoys);
/* Waits for the building thread. NULL is allowed. */
void validate_decoys_end(validate_decoys *decoys);

/* ---- validate_print.c ---- */
compare_family validate_sum(const validate_run *run);
/* The sum of all runs of the tracer whose first run is at `first`; *end: index after its last run. */
compare_family validate_sum_tracer(const validate_runs *runs, size_t first, size_t *end);
/* Prints a line that begins with "found: " for everything that makes the exit code 1. */
void validate_print_findings(const validate_results *results);
/* {"agree": n, …} */
json_t *validate_verdicts_json(const uint64_t counts[VERDICT_COUNT]);
void validate_print(const validate_runs *runs, const validate_settings *settings);
/* Writes --json and --report, if requested. */
fathom_status validate_write_json(fathom_context *context, const validate_results *results,
                                  const validate_settings *settings);

/* ---- validate_failures.c ---- */
fathom_status validate_write_failures(fathom_context *context, const validate_results *results,
                                      const validate_settings *settings);
/* The first rays with a wrong result, each as a line of --failures. */
json_t *validate_failures_json(const validate_run *run);
/* FATHOM_CHECK_FAILED: the result of a ray is still wrong. */
fathom_status validate_replay(fathom_context *context, const validate_settings *settings);

/* ---- validate_extremes.c ---- */

/* Runs the grid of extreme cases with the settings' tracers, or with its own default tracers if none are
 * named. Appends rows, and failures if --failures is given. */
fathom_status validate_extremes_run(fathom_context *context, const validate_settings *settings,
                                    validate_results *results);
/* Sum over all rows. */
uint64_t validate_extremes_total(const extremes_rows *rows, verdict v);
void validate_extremes_print(const extremes_rows *rows, const validate_settings *settings);
/* The list "extremes" of --json. */
json_t *validate_extremes_json(const extremes_rows *rows);

/* ---- validate_light.c ---- */

/* Compares the path integrator with closed forms of light, or in a scene with the reference integrator.
 * FATHOM_CHECK_FAILED: a law is broken, or noise is too high to decide. */
fathom_status validate_light(fathom_context *context, const validate_settings *settings);

/* ---- validate_shading.c ---- */

/* Renders all cases of stiff shading with each of the settings' tracers, except tracers from libraries, which
 * support only triangles. Appends rows. */
fathom_status validate_shading_run(fathom_context *context, const validate_settings *settings,
                                   validate_results *results);
/* Number of rows outside their bounds. */
uint64_t validate_shading_wrong(const shading_rows *rows);
void validate_shading_print(const shading_rows *rows, const validate_settings *settings);
/* The list "shading" of --json. */
json_t *validate_shading_json(const shading_rows *rows);
