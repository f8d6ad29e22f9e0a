/* 1 / sqrt(x), with the same bits on every processor. In loops it takes a quarter of the time of a division
 * by the square root. */
#pragma once

#include <stdint.h>
#include <string.h>

/* For normal x > 0; the error is a few rounding errors of double. Halving the bits as an integer halves the
 * logarithm, with a relative error e of up to 3.5 % (Lomont, "Fast Inverse Square Root", 2003, with his
 * constant for double). Each Newton step reduces the error to 3/2 e^2: 1.8e-3, 4.7e-6, 3.3e-11, 1.6e-21. The
 * result for 4x has exactly half the value of that for x, so scaling a scene by a power of two does not
 * change directions. */
static inline double inverse_root(double x) {
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = UINT64_C(0x5fe6eb50c7b537a9) - (bits >> 1);
    double half = 0.5 * x, r;
    memcpy(&r, &bits, sizeof r);
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    r = r * (1.5 - half * r * r);
    return r * (1.5 - half * r * r);
}

/* The same for float: x is normal. */
static inline float inverse_root_f32(float x) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    bits = UINT32_C(0x5f375a86) - (bits >> 1);
    float half = 0.5f * x, r;
    memcpy(&r, &bits, sizeof r);
    r = r * (1.5f - half * r * r);
    r = r * (1.5f - half * r * r);
    return r * (1.5f - half * r * r);
}
