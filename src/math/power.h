/* Powers: small ones, and (1-d)^n for highlights, with the same bits on every processor, and vectorised in
 * loops.
 *
 * glibc's powf() has variants by processor, whose last bits may differ, so images would depend on the
 * processor. It is also a function call, which a vectorised loop cannot contain. */
#pragma once

#include <math.h>
#include <stdint.h>
#include <string.h>

static inline float power5(float x) {
    const float x2 = x * x;
    return x2 * x2 * x;
}

static inline float power8(float x) {
    const float x2 = x * x, x4 = x2 * x2;
    return x4 * x4;
}

/* Series are summed in pairs of pairs (Estrin's scheme): in a loop over few lanes, the latency of a chain of
 * sixteen dependent operations would dominate. */

/* log2(x) for a normal x = 1 - d > 0. x = 2^e m with m in [sqrt(1/2), sqrt(2)), and log2 m = 2/ln2 atanh(z),
 * z = (m-1)/(m+1), |z| <= 0.1716. The series up to z^15 has a relative truncation error of 2^-43. If e = 0,
 * m - 1 is taken as -d, so there is no cancellation near x = 1. */
static inline double power_log2(float x, float d) {
    uint32_t bits;
    memcpy(&bits, &x, sizeof bits);
    /* 0x3f3504f3 is sqrt(1/2). Subtracting it lowers the exponent of mantissas below sqrt(1/2) by one. */
    uint32_t shifted = bits - 0x3f3504f3u;
    int32_t e = (int32_t)shifted >> 23;
    uint32_t mantissa = (shifted & 0x7fffffu) + 0x3f3504f3u;
    float m;
    memcpy(&m, &mantissa, sizeof m);
    /* A comparison of doubles selects doubles, so that loops over 16 lanes vectorise. */
    double whole = (double)e, less = whole != 0 ? (double)m - 1 : -(double)d;
    double z = less / (2 + less), q = z * z, q2 = q * q, q4 = q2 * q2;
    double series = ((1 + q * (1 / 3.0)) + q2 * (1 / 5.0 + q * (1 / 7.0))) +
                    q4 * ((1 / 9.0 + q * (1 / 11.0)) + q2 * (1 / 13.0 + q * (1 / 15.0)));
    return whole + 2.8853900817779268 * z * series;
}

/* 2^y for y <= 0; 0 below the smallest normal float. 2^y = 2^k 2^f with |f| <= 1/2. The series of e^(f ln2)
 * up to the 9th power has a relative truncation error of 2^-36. */
static inline float power_exp2(double y) {
    double some = y < -126 ? 0.0 : 1.0, low = some * y; /* a factor: a selection would become a branch */
    int32_t k = (int32_t)(low - 0.5);
    double f = (low - (double)k) * 0.69314718055994531;
    double f2 = f * f, f4 = f2 * f2;
    double series = ((1 + f) + f2 * (1 / 2.0 + f * (1 / 6.0))) +
                    f4 * (((1 / 24.0 + f * (1 / 120.0)) + f2 * (1 / 720.0 + f * (1 / 5040.0))) +
                          f4 * (1 / 40320.0 + f * (1 / 362880.0)));
    uint32_t bits = (uint32_t)(k + 127) << 23;
    float scale;
    memcpy(&scale, &bits, sizeof scale);
    return (float)(some * series) * scale;
}

/* (1-d)^n for d in [0, 2] and n in [0, 1e9]. For d < 0.29 the error is within 1 ulp, however close to 1 the
 * base is; for larger d it is as if 1 - d were rounded first. The result is 0 below 2^-126 and for d >= 1,
 * and 1 for n = 0 and d < 1. There are two steps: the exponent n log2(1-d), then the power of 2. Loops over
 * lanes run each step in a loop of its own, because the processor overlaps short loops. */
static inline double power_exponent(float d, float n) {
    float x = 1 - d;
    return (double)n * power_log2(x < 0x1p-126f ? 0x1p-126f : x, d);
}
static inline float power_finish(float d, double exponent) {
    float some = 1 - d < 0x1p-126f ? 0.0f : 1.0f;
    return some * power_exp2(exponent);
}
static inline float power_one_less(float d, float n) { return power_finish(d, power_exponent(d, n)); }
