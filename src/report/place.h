/* Where labels go so that none lies on another, nor on what is drawn. */
#ifndef REPORT_PLACE_H
#define REPORT_PLACE_H

#include <stdbool.h>
#include <stddef.h>

typedef struct box {
    double left, top, right, bottom;
} box;

typedef struct label {
    double x, y;          /* of the point it belongs to */
    double width, height; /* of its text */
    box at;               /* set when it was placed */
    bool placed, far;     /* far: a line should lead to it */
} label;

bool box_overlap(const box *a, const box *b);
/* Whether the straight line between two points touches the box. */
bool box_meets_line(const box *b, double x0, double y0, double x1, double y1);
/* Where the line from the label's point ends: at the nearest place of its box. */
void label_leader(const label *l, double *x, double *y);
#define PLACE_LABELS 64 /* at most; further ones stay unplaced */

/* Places each label inside `frame`, off the `taken` boxes and off each other: beside its point where that is
 * free, else near by, with a line that crosses nothing where there is such a place. One for which there is no
 * room at all stays unplaced. */
void place_labels(label *labels, size_t count, const box *taken, size_t taken_count, const box *frame);

#endif
