#include "material/material.h"

#include "base/kernel.h"

static bool any(const float rgb[3]) { return rgb[0] > 0 || rgb[1] > 0 || rgb[2] > 0; }

unsigned material_features(const fathom_material *m) {
    bool specular = m->specular != FATHOM_SPECULAR_NONE && any(m->k_s);
    return (any(m->k_d) || specular ? MATERIAL_LIT : 0u) | (any(m->k_r) ? MATERIAL_MIRROR : 0u) |
           (any(m->k_t) ? MATERIAL_REFRACT : 0u) | (any(m->k_e) ? MATERIAL_EMIT : 0u);
}

KERNEL_CHOICE(material_kernels)
