/* The curve of sRGB (IEC 61966-2-1), odd beyond 0. */
#pragma once

#include <math.h>

static inline double srgb_decoded(double value) {
    const double size = fabs(value);
    return copysign(size <= 0.04045 ? size / 12.92 : pow((size + 0.055) / 1.055, 2.4), value);
}

static inline double srgb_encoded(double value) {
    const double size = fabs(value);
    return copysign(size <= 0.0031308 ? 12.92 * size : 1.055 * pow(size, 1 / 2.4) - 0.055, value);
}
