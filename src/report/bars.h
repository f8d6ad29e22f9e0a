/* Bars that stand on an axis, and a bar in a cell of a table. */
#ifndef REPORT_BARS_H
#define REPORT_BARS_H

#include "report/page.h"

typedef struct bar {
    double from, to; /* on a logarithmic axis; both 0: the bar of zeros */
    double count;    /* positive */
} bar;

typedef struct bars {
    const char *title, *summary, *caption, *x_name, *y_name;
    double width, height;
    double low, high, most; /* what the axes show, so that plots beside each other agree */
    bool zero;              /* the axis has a place for zeros */
    const bar *items;
    size_t count;
} bars;

/* Heights on a logarithmic scale from below 1 to `most`: few far out are what matters. */
void bars_put(page *p, const bars *b);

/* value against 1 on a logarithmic scale from 10^-6 on; past 1 it is marked as bad. */
void bars_ratio(page *p, double value, const char *title);

#endif
