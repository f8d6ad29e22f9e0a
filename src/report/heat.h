/* Heat maps: one row a name, one column a number, a colour for each magnitude. */
#ifndef REPORT_HEAT_H
#define REPORT_HEAT_H

#include "report/page.h"

typedef enum heat_sign { HEAT_NONE, HEAT_PLAIN, HEAT_LEAK, HEAT_WRONG } heat_sign;

typedef struct heat_cell {
    heat_sign sign; /* HEAT_NONE: nothing was measured here */
    double value;
    char *title; /* shown when pointed at; escaped */
} heat_cell;

typedef struct heat_range {
    double low, high; /* of colours, both positive; low < high */
} heat_range;

typedef struct heat {
    const char *title, *summary, *caption; /* the title says what the columns are */
    heat_range range;
    const char *const *rows;
    const double *columns;
    size_t row_count, column_count;
    const heat_cell *cells; /* row by row */
} heat;

/* 0 … COLOUR_STEPS - 1: never less for a larger value. What is out of the range counts as its end. */
unsigned heat_step(const heat_range *range, double value);
void heat_put(page *p, const heat *h);
/* The scale of colours, and what the signs mean. */
void heat_legend(page *p, const heat_range *range, const char *name);

#endif
