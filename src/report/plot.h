/* Points with names and intervals, and straight lines, on axes. */
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
    bool hollow;       /* its own mark, for what counts less */
} plot_point;

/* Straight on the axes as they are: a power law where both are logarithmic. */
typedef struct plot_line {
    double x0, y0, x1, y1;
    unsigned kind;
    bool dashed;
} plot_line;

typedef struct plot {
    const char *title, *summary, *caption;
    double width, height;
    const char *x_name, *y_name;
    bool x_log, y_log;
    double y_low, y_high; /* shown at least; NAN: what the points need */
    const plot_point *points;
    size_t count;
    const plot_line *lines; /* below the points; the axes hold them whole */
    size_t line_count;
} plot;

/* Points without a finite x and y are left out, and lines with an end that no axis can show. */
void plot_put(page *p, const plot *plot);
/* A line of marks and words; names may hold NULL for kinds that are not there, and hollow
 * may be NULL. */
void plot_legend(page *p, const char *const names[PLOT_KINDS], const char *solid, const char *hollow);

#endif
