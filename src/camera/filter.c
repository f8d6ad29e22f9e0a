#include "camera/filter.h"

#include <math.h>

/* The filter at x in [-1/2, 1/2] of its width. Gaussian: a standard deviation of a quarter of the width,
 * minus the value at the edges, so that it ends at 0. Blackman-Harris: the four-term window, -92 dB. */
static double weight(fathom_filter filter, double x) {
    switch (filter) {
    case FATHOM_FILTER_BOX: return 1;
    case FATHOM_FILTER_GAUSSIAN: return exp(-8 * x * x) - exp(-2);
    case FATHOM_FILTER_BLACKMAN_HARRIS:
        return 0.35875 + 0.48829 * cos(2 * M_PI * x) + 0.14128 * cos(4 * M_PI * x) +
               0.01168 * cos(6 * M_PI * x);
    }
    return 1;
}

static double usual_width(fathom_filter filter) {
    switch (filter) {
    case FATHOM_FILTER_BOX: return 1;
    case FATHOM_FILTER_GAUSSIAN: return 3;
    case FATHOM_FILTER_BLACKMAN_HARRIS: return 4;
    }
    return 1;
}

/* The integral by the midpoint rule, with four points for each step of the table, and its inverse. */
void filter_prepare(const fathom_settings *s, pixel_filter *out) {
    enum { PARTS = 4 * FILTER_STEPS };
    const double width = s->filter_width > 0 ? s->filter_width : usual_width(s->filter);
    double sum[PARTS + 1] = {0};
    out->box = s->filter == FATHOM_FILTER_BOX && width == 1;
    for (int k = 0; k < PARTS; ++k) sum[k + 1] = sum[k] + fmax(weight(s->filter, (k + 0.5) / PARTS - 0.5), 0);
    for (int i = 0, k = 0; i <= FILTER_STEPS; ++i) {
        const double want = sum[PARTS] * i / FILTER_STEPS;
        while (k + 1 < PARTS && sum[k + 1] < want) ++k;
        const double part = sum[k + 1] > sum[k] ? (want - sum[k]) / (sum[k + 1] - sum[k]) : 0;
        out->at[i] = width * ((k + fmin(part, 1)) / PARTS - 0.5);
    }
}

double filter_place(const pixel_filter *f, double u) {
    if (f->box) return u;
    const double x = u * FILTER_STEPS;
    const int i = (int)x;
    return 0.5 + f->at[i] + (x - i) * (f->at[i + 1] - f->at[i]);
}

double filter_density(const pixel_filter *f, double x) {
    if (f->box) return x >= 0 && x < 1 ? 1 : 0;
    const double at = x - 0.5;
    if (!(at >= f->at[0] && at < f->at[FILTER_STEPS])) return 0;
    int below = 0, above = FILTER_STEPS; /* at[below] <= at < at[above] */
    while (above - below > 1) {
        const int middle = (below + above) / 2;
        *(f->at[middle] <= at ? &below : &above) = middle;
    }
    return 1 / (FILTER_STEPS * (f->at[above] - f->at[below]));
}
