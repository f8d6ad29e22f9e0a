#include "scene/mesh/mesh_facts.h"

#include <math.h>
#include <stdlib.h>

/* Points in the sample, and the part of it beyond each end of the rest. */
enum { SAMPLE = 4096, ASIDE = 100 };

static int by_value(const void *a, const void *b) {
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Most points lie from `low` to `high` along the axis. */
static void find_most(const float *values, size_t stride, uint32_t count, int axis, float *low, float *high) {
    float along[SAMPLE] = {0};
    const uint32_t sample = count < SAMPLE ? count : SAMPLE;
    for (uint32_t i = 0; i < sample; ++i)
        along[i] = mesh_row(values, stride, (size_t)((uint64_t)count * i / sample))[axis];
    qsort(along, sample, sizeof *along, by_value);
    *low = along[sample / ASIDE], *high = along[sample - 1 - sample / ASIDE];
}

uint32_t mesh_find_strays(const float *values, size_t stride, uint32_t count, float lower[3],
                          float upper[3]) {
    float low[3], high[3], longest = 0;
    bool any = false;
    uint32_t strays = 0;
    if (!count) return 0;
    for (int k = 0; k < 3; ++k) {
        find_most(values, stride, count, k, &low[k], &high[k]);
        longest = fmaxf(longest, high[k] - low[k]);
    }
    for (int k = 0; k < 3; ++k) {
        low[k] -= longest, high[k] += longest;
        any |= lower[k] < low[k] || upper[k] > high[k];
    }
    if (!any || longest == 0) return 0;
    for (int k = 0; k < 3; ++k) lower[k] = INFINITY, upper[k] = -INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
        const float *p = mesh_row(values, stride, i);
        bool stray = false;
        for (int k = 0; k < 3; ++k) stray |= p[k] < low[k] || p[k] > high[k];
        strays += stray;
        for (int k = 0; k < 3 && !stray; ++k) {
            lower[k] = p[k] < lower[k] ? p[k] : lower[k];
            upper[k] = p[k] > upper[k] ? p[k] : upper[k];
        }
    }
    return strays;
}
