/* Points with names and intervals, on axes. */
#ifndef REPORT_PLOT_H
#define REPORT_PLOT_H

#include "report/frame.h"

/* Kinds have a colour and a shape each. */
#define PLOT_KINDS 4

typedef struct plot_point {
    double x, y;
    double high;       /* an interval up to here, with a hollow mark at its end; NAN: none */
    const char *label; /* escaped; NULL: none */
    const char *title; /* shown when pointed at; escaped */
    unsigned kind;     /* < PLOT_KINDS */
} plot_point;

typedef struct plot {
    const char *title, *summary, *caption;
    double width, height;
    const char *x_name, *y_name;
    bool x_log, y_log;
    double y_low, y_high; /* shown at least; NAN: what the points need */
    const plot_point *points;
    size_t count;
} plot;

/* Points without a finite x and y are left out. */
void plot_put(page *p, const plot *plot);
/* A line of marks and words; names may hold NULL for kinds that are not there. */
void plot_legend(page *p, const char *const names[PLOT_KINDS], const char *solid, const char *hollow);

#endif
