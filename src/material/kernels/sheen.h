/* Fibres that stand on the surface (KHR_materials_sheen; Estevez & Kulla 2017): the distribution of half
 * vectors (2 + 1/α) sin^(1/α) / 2π, divided by 4 n·v n·l (1 + Λ(v) + Λ(l)). */
#pragma once

#include "material/kernels/incidence.h"
#include "math/limit.h"
#include "math/power.h"

/* 2^y, |y| < 126. */
static inline float sheen_exp2(float y) {
    float p = power_exp2(-(double)fabsf(y));
    return y > 0 ? 1 / p : p;
}

/* Λ by the fit a / (1 + b x^c) + d x + e of its logarithm, mirrored about 1/2; the coefficients include the
 * factor log2 e. */
static inline float sheen_lambda(const shader *m, float cosine) {
    float z = least(fabsf(cosine), 1), x = z < 0.5f ? z : 1 - z;
    const float *fit = m->sheen_fit;
    float l = fit[0] / (1 + fit[1] * power_one_less(1 - x, fit[2])) + fit[3] * x + fit[4];
    return sheen_exp2(z < 0.5f ? l : fit[5] - l);
}

/* The fraction that the fibres transmit: s of shader.h. Their albedo by these formulas exceeds 1 if α is
 * small and the view is grazing; then `part` scales them by 1 / albedo. */
static inline float sheen_left(const shader *m, float cosine, float *part) {
    float albedo = m->lobes & SHADER_SHEEN ? curve_at(m->sheen_albedo, least(fabsf(cosine), 1)) : 0;
    *part = albedo > 1 ? 1 / albedo : 1;
    return 1 - m->sheen_most * least(albedo, 1);
}

/* Everything below is multiplied by the smaller of the fibres' transmittances for v and l. */
static inline void add_sheen(const shader_block *b, const incidence *at, const lanes3 h,
                             float (*restrict f)[LANES], float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        const shader *m = b->at[i];
        if (!(m->lobes & SHADER_SHEEN)) continue;
        float part, left = least(b->below_sheen[i], sheen_left(m, at->l[2][i], &part));
        float exponent = 1 / m->sheen_alpha, z = h[2][i];
        float d = (2 + exponent) * power_one_less(z * z < 1 ? z * z : 1, 0.5f * exponent) / (2 * PI);
        float masked = 1 + b->sheen_lambda[i] + sheen_lambda(m, at->l[2][i]);
        part = least(part, b->sheen_part[i]);
        float value = chosen(at->reflected[i], part * d / (4 * b->v[2][i] * masked), 0);
        for (int c = 0; c < 3; ++c) f[c][i] = f[c][i] * left + m->sheen[c] * value;
        density[i] += chosen(at->reflected[i], b->take[SHADER_TAKE_SHEEN][i] * (1 / (2 * PI)), 0);
    }
}
