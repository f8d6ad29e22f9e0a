/* What all of `fathom bench` writes: one JSON object, from which table, CSV and page are made. */
#ifndef CLI_BENCH_OUTPUT_H
#define CLI_BENCH_OUTPUT_H

#include "cli/command.h"
#include "measure/stage.h"
#include "measure/statistics.h"

#include <jansson.h>
#include <stdint.h>

typedef struct bench_output {
    const char *json, *csv, *report; /* NULL: not asked for */
} bench_output;

/* The rows of the table of options, for settings with a bench_output called `output`. */
#define BENCH_OUTPUT_OPTIONS(settings)                                                                       \
    {.help = "Results"}, {"quiet", 'q', NULL, take_true, offsetof(settings, quiet), 0, 0, "no table"},       \
        {"json", 0, "FILE", take_text, offsetof(settings, output.json), 0, 0, "all figures"},                \
        {"csv",                                                                                              \
         0,                                                                                                  \
         "FILE",                                                                                             \
         take_text,                                                                                          \
         offsetof(settings, output.csv),                                                                     \
         0,                                                                                                  \
         0,                                                                                                  \
         "the same as comma-separated values, with the machine in lines that begin with #"},                 \
    {                                                                                                        \
        "report", 0, "DIR", take_text, offsetof(settings, output.report), 0, 0,                              \
            "the same as one page with tables and plots, DIR/index.html"                                     \
    }

/* Before anything is measured: whether all can be written. `input` may be NULL. */
fathom_status bench_output_check(fathom_context *context, const bench_output *output, const char *input);

/* {"bench": what, "fathom", "commit", "date", "machine": {…}}, to which the results are added. */
json_t *bench_head(const char *what);
/* Adds "embree" to the machine, if the tracer is Embree's. */
void bench_head_tracer(json_t *root, const char *tracer_name);

/* {"low", "median", "high"} */
json_t *bench_quartiles(quartiles q);
/* {"cpu": …, "wall": …}, quartiles each. */
json_t *bench_clocks(const quartiles q[BENCH_CLOCKS]);
/* A number of an object inside: number_in(run, "ratio", "median"); NAN where there is none. */
double bench_number(const json_t *object, const char *key, const char *inner);
/* A field of CSV, between quotes where it needs them. */
void bench_csv_text(FILE *out, const char *text);

/* All that was asked for, from the finished object. put_csv: header and rows. */
fathom_status bench_output_write(fathom_context *context, const bench_output *output, const json_t *root,
                                 void (*put_csv)(FILE *out, const json_t *root));

#endif
