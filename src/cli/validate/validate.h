/* Shared by the files of `fathom validate`. */
#ifndef CLI_VALIDATE_H
#define CLI_VALIDATE_H

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
    double power; /* a rate of errors that is to be found by asking two tracers; 0: none */
    bool heavy;
    unsigned families; /* bit i: rays_family i */
    unsigned threads;  /* that judge */
    const char *json, *failures, *replay, *report;
    bool verbose;
    bool light;         /* laws of light instead of rays */
    double light_error; /* the standard error they are held to */
    const char *light_only;
    bool extremes;      /* also the grid of extreme cases */
    bool tracers_given; /* else `tracers` are the default ones */
} validate_settings;

/* One tracer over one scene. */
typedef struct validate_run {
    char *scene, *spec; /* as asked for */
    char tracer[64];    /* as the tracer calls itself */
    trace_spec kind;    /* its path is in `spec` */
    double unit;        /* roundoff, as declared */
    compare_result result;
    statistics_findings findings;
    double seconds;
} validate_run;

typedef ARRAY(validate_run) validate_runs;

/* A built-in scene that a tracer cannot hold. */
typedef struct validate_skip {
    char spec[128], scene[32];
} validate_skip;

/* All that was found. */
typedef struct validate_results {
    validate_runs runs;
    ARRAY(validate_skip) skips;
    extremes_rows extremes;
    extremes_failures extremes_failures;
    shading_rows shading;
    shading_images images;
    double start; /* clock_seconds() */
} validate_results;

/* Names of extreme cases: this, the group, a colon, the number. */
#define VALIDATE_EXTREME "extreme:"

/* ---- validate_run.c ---- */

/* Judges all tracers over all scenes and appends their runs, and what a tracer cannot hold. */
fathom_status validate_run_all(fathom_context *context, const validate_settings *settings,
                               validate_results *results);

/* ---- validate_stage.c ---- */

/* `name`: a built-in scene, an extreme case or a file. Release with judged_close() whatever comes
 * back. */
fathom_status validate_stage_open(fathom_context *context, const char *name, judged_scene *out);
/* text must outlive the subject; release its tracer with trace_destroy(). */
fathom_status validate_subject(fathom_context *context, const judged_scene *stage, const char *text,
                               compare_subject *out, trace_tracer **tracer);
/* True when the tracer takes such shapes: a library takes triangles. (Planes next to it are answered in
 * float.)
 */
bool validate_holds(const world *w, const trace_spec *spec);

/* Tracers of the same kind over another scene, which live before, next to and after the one that is judged,
 * and one that is built again and again meanwhile: what builds share would show. */
typedef struct validate_decoys validate_decoys;
/* Called before and after the judged tracer is made. The text must outlive it. */
fathom_status validate_decoys_begin(fathom_context *context, const char *text, validate_decoys **out);
fathom_status validate_decoys_add(fathom_context *context, validate_decoys *decoys);
/* Waits for the thread that builds. NULL is allowed. */
void validate_decoys_end(validate_decoys *decoys);

/* ---- validate_print.c ---- */
compare_family validate_sum(const validate_run *run);
/* All runs of the tracer whose first run is at `first`; *end: behind the last. */
compare_family validate_sum_tracer(const validate_runs *runs, size_t first, size_t *end);
/* A line that begins with "found: " for everything that makes the exit code 1. */
void validate_print_findings(const validate_results *results);
/* {"agree": n, …} */
json_t *validate_verdicts_json(const uint64_t counts[VERDICT_COUNT]);
void validate_print(const validate_runs *runs, const validate_settings *settings);
/* To --json and --report, whichever was asked for. */
fathom_status validate_write_json(fathom_context *context, const validate_results *results,
                                  const validate_settings *settings);

/* ---- validate_failures.c ---- */
fathom_status validate_write_failures(fathom_context *context, const validate_results *results,
                                      const validate_settings *settings);
/* The first rays with a wrong answer, each as a line of --failures. */
json_t *validate_failures_json(const validate_run *run);
/* FATHOM_CHECK_FAILED when any ray's answer is still wrong. */
fathom_status validate_replay(fathom_context *context, const validate_settings *settings);

/* ---- validate_extremes.c ---- */

/* Runs the grid of extreme cases with the settings' tracers, or those of its own where none are named, and
 * appends rows, and failures where --failures asks for them. */
fathom_status validate_extremes_run(fathom_context *context, const validate_settings *settings,
                                    validate_results *results);
/* Over all rows. */
uint64_t validate_extremes_total(const extremes_rows *rows, verdict v);
void validate_extremes_print(const extremes_rows *rows, const validate_settings *settings);
/* The list "extremes" of --json. */
json_t *validate_extremes_json(const extremes_rows *rows);

/* ---- validate_light.c ---- */

/* Holds the path integrator against closed forms of light, or in a scene against the reference integrator.
 * FATHOM_CHECK_FAILED when a law is broken, or cannot be told for noise. */
fathom_status validate_light(fathom_context *context, const validate_settings *settings);

/* ---- validate_shading.c ---- */

/* Renders all cases of stiff shading with each of the settings' tracers but those from outside, which take
 * triangles alone, and appends rows; images only for --json or --report. */
fathom_status validate_shading_run(fathom_context *context, const validate_settings *settings,
                                   validate_results *results);
/* Rows out of their bounds. */
uint64_t validate_shading_wrong(const shading_rows *rows);
void validate_shading_print(const shading_rows *rows, const validate_settings *settings);
/* The lists "shading" and "images" of --json. */
json_t *validate_shading_json(const shading_rows *rows);
json_t *validate_images_json(const shading_images *images);

#endif
