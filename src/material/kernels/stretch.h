/* Anisotropic GGX: one alpha along the surface's tangent, one across it (KHR_materials_anisotropy; Heitz
 * 2014). */
#pragma once

#include "material/kernels/incidence.h"

static inline __attribute__((always_inline)) bool is_stretched(const shader_block *b, bool rare, int i) {
    return rare && b->at[i]->lobes & SHADER_STRETCHED;
}

static inline float smith_stretched(const shader_block *b, int i, float x, float y, float z) {
    float ax = b->at[i]->along * x, ay = b->alpha[i] * y;
    return sqrtf(ax * ax + ay * ay + z * z);
}

static inline float ggx_stretched(const shader_block *b, int i, float hx, float hy, float hz) {
    float ax = b->at[i]->along, ay = b->alpha[i], ratio = ay / ax, both = ax * ay;
    float t = hx * hx * ratio + hy * hy / ratio + both * (hz * hz);
    return both / (PI * t * t);
}

/* Albedos for a direction, from the tables of energy.h. */
static inline void stretch_albedos(const shader *m, float x, float y, float z, float *all, float *edge) {
    float w = sqrtf(sqrtf(fabsf(z))) * ENERGY_STEPS, sum = fabsf(x) + fabsf(y);
    float t = (sum > 0 ? fabsf(y) / sum : 0) * ENERGY_TURNS;
    int k = (int)w < ENERGY_STEPS - 1 ? (int)w : ENERGY_STEPS - 1;
    int j = (int)t < ENERGY_TURNS - 1 ? (int)t : ENERGY_TURNS - 1;
    w -= (float)k, t -= (float)j;
    float out[2] = {0, 0};
    for (int r = 0; r < 4; ++r) {
        for (int c = 0; c < 2; ++c) {
            const float(*at)[ENERGY_NODES] = m->stretch.table[r]->albedo[c] + j;
            float low = at[0][k] + w * (at[0][k + 1] - at[0][k]);
            float high = at[1][k] + w * (at[1][k + 1] - at[1][k]);
            out[c] += m->stretch.weight[r] * (low + t * (high - low));
        }
    }
    *all = out[0], *edge = out[1];
}

/* Replaces the results of read_curves(), which does not handle anisotropic lobes. */
static inline void stretch_curves(const shader_block *b, const lanes3 d, float *restrict missing,
                                  float *restrict under) {
    for (int i = 0; i < LANES; ++i) {
        const shader *m = b->at[i];
        float all, edge;
        if (!(m->lobes & SHADER_STRETCHED) || !m->even) continue;
        stretch_albedos(m, d[0][i], d[1][i], d[2][i], &all, &edge);
        missing[i] = 1 - all;
        under[i] = shader_under(m, all, edge);
    }
}
