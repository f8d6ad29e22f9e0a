/* The model's materials as glTF's metallic-roughness materials: the inverse of reading, as far as they agree.
 *
 * glTF has no Phong lobe, no light from behind and no ambient reflectance; highlight and mirror are one
 * reflectance F0, blurred by one roughness. n is the exponent of Blinn's lobe and N(n) = (n + 2)(n + 4) / (8
 * (2^(-n/2) + n)) the inverse of its integral:
 * - roughness r: r^4 = 2 / (n + 2), lobes of equal width; 0 with a mirror;
 * - F0 = k_r with a mirror, else k_s / N(n);
 * - F0 without k_d and k_t is a metal of that base colour, unless Fresnel's law applies; else it is the
 * dielectric's
 *   ((ior - 1) / (ior + 1))^2, tinted by KHR_materials_specular to give F0;
 * - k_t goes to KHR_materials_transmission; k_d and k_t share the base colour;
 * - k_t without refraction (ior 1, no Fresnel) becomes 1 - alpha. */
#include "write/write_glb.h"

#include <string.h>

typedef struct pbr {
    double base[4], metallic, roughness, transmission, ior, specular, specular_color[3], emissive[3],
        strength;
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

/* Chooses ior and tint so that the layer's reflectance is f0. Under Fresnel's law k_r scales the dielectric's
 * own reflectance. */
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

static void set_emission(const fathom_material *m, pbr *out) {
    widen3(m->k_e, out->emissive);
    out->strength = fmax(largest(out->emissive), 1);
    for (int k = 0; k < 3; ++k) out->emissive[k] /= out->strength;
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
    set_emission(m, &out);
    return out;
}

static void put_list(write_text *t, const char *key, const double *numbers, int count) {
    write_put_key(t, key);
    write_put_numbers(t, numbers, count);
}

static void put_number(write_text *t, const char *key, double value) {
    write_put_key(t, key);
    write_put_double(t, value);
}

static void put_extension(write_text *t, const char *name, const char *key, double value) {
    write_put_key(t, name);
    write_put_text(t, "{");
    put_number(t, key, value);
    write_put_text(t, "}");
}

static bool is_tinted(const pbr *p) {
    return p->specular != 1 || p->specular_color[0] != 1 || p->specular_color[1] != 1 ||
           p->specular_color[2] != 1;
}

/* A bit for each extension: ior, transmission, emissive strength, specular. */
static unsigned extensions_of(const pbr *p) {
    return (p->ior != 1.5 ? 1u : 0u) | (p->transmission > 0 ? 2u : 0u) | (p->strength > 1 ? 4u : 0u) |
           (is_tinted(p) ? 8u : 0u);
}

static void put_extensions(write_text *t, const pbr *p) {
    write_put_key(t, "extensions");
    write_put_text(t, "{");
    if (p->ior != 1.5) put_extension(t, "KHR_materials_ior", "ior", p->ior);
    if (p->transmission > 0)
        put_extension(t, "KHR_materials_transmission", "transmissionFactor", p->transmission);
    if (p->strength > 1) put_extension(t, "KHR_materials_emissive_strength", "emissiveStrength", p->strength);
    if (is_tinted(p)) {
        write_put_key(t, "KHR_materials_specular");
        write_put_text(t, "{");
        put_number(t, "specularFactor", p->specular);
        if (p->specular > 0) put_list(t, "specularColorFactor", p->specular_color, 3);
        write_put_text(t, "}");
    }
    write_put_text(t, "}");
}

static void put_material(write_text *t, const char *name, const pbr *p) {
    write_put_text(t, "{");
    if (name) {
        write_put_key(t, "name");
        write_put_json(t, name);
    }
    write_put_key(t, "doubleSided");
    write_put_text(t, "true");
    write_put_key(t, "pbrMetallicRoughness");
    write_put_text(t, "{");
    put_list(t, "baseColorFactor", p->base, 4);
    put_number(t, "metallicFactor", p->metallic);
    put_number(t, "roughnessFactor", p->roughness);
    write_put_text(t, "}");
    if (largest(p->emissive) > 0) put_list(t, "emissiveFactor", p->emissive, 3);
    if (p->blend) {
        write_put_key(t, "alphaMode");
        write_put_text(t, "\"BLEND\"");
    }
    if (extensions_of(p)) put_extensions(t, p);
    write_put_text(t, "}");
}

static void put_extensions_used(glb *g) {
    unsigned used = 0;
    for (size_t i = 0; i < g->scene->materials.count; ++i) {
        pbr p = convert(&g->scene->materials.items[i].classic);
        used |= extensions_of(&p);
    }
    const char *const names[] = {"ior", "transmission", "emissive_strength", "specular"};
    const char *comma = "";
    if (!used) return;
    write_put_text(&g->json, ",\n\"extensionsUsed\":[");
    for (size_t i = 0; i < 4; ++i) {
        if (!(used >> i & 1)) continue;
        write_put(&g->json, "%s\"KHR_materials_%s\"", comma, names[i]);
        comma = ",";
    }
    write_put_text(&g->json, "]");
}

void glb_put_materials(glb *g) {
    put_extensions_used(g);
    write_put_text(&g->json, ",\n\"materials\":[");
    for (size_t i = 0; i < g->scene->materials.count; ++i) {
        const scene_named_material *material = &g->scene->materials.items[i];
        pbr p = convert(&material->value);
        write_put_text(&g->json, i ? ",\n" : "\n");
        put_material(&g->json, material->name, &p);
    }
    write_put_text(&g->json, "]");
}
