/* The page of `fathom bench`, from the very JSON that --json writes. */
#ifndef REPORT_BENCH_PAGE_H
#define REPORT_BENCH_PAGE_H

#include "report/page.h"

#include <jansson.h>

/* A whole document, on a page that was zeroed; by results' "bench". */
void bench_page(page *p, const json_t *results);

#endif
