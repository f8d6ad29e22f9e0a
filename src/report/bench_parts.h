/* The sections of the pages of `fathom bench`, one file for each kind. */
#ifndef REPORT_BENCH_PARTS_H
#define REPORT_BENCH_PARTS_H

#include "report/page.h"

#include <jansson.h>

void bench_trace_put(page *p, const json_t *results);
void bench_render_put(page *p, const json_t *results);
void bench_error_put(page *p, const json_t *results);
void bench_build_put(page *p, const json_t *results);
void bench_growth_put(page *p, const json_t *results);
void bench_secondary_put(page *p, const json_t *results);

#endif
