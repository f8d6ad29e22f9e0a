/* `fathom bench WHAT`: measurements. The results are one JSON object; tables, CSV and pages are made from
 * it. */
#pragma once

#include "cli/command.h"
#include "cli/json_text.h"
#include "cli/render/progress.h"
#include "measure/stage.h"
#include "measure/statistics.h"

#include <fathom/trace.h>

extern const command command_bench_trace, command_bench_render, command_bench_error;

/* A row of CSV for each item of the array root[rows], or for each item of its array `inner`, if that is not
 * NULL. columns: "spp, seconds_low=seconds.low"; paths are looked up in the inner item first, then in the
 * outer. */
typedef struct bench_csv {
    const char *rows, *inner, *columns;
} bench_csv;

/* Adds results to `root` and prints them unless quiet. With FATHOM_INTERRUPTED, the results are still written
 * if root.interrupted is true. */
typedef fathom_status (*bench_measure)(fathom_context *context, const void *settings, json_t *root);

/* ---- settings: the first member of each bench's own ---- */

typedef struct bench_settings {
    command_common common;
    const command *command;
    bench_measure measure;
    const bench_csv *table;
    const char *scene, *tracer;
    args_size size; /* 0 × 0: the scene's size */
    uint32_t repeats;
    const char *json, *csv, *report; /* NULL: not requested */
} bench_settings;

/* Rows for the tables of options. */
#define BENCH_FIELD(name) offsetof(bench_settings, name)
#define BENCH_SIZE                                                                                           \
    ARGS_ROW("size", 0, "WxH", take_size, BENCH_FIELD(size), 1, 65536, "pixels (the scene's, else 1280x720)")
#define BENCH_REPEATS(most, help) ARGS_ROW("repeats", 0, "N", take_u32, BENCH_FIELD(repeats), 1, most, help)
#define BENCH_RESULTS                                                                                        \
    ARGS_ROW(.help = "Results"), COMMAND_QUIET("no table"),                                                  \
        ARGS_ROW("json", 0, "FILE", take_text, BENCH_FIELD(json), 0, 0, "all figures"),                      \
        ARGS_ROW("csv", 0, "FILE", take_text, BENCH_FIELD(csv), 0, 0,                                        \
                 "the same as comma-separated values; lines that begin with # describe the machine"),        \
        ARGS_ROW("report", 0, "DIR", take_text, BENCH_FIELD(report), 0, 0,                                   \
                 "the same as one page with tables and plots, DIR/index.html"),                              \
        ARGS_ROW(.help = NULL)

/* ---- running ---- */

/* The body of each command. `settings` begin with bench_settings. */
fathom_status bench_run(fathom_context *context, void *settings);

/* A watch that shows the progress of one part [from, to] of the whole, and an estimate of the time. */
bench_watch bench_progress_part(double from, double to);
void bench_progress_tell(void *unused, double fraction);

/* Opens the file's scene with its settings, but with one sample a pixel and neither target error nor time.
 * classic: with that integrator. Release with stage_close(), whatever the status. */
fathom_status bench_open(fathom_context *context, const bench_settings *asked, bool classic,
                         bench_stage *out);

/* The sphere that `fathom generate sphere` makes. Release with fathom_scene_destroy(), whatever the
 * status. */
fathom_status bench_sphere(fathom_context *context, uint64_t triangles, fathom_scene **out);

/* ---- results ---- */

/* Adds "embree" to the machine, if the tracer is Embree. */
void bench_add_tracer(json_t *root, const char *tracer_name);

/* {"low", "median", "high"} */
json_t *bench_quartiles(quartiles q);
/* {"cpu": …, "wall": …}, quartiles or numbers. */
json_t *bench_clocks(const quartiles q[BENCH_CLOCKS]);
extern const char *const bench_clock_names[BENCH_CLOCKS];
/* "  0.123 +- 0.004". The part from "+-" on only if `half` is known; "-" without a slope. */
void bench_print_slope(const json_t *slope, const json_t *half, int width);
