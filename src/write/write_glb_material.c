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
#include "write/write.h"

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

static const struct extension {
    const char *name, *key;
    size_t offset; /* of the value */
    double absent; /* the value without the extension */
} extensions[] = {{"ior", "ior", offsetof(pbr, ior), 1.5},
                  {"transmission", "transmissionFactor", offsetof(pbr, transmission), 0},
                  {"emissive_strength", "emissiveStrength", offsetof(pbr, strength), 1},
                  {"specular", "specularFactor", offsetof(pbr, specular), 1}};
enum { EXTENSIONS = sizeof extensions / sizeof *extensions };

static double extension_value(const pbr *p, size_t i) {
    return *(const double *)(const void *)((const char *)p + extensions[i].offset);
}

static bool is_tinted(const pbr *p) {
    return p->specular > 0 &&
           (p->specular_color[0] != 1 || p->specular_color[1] != 1 || p->specular_color[2] != 1);
}

/* A bit for each extension. */
static unsigned extensions_of(const pbr *p) {
    unsigned used = is_tinted(p) ? 1u << (EXTENSIONS - 1) : 0;
    for (size_t i = 0; i < EXTENSIONS; ++i) {
        if (extension_value(p, i) != extensions[i].absent) used |= 1u << i;
    }
    return used;
}

static void put_rgb(file_writer *t, const char *key, const double rgb[3]) {
    file_writer_print(t, ",\"%s\":[%.17g,%.17g,%.17g]", key, rgb[0], rgb[1], rgb[2]);
}

static void put_extensions(file_writer *t, const pbr *p) {
    const unsigned used = extensions_of(p);
    const char *comma = ",\"extensions\":{";
    for (size_t i = 0; i < EXTENSIONS; ++i) {
        if (!(used >> i & 1)) continue;
        file_writer_print(t, "%s\"KHR_materials_%s\":{\"%s\":%.17g", comma, extensions[i].name,
                          extensions[i].key, extension_value(p, i));
        if (i == EXTENSIONS - 1 && is_tinted(p)) put_rgb(t, "specularColorFactor", p->specular_color);
        file_writer_print(t, "}");
        comma = ",";
    }
    if (used) file_writer_print(t, "}");
}

static void put_material(file_writer *t, const char *name, const pbr *p) {
    file_writer_print(
        t,
        "{\"doubleSided\":true,\"pbrMetallicRoughness\":{\"baseColorFactor\":[%.17g,%.17g,%.17g,"
        "%.17g],\"metallicFactor\":%.17g,\"roughnessFactor\":%.17g}",
        p->base[0], p->base[1], p->base[2], p->base[3], p->metallic, p->roughness);
    if (name) {
        file_writer_print(t, ",\"name\":");
        write_quoted(t, name);
    }
    if (largest(p->emissive) > 0) put_rgb(t, "emissiveFactor", p->emissive);
    if (p->blend) file_writer_print(t, ",\"alphaMode\":\"BLEND\"");
    put_extensions(t, p);
    file_writer_print(t, "}");
}

void write_glb_materials(file_writer *t, const fathom_scene *scene) {
    unsigned used = 0;
    file_writer_print(t, ",\n\"materials\":[");
    for (size_t i = 0; i < scene->materials.count; ++i) {
        const pbr p = convert(&scene->materials.items[i].classic);
        used |= extensions_of(&p);
        file_writer_print(t, i ? ",\n" : "\n");
        put_material(t, scene->materials.items[i].name, &p);
    }
    const char *comma = "],\n\"extensionsUsed\":[";
    for (size_t i = 0; i < EXTENSIONS; ++i) {
        if (!(used >> i & 1)) continue;
        file_writer_print(t, "%s\"KHR_materials_%s\"", comma, extensions[i].name);
        comma = ",";
    }
    file_writer_print(t, "]");
}
