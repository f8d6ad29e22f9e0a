/* Extremes of vectors, and whether all their numbers are finite. */
#include "scene/kernels/kernel.h"

/* NaN where a number is not finite, else 0, to be summed. */
FOUR_INLINE wide oddness(wide v) { return v - v; }

FOUR_INLINE bool is_zero(wide v) {
    bool zero = true;
    for (int k = 0; k < WIDE; ++k) zero &= v[k] == 0;
    return zero;
}

/* WIDE vectors that follow each other fill three registers, whose extremes do not wait for each other. */
FOUR_INLINE bool add_packed(const float *values, size_t count, float lower[3], float upper[3]) {
    wide low[3], high[3], odd = {0};
    for (int j = 0; j < 3; ++j) low[j] = high[j] = wide_load(values + WIDE * j);
    for (size_t i = 0; i + WIDE <= count; i += WIDE) {
        for (size_t j = 0; j < 3; ++j) {
            wide v = wide_load(values + 3 * i + WIDE * j);
            low[j] = (wide)wide_choose(v < low[j], (wide_marks)v, (wide_marks)low[j]);
            high[j] = (wide)wide_choose(v > high[j], (wide_marks)v, (wide_marks)high[j]);
            odd += oddness(v);
        }
    }
    for (int k = 0; k < 3 * WIDE; ++k) {
        float l = low[k / WIDE][k % WIDE], h = high[k / WIDE][k % WIDE];
        lower[k % 3] = l < lower[k % 3] ? l : lower[k % 3];
        upper[k % 3] = h > upper[k % 3] ? h : upper[k % 3];
    }
    return is_zero(odd);
}

bool KERNEL(vectors)(const float *values, size_t stride, size_t count, float lower[3], float upper[3]) {
    size_t done = 0;
    float odd = 0;
    if (stride == 3 * sizeof(float) && count >= WIDE) {
        if (!add_packed(values, count, lower, upper)) return false;
        done = count / WIDE * WIDE;
    }
    for (size_t i = done; i < count; ++i) {
        const float *v = (const float *)(const void *)((const char *)values + i * stride);
        for (int k = 0; k < 3; ++k) {
            lower[k] = v[k] < lower[k] ? v[k] : lower[k];
            upper[k] = v[k] > upper[k] ? v[k] : upper[k];
            odd += v[k] - v[k];
        }
    }
    return odd == 0;
}
