/* Counts positive numbers of any size, for quantiles. The order of counting makes no difference. */
#ifndef PARITY_HISTOGRAM_H
#define PARITY_HISTOGRAM_H

#include <stdint.h>

#define HISTOGRAM_BINS 640
#define HISTOGRAM_PER_OCTAVE 4
#define HISTOGRAM_FIRST (-80) /* the first bin begins at 2^-80 */

typedef struct histogram {
    uint64_t zeros, total;
    uint64_t bins[HISTOGRAM_BINS];
} histogram;

/* value: at least 0; an infinite one counts as the largest. */
void histogram_add(histogram *h, double value);
void histogram_join(histogram *h, const histogram *other);
/* A number that at least the fraction q of all do not exceed, at most 2^(1/4) too large; 0: of none. */
double histogram_quantile(const histogram *h, double q);

#endif
