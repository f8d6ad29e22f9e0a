/* Points with titles, and lines, gathered for a plot. */
#ifndef REPORT_DRAWING_H
#define REPORT_DRAWING_H

#include "base/array.h"
#include "report/plot.h"

/* Zeroes to begin with. */
typedef struct drawing {
    ARRAY(plot_point) points;
    ARRAY(plot_line) lines;
    ARRAY(char *) titles;
    bool lost; /* out of memory */
} drawing;

/* The title in place of the point's: what printf() makes of the rest, escaped as plot_point wants. */
void drawing_point(drawing *d, plot_point point, const char *title, ...)
    __attribute__((format(printf, 3, 4)));
void drawing_line(drawing *d, plot_line line);

/* The plot with what was gathered, which is released. The page is lost when the drawing is. */
void drawing_put(page *p, drawing *d, plot t);

#endif
