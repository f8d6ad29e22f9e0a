#include "verify/histogram.h"

#include <math.h>

void histogram_add(histogram *h, double value) {
    ++h->total;
    if (!(value > 0)) {
        ++h->zeros;
        return;
    }
    double place = floor(HISTOGRAM_PER_OCTAVE * (log2(value) - HISTOGRAM_FIRST));
    unsigned bin = place < 0 ? 0 : place >= HISTOGRAM_BINS ? HISTOGRAM_BINS - 1 : (unsigned)place;
    ++h->bins[bin];
}

void histogram_join(histogram *h, const histogram *other) {
    h->zeros += other->zeros, h->total += other->total;
    for (unsigned i = 0; i < HISTOGRAM_BINS; ++i) h->bins[i] += other->bins[i];
}

double histogram_quantile(const histogram *h, double q) {
    double wanted = q * (double)h->total, below = (double)h->zeros;
    if (below >= wanted) return 0;
    for (unsigned i = 0; i < HISTOGRAM_BINS; ++i) {
        below += (double)h->bins[i];
        if (below >= wanted) return exp2((double)(i + 1) / HISTOGRAM_PER_OCTAVE + HISTOGRAM_FIRST);
    }
    return (double)INFINITY;
}
