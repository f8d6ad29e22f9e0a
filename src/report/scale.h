/* From numbers to places on an axis. */
#ifndef REPORT_SCALE_H
#define REPORT_SCALE_H

#include <stdbool.h>
#include <stddef.h>

#define SCALE_TICKS 32

typedef struct scale {
    bool log;
    double low, high; /* what the axis shows, low < high */
    double from, to;  /* where, in pixels; from > to for an axis that points up */
    double zero;      /* where a logarithmic scale puts what is not positive: at first `from` */
} scale;

/* Holds least … most, widened to the next round numbers. Logarithmic scales pass over what is not positive:
 * least must be. A single number gets room on both sides. */
scale scale_over(bool log, double least, double most, double from, double to);
/* What is beyond an end is put there. */
double scale_at(const scale *s, double x);
/* Round numbers, in order, at most `most` <= SCALE_TICKS of them and at least two; returns how many. */
size_t scale_ticks(const scale *s, size_t most, double out[SCALE_TICKS]);

#endif
