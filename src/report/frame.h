/* The frame of a plot: a figure with its words, two axes with ticks and grid. */
#ifndef REPORT_FRAME_H
#define REPORT_FRAME_H

#include "report/page.h"
#include "report/place.h"
#include "report/scale.h"

/* Of the page's plain text and of its code, in SVG, in pixels: sizes that the style sets. A character of code
 * is 0.6 of its size wide in the fonts in use (DejaVu Sans Mono 0.602, the widest), and no letter of the text
 * that stands in plots is wider on average. */
#define FRAME_TEXT 11.5
#define FRAME_LETTER (0.605 * FRAME_TEXT)

typedef struct axis {
    const char *name; /* with its unit */
    scale scale;
    bool zero; /* a logarithmic scale shows 0 apart from the rest */
} axis;

typedef struct frame {
    const char *title;   /* a line above the plot */
    const char *summary; /* what a person who can't see it should know; escaped */
    double width, height;
    axis x, y;
    size_t marks; /* how many marks of class "mark" the plot has, for whoever checks */
} frame;

/* What is left for the marks. */
box frame_area(double width, double height);
/* Room for 0 at the axis' low end, when `zero`. */
void frame_zero(axis *a, bool zero);

void frame_open(page *p, const frame *f);
/* The figure's caption follows, "" for none, escaped. */
void frame_close(page *p, const char *caption);

/* <svg …> with its title and summary; frame_svg_close() ends it. */
void frame_svg_open(page *p, double width, double height, const char *title, const char *summary,
                    size_t marks);

#endif
