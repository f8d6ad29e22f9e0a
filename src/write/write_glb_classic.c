/* Materials of the classic model as glTF's metallic-roughness materials.
 *
 * glTF has no Phong lobe and no ambient reflectance. It has one reflectance F0 for highlight and mirror, with
 * one roughness. Below, n is the exponent of Blinn's lobe, and
 * N(n) = (n + 2)(n + 4) / (8 (2^(-n/2) + n)) is 1 divided by the lobe's integral:
 * - roughness r: r^4 = 2 / (n + 2), for lobes of equal width; 0 with a mirror;
 * - F0 = k_r with a mirror, else k_s / N(n);
 * - F0 without k_d and k_t becomes a metal of this base colour, unless Fresnel's law applies. Otherwise it is
 *   the dielectric's ((ior - 1) / (ior + 1))^2, with a tint by KHR_materials_specular that gives F0;
 * - k_t becomes KHR_materials_transmission into a solid, which bends light, by a thickness of 1; its value
 * matters to rasterizers alone, which know no way through a mesh; k_d and k_t share the base colour;
 * - k_t without refraction (ior 1, no Fresnel) becomes 1 - alpha;
 * - lit_from_behind becomes KHR_materials_diffuse_transmission of half the light through a base colour of
 *   2 k_d; glTF has none brighter than 1. */
#include "write/write_glb.h"

#include <string.h>

typedef struct pbr {
    double base[4], metallic, roughness, transmission, ior, specular, specular_color[3];
    bool blend;
} pbr;

static double largest(const double v[3]) { return fmax(v[0], fmax(v[1], v[2])); }

static void widen3(const float from[3], double to[3]) {
    for (int k = 0; k < 3; ++k) to[k] = (double)from[k];
}

/* Sets the reflectance at normal incidence; returns the roughness. */
static double reflectance(const fathom_material *m, double f0[3]) {
    double n = write_blinn_exponent(m), mirror[3], scale = (n + 2) * (n + 4) / (8 * (exp2(-n / 2) + n));
    widen3(m->k_r, mirror);
    bool has_mirror = largest(mirror) > 0, has_lobe = m->specular != FATHOM_SPECULAR_NONE;
    for (int k = 0; k < 3; ++k)
        f0[k] = has_mirror ? mirror[k] : has_lobe ? fmin((double)m->k_s[k] / scale, 1) : 0;
    return has_mirror ? 0 : has_lobe ? sqrt(sqrt(2 / (n + 2))) : 1;
}

/* Chooses ior and tint so that the layer's reflectance is f0. With Fresnel's law, k_r is a factor of the
 * dielectric's own reflectance. */
static void set_layer(const fathom_material *m, double f0[3], pbr *out) {
    out->ior = m->ior >= 1 ? (double)m->ior : 1 / (double)m->ior;
    if (m->fresnel && m->k_r[0] + m->k_r[1] + m->k_r[2] > 0) {
        double own = (out->ior - 1) / (out->ior + 1);
        for (int k = 0; k < 3; ++k) f0[k] *= own * own;
    }
    if (largest(f0) > 0 && out->ior == 1) out->ior = 1.5;
    double own = (out->ior - 1) / (out->ior + 1);
    out->specular = largest(f0) > 0 ? 1 : 0;
    for (int k = 0; k < 3; ++k) out->specular_color[k] = out->specular > 0 ? f0[k] / (own * own) : 1;
}

static void set_base(const fathom_material *m, const double f0[3], pbr *out) {
    double diffuse[3], through[3];
    widen3(m->k_d, diffuse);
    widen3(m->k_t, through);
    out->blend = largest(through) > 0 && m->ior == 1 && !m->fresnel;
    if (out->blend)
        out->base[3] = 1 - fmin(largest(through), 1);
    else if (largest(through) > 0)
        out->transmission = largest(through) / (largest(through) + largest(diffuse));
    double cover = out->base[3];
    for (int k = 0; k < 3; ++k) {
        double under = f0[k] < 1 ? diffuse[k] / (1 - f0[k]) : diffuse[k];
        if (cover > 0) under /= cover;
        out->base[k] = fmin(out->blend ? under : under + through[k], 1);
    }
}

static void narrow3(const double from[3], float to[3]) {
    for (int k = 0; k < 3; ++k) to[k] = (float)from[k];
}

static pbr convert(const fathom_material *m) {
    pbr out = {.base = {0, 0, 0, 1}, .ior = 1.5, .specular = 1, .specular_color = {1, 1, 1}};
    double f0[3], diffuse[3], through[3];
    out.roughness = reflectance(m, f0);
    widen3(m->k_d, diffuse);
    widen3(m->k_t, through);
    if (largest(f0) > 0 && largest(diffuse) == 0 && largest(through) == 0 && !m->fresnel) {
        out.metallic = 1;
        for (int k = 0; k < 3; ++k) out.base[k] = fmin(f0[k], 1);
    } else {
        set_layer(m, f0, &out);
        set_base(m, f0, &out);
    }
    return out;
}

bool glb_is_exact(const fathom_material *m) {
    return m->specular == FATHOM_SPECULAR_NONE && write_is_black(m->k_r) && write_is_black(m->k_t) &&
           m->k_a[0] < 0 && (!m->lit_from_behind || fmaxf(m->k_d[0], fmaxf(m->k_d[1], m->k_d[2])) <= 0.5f);
}

/* Keeps the maps of parameters that both models have. */
fathom_material glb_classic(const fathom_material *m, size_t *lost) {
    static const unsigned both = 1u << FATHOM_MAP_COLOR | 1u << FATHOM_MAP_OPACITY |
                                 1u << FATHOM_MAP_EMISSIVE | 1u << FATHOM_MAP_NORMAL | 1u << FATHOM_MAP_BUMP;
    const pbr p = convert(m);
    fathom_material out;
    fathom_material_default(&out);
    out.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    narrow3(p.base, out.base_color), narrow3(p.specular_color, out.specular_color);
    out.opacity = (float)p.base[3], out.metallic = (float)p.metallic, out.roughness = (float)p.roughness;
    out.thickness = p.transmission > 0 ? 1 : 0;
    out.transmission = (float)p.transmission, out.ior = (float)p.ior, out.specular_factor = (float)p.specular;
    memcpy(out.emissive, m->k_e, sizeof out.emissive);
    out.normal_scale = m->normal_scale;
    const bool leaf = m->lit_from_behind && glb_is_exact(m);
    if (leaf) {
        out.diffuse_transmission = 0.5f;
        for (int k = 0; k < 3; ++k) out.base_color[k] = out.diffuse_transmission_color[k] = 2 * m->k_d[k];
    }
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        if (both >> k & 1)
            out.maps[k] = m->maps[k];
        else
            *lost += m->maps[k].texture != FATHOM_NONE;
    }
    if (leaf) out.maps[FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR] = m->maps[FATHOM_MAP_COLOR];
    return out;
}
