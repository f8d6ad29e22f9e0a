/* Phong's and Blinn's highlights, for a block of lanes. */
#pragma once

#include "base/kernel.h"
#include "math/lanes.h"
#include "math/power.h"

/* k_s max(0, v·r)^n with r = -l + 2(n·l)n, or k_s max(0, n·h)^n with h = (l+v)/|l+v|. The cosine of two unit
 * vectors is 1 minus half the square of their difference. This form keeps the digits of small angles, where
 * the cosine itself would round to 1; exponents in the millions need them. */
static inline void apart_phong(const lanes3 n, const lanes3 v, const lanes3 l, const float n_dot_l[LANES],
                               float *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        out[i] = 0;
        for (int c = 0; c < 3; ++c) {
            float r = -l[c][i] + 2 * n_dot_l[i] * n[c][i], apart = v[c][i] - r;
            out[i] += apart * apart;
        }
    }
}

static inline void apart_blinn(const lanes3 n, const lanes3 v, const lanes3 l, float *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float h[3], h2 = 0;
        for (int c = 0; c < 3; ++c) {
            h[c] = l[c][i] + v[c][i];
            h2 += h[c] * h[c];
        }
        float unit = 1 / sqrtf(h2);
        out[i] = 0;
        for (int c = 0; c < 3; ++c) {
            float apart = n[c][i] - h[c] * unit;
            out[i] += apart * apart;
        }
    }
}

/* max(0, v·r)^n or max(0, n·h)^n, or 0 in lanes where both masks are 0; n: the normal. */
static inline void highlight(const lanes3 n, const lanes3 v, const uint32_t is_phong[LANES],
                             const uint32_t is_blinn[LANES], const float shininess[LANES], const lanes3 l,
                             const float n_dot_l[LANES], float *restrict out) {
    float phong[LANES] = {0}, blinn[LANES] = {0}, less[LANES];
    uint32_t any_phong = 0, any_blinn = 0;
    for (int i = 0; i < LANES; ++i) any_phong |= is_phong[i], any_blinn |= is_blinn[i];
    if (!(any_phong | any_blinn)) return;
    if (any_phong) apart_phong(n, v, l, n_dot_l, phong);
    if (any_blinn) apart_blinn(n, v, l, blinn);
    for (int i = 0; i < LANES; ++i) {
        /* Light from the direction opposite to v has no half vector: no highlight. */
        float half = 0.5f * chosen(is_phong[i], phong[i], blinn[i]);
        less[i] = half < 1 ? half : 1;
    }
    double exponent[LANES];
    for (int i = 0; i < LANES; ++i) exponent[i] = power_exponent(less[i], shininess[i]);
    for (int i = 0; i < LANES; ++i) out[i] = power_finish(less[i], exponent[i]);
}
