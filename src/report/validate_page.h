/* The page of `fathom validate`, from the very JSON that --json writes. A key that is not there leaves out
 * its section; the page says so. */
#ifndef REPORT_VALIDATE_PAGE_H
#define REPORT_VALIDATE_PAGE_H

#include "report/page.h"

#include <jansson.h>

/* A whole document, on a page that was zeroed. */
void validate_page(page *p, const json_t *results);

#endif
