#include "shade/kernels/kernel.h"

static void set_lane(const fathom_material *m, int i, material_block *out) {
    const float *k_a = m->k_a[0] < 0 ? m->k_d : m->k_a;
    for (int c = 0; c < 3; ++c) {
        out->k_a[c][i] = k_a[c];
        out->k_d[c][i] = m->k_d[c];
        out->k_s[c][i] = m->specular == FATHOM_SPECULAR_NONE ? 0 : m->k_s[c];
        out->k_r[c][i] = m->k_r[c];
        out->k_t[c][i] = m->k_t[c];
        out->k_e[c][i] = m->k_e[c];
    }
    out->shininess[i] = m->shininess;
    out->ior[i] = m->ior;
    out->phong[i] = m->specular == FATHOM_SPECULAR_PHONG ? ~0u : 0;
    out->blinn[i] = m->specular == FATHOM_SPECULAR_BLINN ? ~0u : 0;
    out->fresnel[i] = m->fresnel ? ~0u : 0;
    out->from_behind[i] = m->lit_from_behind ? ~0u : 0;
}

void KERNEL(material_gather)(const scene_named_material *table, const surface_block *s, material_block *out) {
    uint32_t differ = 0;
    for (int i = 1; i < LANES; ++i) differ |= s->material[i] ^ s->material[0];
    /* Most blocks see one material: a loop over lanes that copies the same numbers vectorises. */
    if (differ) {
        for (int i = 0; i < LANES; ++i) set_lane(&table[s->material[i]].value, i, out);
    } else {
        const fathom_material m = table[s->material[0]].value;
        for (int i = 0; i < LANES; ++i) set_lane(&m, i, out);
    }
}
