/* How pages look: on screens light and dark, wide and narrow, and on paper. */
#ifndef REPORT_STYLE_H
#define REPORT_STYLE_H

#include "report/page.h"

void style_put(page *p);

#endif
