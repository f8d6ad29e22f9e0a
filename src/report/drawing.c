#include "report/drawing.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#define TITLE 400

void drawing_point(drawing *d, plot_point point, const char *title, ...) {
    char *text = malloc(TITLE);
    if (!text || !array_push(&d->titles, text)) {
        free(text);
        d->lost = true;
        return;
    }
    va_list words;
    va_start(words, title);
    vsnprintf(text, TITLE, title, words);
    va_end(words);
    point.title = text;
    if (!array_push(&d->points, point)) d->lost = true;
}

void drawing_line(drawing *d, plot_line line) {
    if (!array_push(&d->lines, line)) d->lost = true;
}

void drawing_put(page *p, drawing *d, plot t) {
    t.points = d->points.items, t.count = d->points.count;
    t.lines = d->lines.items, t.line_count = d->lines.count;
    if (d->lost)
        p->lost = true;
    else
        plot_put(p, &t);
    for (size_t i = 0; i < d->titles.count; ++i) free(d->titles.items[i]);
    array_free(&d->titles);
    array_free(&d->points);
    array_free(&d->lines);
}
