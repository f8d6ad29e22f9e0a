/* What the files of validate's page share. */
#ifndef REPORT_VALIDATE_PARTS_H
#define REPORT_VALIDATE_PARTS_H

#include "report/page.h"

#include <jansson.h>
#include <stdint.h>

/* ---- reading: what is not there is NAN, 0, "" ---- */

double number_at(const json_t *object, const char *key);
uint64_t count_at(const json_t *object, const char *key);
const char *text_at(const json_t *object, const char *key);
/* A count of "verdicts" over all families of a run; `any`: of its any-hit queries. */
uint64_t verdicts_of(const json_t *run, const char *verdict, bool any);
/* The same of an extreme case, closest and any hit together. */
uint64_t case_verdicts(const json_t *item, const char *verdict);
/* The rays of all families of a run. */
uint64_t rays_of(const json_t *run);

/* Whether two runs are of one tracer: those are beside each other. */
bool same_tracer(const json_t *runs, size_t i, size_t k);

/* ---- errors, gathered over families and runs ---- */

#define SPREAD_BINS 1024

typedef struct spread {
    uint64_t zeros, total, bins[SPREAD_BINS];
    int first; /* the exponent of 2 where the bins begin */
    unsigned per_octave;
    double most;
} spread;

/* Adds a "tUlps"; without a histogram only its maximum. */
void spread_add(spread *s, const json_t *error);
/* What all but a fraction 1 - q do not exceed: 0 when that is none, NAN when nothing was counted. */
double spread_quantile(const spread *s, double q);

/* One tracer over all its scenes. */
typedef struct tracer_sum {
    const char *spec, *tracer;
    unsigned kind;              /* of plot.h: by the first word of spec */
    double rays, nanoseconds;   /* nanoseconds is NAN when a run has none */
    spread all, ordinary, hard; /* errors of t in ulps: of all families, of camera and uniform, of others */
} tracer_sum;

typedef ARRAY(tracer_sum) tracer_sums;

/* In the order of the runs. False when out of memory. */
bool tracer_sums_of(const json_t *results, tracer_sums *out);

/* ---- sections ---- */

void put_absent(page *p, const char *sentence);
void validate_runs_put(page *p, const json_t *results);
/* What tracers are known to miss; a section, with its heading. */
void validate_leaks_put(page *p, const json_t *runs);
void validate_failures_put(page *p, const json_t *results);
void validate_plots_put(page *p, const json_t *results);
void validate_extremes_put(page *p, const json_t *results);
void validate_shading_put(page *p, const json_t *results);

#endif
