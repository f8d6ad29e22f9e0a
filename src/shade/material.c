#include "shade/material.h"

#include "shade/limit.h"

static bool any(const float rgb[3]) { return rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0; }

unsigned material_features(const fathom_material *m) {
    bool specular = m->specular != FATHOM_SPECULAR_NONE && any(m->k_s);
    return (any(m->k_d) || specular ? MATERIAL_LIT : 0u) | (any(m->k_r) ? MATERIAL_MIRROR : 0u) |
           (any(m->k_t) ? MATERIAL_REFRACT : 0u) | (any(m->k_e) ? MATERIAL_EMIT : 0u);
}

void material_add_constant(const material_block *m, const surface_block *s, const float ambient[3],
                           float *const radiance[3]) {
    for (int c = 0; c < 3; ++c) {
        float value[LANES];
        for (int i = 0; i < LANES; ++i)
            value[i] = limited(s->weight[c][i] * limited(m->k_a[c][i] * ambient[c] + m->k_e[c][i]));
        for (uint32_t i = 0; i < s->count; ++i) radiance[c][s->slot[i]] += value[i];
    }
}
