#include "light/regions.h"

#include <math.h>
#include <string.h>

static float coordinate(const region_items *items, size_t k, uint32_t axis) {
    return ((const float *)(const void *)((const char *)items->first + k * items->size))[axis];
}

void region_scales(const region_items *items, float scales[6]) {
    float longest = 0x1p-100f;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        float low = INFINITY, high = -INFINITY;
        for (size_t k = 0; k < items->count; ++k) {
            low = fminf(low, coordinate(items, k, axis));
            high = fmaxf(high, coordinate(items, k, axis));
        }
        longest = fmaxf(longest, high - low);
    }
    for (int axis = 0; axis < 6; ++axis) scales[axis] = axis < 3 ? 1 / longest : 1;
}

region_split region_choose(const region_items *items, unsigned axes, const float scales[]) {
    region_split best = {0};
    double most = -1;
    for (uint32_t axis = 0; axis < axes; ++axis) {
        double sum = 0, squares = 0;
        for (size_t k = 0; k < items->count; ++k) sum += (double)coordinate(items, k, axis);
        const double mean = sum / (double)items->count;
        for (size_t k = 0; k < items->count; ++k) {
            const double off = (double)coordinate(items, k, axis) - mean;
            squares += off * off;
        }
        squares *= (double)scales[axis] * (double)scales[axis];
        if (squares > most) most = squares, best.at = (float)mean, best.axis = axis;
    }
    return best;
}

static void swap(char *a, char *b, size_t size) {
    char kept[64];
    memcpy(kept, a, size), memcpy(a, b, size), memcpy(b, kept, size);
}

size_t region_part(const region_items *items, const region_split *split) {
    size_t end = 0;
    for (size_t k = 0; k < items->count; ++k) {
        if (!(coordinate(items, k, split->axis) < split->at)) continue;
        swap((char *)items->first + k * items->size, (char *)items->first + end++ * items->size, items->size);
    }
    return end;
}
