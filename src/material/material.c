#include "material/material.h"

#include "base/kernel.h"
#include "math/limit.h"
#include "math/rgb.h"

unsigned material_features(const fathom_material *m) {
    bool specular = m->specular != FATHOM_SPECULAR_NONE && rgb_any(m->k_s);
    return (rgb_any(m->k_d) || specular ? MATERIAL_LIT : 0u) | (rgb_any(m->k_r) ? MATERIAL_MIRROR : 0u) |
           (rgb_any(m->k_t) ? MATERIAL_REFRACT : 0u) | (rgb_any(m->k_e) ? MATERIAL_EMIT : 0u);
}

bool material_absorbs(const fathom_material *m) {
    const float *c = m->attenuation_color;
    return m->model == FATHOM_MODEL_METALLIC_ROUGHNESS && m->thickness > 0 &&
           (m->transmission > 0 || m->diffuse_transmission > 0) && m->attenuation_distance > 0 &&
           (c[0] < 1 || c[1] < 1 || c[2] < 1);
}

/* A negative k_a means k_d. */
void bsdf_prepare(const fathom_material *m, const float ambient[3], bsdf *out) {
    const bool shiny = m->specular != FATHOM_SPECULAR_NONE && rgb_any(m->k_s);
    const float *k_a = m->k_a[0] < 0 ? m->k_d : m->k_a;
    *out = (bsdf){.shininess = m->shininess,
                  .ior = m->ior,
                  .phong = shiny && m->specular == FATHOM_SPECULAR_PHONG ? ~0u : 0,
                  .blinn = shiny && m->specular == FATHOM_SPECULAR_BLINN ? ~0u : 0,
                  .fresnel = m->fresnel ? ~0u : 0,
                  .from_behind = m->lit_from_behind ? ~0u : 0};
    for (int c = 0; c < 3; ++c) {
        out->k_d[c] = m->k_d[c];
        out->k_s[c] = m->specular == FATHOM_SPECULAR_NONE ? 0 : m->k_s[c];
        out->k_r[c] = m->k_r[c];
        out->k_t[c] = m->k_t[c];
        out->emission[c] = limited(k_a[c] * ambient[c] + m->k_e[c]);
    }
}

KERNEL_BEST(material_kernels)
