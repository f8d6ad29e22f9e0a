/* glTF materials to the model's.
 *
 * glTF describes a microfacet surface: a dielectric layer over a diffuse base, mixed with a metal. The
 * model has Lambert, a Blinn highlight, a mirror and refraction. With m = metallic, b = base colour, r =
 * roughness, alpha = r^2, T = transmission, f0 = ((ior - 1) / (ior + 1))^2 tinted by
 * KHR_materials_specular, and F0 = (1 - m) f0 + m b:
 *
 * - k_d = (1 - m) (1 - T) (1 - f0) b: what the layer reflects does not reach the base. The format's BRDF
 *   is b / pi; the model's has no 1 / pi, which the lights carry (see gltf_light.c).
 * - n = 2 / alpha^2 - 2, in [1, 1e6]: Blinn's exponent whose lobe is as wide as the format's. The variance
 *   of its slopes is 2 / (n + 2), that of a Beckmann lobe alpha^2.
 * - k_s = F0 N(n), N(n) = (n + 2)(n + 4) / (8 (2^(-n/2) + n)): the lobe sends back F0 of the light that
 *   meets it head on, since its integral with the cosine is pi / N(n). Capped, hue unchanged, so that k_d
 *   + k_s <= 1 in every channel: small bright lobes stay displayable.
 * - k_r = w F0, w = t^2 / (alpha^2 + t^2), t = tan(3 degrees): the share of GGX microfacets tilted by less
 *   than 3 degrees, the part of the reflection that is blurred so little that a mirror may stand for it.
 *   Below 5 % (r > 0.48) there is none. A dielectric (m < 1/2) has k_r = w times the specular factor, and
 *   `fresnel`, whose reflectance rises from f0; metals keep their colour instead.
 * - k_t = (1 - m) T b, refracted by ior, with Fresnel (where there is none: times 1 - f0); unblurred
 *   whatever r is. The format's transmission without a volume is a thin wall; here the mesh is taken as a
 *   solid.
 * - k_a = k_d + (1 - w) F0: light from all around is reflected by the rough part; the mirror finds its
 *   own.
 *
 * Lights are never met by mirrored rays, so k_s (lights) and k_r (everything else) share F0 without
 * counting it twice: what a surface reflects is k_d + max(k_s / N, k_r F) + k_t (1 - F) <= 1.
 *
 * - alphaMode MASK: a base alpha below the cutoff makes the surface absent (k_t = 1, ior 1:
 * scene/mesh/absent.h).
 * - alphaMode BLEND: base alpha a is coverage. All of the above is scaled by a, and k_t gets 1 - a with ior
 * 1, which passes straight on. With T > 0 the refraction's ior stays.
 * - KHR_materials_unlit: k_e = b, nothing else.
 * - emissiveFactor: k_e = factor times KHR_materials_emissive_strength; it lights nothing else.
 * - ior 0: F0 is the specular colour, no refraction. Older workflows are carried over so.
 * - KHR_materials_pbrSpecularGlossiness: an ior of 0 with the specular colour, a dielectric with the diffuse
 *   colour as b, and r = 1 - glossiness.
 *
 * Textures are not read. Their factors are mostly 1 and mean little alone, so each texture is replaced by the
 * least wrong even value:
 *
 * - base colour and diffuse: grey 0.5, alpha 1. White would be brighter than any texture.
 * - an unlit material with a base colour texture is lit: an even colour would show only an outline.
 * - metallic and roughness: 0 and 1. Most surfaces are no metals, and a metal without its colour is white.
 * - specular and glossiness: 0.04 and 0, for the same reason.
 * - emission and transmission: 0. They are spots on most models; everywhere they would hide the model.
 * - specular factors, normals, occlusion: 1, flat, none.
 *
 * A mesh whose material lets more than half of the light through casts no shadow, because shadow rays are all
 * or nothing. */
#include "read/gltf/gltf.h"

#include <math.h>
#include <string.h>

typedef enum alpha_mode { ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND } alpha_mode;

typedef struct factors {
    double base[4], metallic, roughness, emissive[3], emissive_strength;
    double ior, transmission, specular, specular_color[3];
    alpha_mode alpha;
    double cutoff;
    bool unlit;
} factors;

static const factors default_factors = {.base = {1, 1, 1, 1},
                                        .metallic = 1,
                                        .roughness = 1,
                                        .emissive_strength = 1,
                                        .ior = 1.5,
                                        .specular = 1,
                                        .specular_color = {1, 1, 1},
                                        .cutoff = 0.5};

/* ---- mapping ---- */

static double mirror_share(double alpha) {
    const double tangent = 0.052407779283041196; /* tan(3 degrees) */
    double w = tangent * tangent / (alpha * alpha + tangent * tangent);
    return w < 0.05 ? 0 : w;
}

static double exponent_of(double alpha) {
    /* alpha = 0 gives infinity, which the clamp takes. */
    return fmin(fmax(2 / (alpha * alpha) - 2, 1), 1e6);
}

static double lobe_norm(double n) { return (n + 2) * (n + 4) / (8 * (exp2(-n / 2) + n)); }

/* The part of the surface that is there; light passes straight through the remaining part. */
static double coverage_of(const factors *f) {
    switch (f->alpha) {
    case ALPHA_OPAQUE: return 1;
    case ALPHA_MASK: return f->base[3] >= f->cutoff ? 1 : 0;
    case ALPHA_BLEND: return f->base[3];
    }
    return 1;
}

static void map_lit(const factors *f, fathom_material *out) {
    double m = f->metallic, alpha = f->roughness * f->roughness;
    double ratio = f->ior > 0 ? (f->ior - 1) / (f->ior + 1) : 1, w = mirror_share(alpha);
    double n = exponent_of(alpha), scale = lobe_norm(n), diffuse[3], f0[3];
    double cover = coverage_of(f);
    bool refracts = cover > 0 && f->transmission > 0 && f->ior > 0 && m < 1;
    bool straight = cover < 1 && !refracts;
    out->fresnel = f->ior > 0 && m < 0.5 && !straight;
    for (int i = 0; i < 3; ++i) {
        double layer = f->specular * fmin(ratio * ratio * f->specular_color[i], 1), b = f->base[i];
        f0[i] = (1 - m) * layer + m * b;
        diffuse[i] = (1 - m) * (1 - f->transmission) * (1 - layer) * b;
        if (f0[i] > 0) scale = fmin(scale, (1 - diffuse[i]) / f0[i]);
        double mirror = out->fresnel ? fmin(f->specular * f->specular_color[i], 1) : f0[i];
        out->k_r[i] = (float)(cover * w * mirror);
        double inward = out->fresnel ? 1 : 1 - layer;
        out->k_t[i] = (float)(cover * (1 - m) * f->transmission * inward * b + 1 - cover);
        out->k_d[i] = (float)(cover * diffuse[i]);
        out->k_a[i] = (float)(cover * (diffuse[i] + (1 - w) * f0[i]));
    }
    for (int i = 0; i < 3; ++i) {
        out->k_s[i] = (float)(cover * scale * f0[i]);
        if (out->k_s[i] > 0) out->specular = FATHOM_SPECULAR_BLINN;
    }
    out->shininess = (float)n;
    out->ior = straight || !(f->ior > 0) ? 1 : (float)f->ior;
}

static void map(const factors *f, fathom_material *out) {
    fathom_material_default(out);
    double cover = coverage_of(f);
    for (int i = 0; i < 3; ++i) out->k_e[i] = (float)(cover * f->emissive_strength * f->emissive[i]);
    if (!f->unlit) {
        map_lit(f, out);
        return;
    }
    out->ior = 1;
    for (int i = 0; i < 3; ++i) {
        out->k_a[i] = out->k_d[i] = 0;
        out->k_e[i] = (float)(cover * f->base[i]);
        out->k_t[i] = (float)(1 - cover);
    }
}

static unsigned flags_of(const fathom_material *m) {
    return m->k_t[0] + m->k_t[1] + m->k_t[2] > 1.5f ? FATHOM_CASTS_NO_SHADOW : 0;
}

/* ---- reading ---- */

/* Whether there is such a texture; then notes that it is not read, and its replacement. */
static bool lacks_texture(gltf *g, const gltf_value *at, const char *key, const char *taken) {
    if (!json_object_get(at->json, key)) return false;
    gltf_note(g, at, NULL, "%s is not read, and taken as %s", key, taken);
    return true;
}

static void without_base(factors *f) {
    for (int i = 0; i < 3; ++i) f->base[i] *= 0.5;
    f->unlit = false;
}

static fathom_status read_metallic_roughness(gltf *g, const gltf_value *at, factors *f) {
    gltf_value pbr;
    fathom_status status = gltf_object(g, at, "pbrMetallicRoughness", &pbr);
    if (status == FATHOM_OK) status = gltf_numbers(g, &pbr, "baseColorFactor", 4, 0, 1, f->base);
    if (status == FATHOM_OK) status = gltf_number(g, &pbr, "metallicFactor", 0, 1, &f->metallic);
    if (status == FATHOM_OK) status = gltf_number(g, &pbr, "roughnessFactor", 0, 1, &f->roughness);
    if (lacks_texture(g, &pbr, "baseColorTexture",
                      f->unlit ? "grey 0.5, and the material as lit" : "grey 0.5"))
        without_base(f);
    if (lacks_texture(g, &pbr, "metallicRoughnessTexture", "no metal, and rough")) f->metallic = 0;
    return status;
}

/* The older workflow, instead of metallic and roughness. */
static fathom_status read_specular_glossiness(gltf *g, const gltf_value *pbr, factors *f) {
    double glossiness = 1;
    fathom_status status = gltf_numbers(g, pbr, "diffuseFactor", 4, 0, 1, f->base);
    if (status == FATHOM_OK) status = gltf_numbers(g, pbr, "specularFactor", 3, 0, 1, f->specular_color);
    if (status == FATHOM_OK) status = gltf_number(g, pbr, "glossinessFactor", 0, 1, &glossiness);
    if (lacks_texture(g, pbr, "diffuseTexture", f->unlit ? "grey 0.5, and the material as lit" : "grey 0.5"))
        without_base(f);
    f->metallic = f->ior = 0;
    f->roughness = 1 - glossiness;
    if (lacks_texture(g, pbr, "specularGlossinessTexture", "specular 0.04, and rough")) {
        for (int i = 0; i < 3; ++i) f->specular_color[i] *= 0.04;
        f->roughness = 1;
    }
    return status;
}

static fathom_status read_alpha(gltf *g, const gltf_value *at, factors *f) {
    const char *mode = "OPAQUE";
    fathom_status status = gltf_text(g, at, "alphaMode", &mode);
    if (status == FATHOM_OK) status = gltf_number(g, at, "alphaCutoff", 0, INFINITY, &f->cutoff);
    if (status != FATHOM_OK) return status;
    if (strcmp(mode, "OPAQUE") == 0)
        f->alpha = ALPHA_OPAQUE;
    else if (strcmp(mode, "MASK") == 0)
        f->alpha = ALPHA_MASK;
    else if (strcmp(mode, "BLEND") == 0)
        f->alpha = ALPHA_BLEND;
    else
        return gltf_fail(g, at, "alphaMode", "is \"%.40s\"; expected OPAQUE, MASK or BLEND", mode);
    return FATHOM_OK;
}

static fathom_status read_ior(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value ior;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_ior", &ior);
    if (status == FATHOM_OK) status = gltf_number(g, &ior, "ior", 0, 1e3, &f->ior);
    if (status == FATHOM_OK && f->ior > 0 && f->ior < 1)
        return gltf_fail(g, &ior, "ior", "is %g; expected 0 or a number >= 1", f->ior);
    return status;
}

static fathom_status read_specular(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value specular;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_specular", &specular);
    if (status == FATHOM_OK) status = gltf_number(g, &specular, "specularFactor", 0, 1, &f->specular);
    if (status == FATHOM_OK)
        status = gltf_numbers(g, &specular, "specularColorFactor", 3, 0, 1e6, f->specular_color);
    lacks_texture(g, &specular, "specularTexture", "1");
    lacks_texture(g, &specular, "specularColorTexture", "white");
    return status;
}

static fathom_status read_extensions(gltf *g, const gltf_value *at, factors *f) {
    gltf_value extensions, transmission, emissive, glossiness;
    fathom_status status = gltf_object(g, at, "extensions", &extensions);
    if (status == FATHOM_OK) status = read_ior(g, &extensions, f);
    if (status == FATHOM_OK) status = read_specular(g, &extensions, f);
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_transmission", &transmission);
    if (status != FATHOM_OK) return status;
    status = gltf_number(g, &transmission, "transmissionFactor", 0, 1, &f->transmission);
    if (lacks_texture(g, &transmission, "transmissionTexture", "opaque")) f->transmission = 0;
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_emissive_strength", &emissive);
    if (status == FATHOM_OK)
        status = gltf_number(g, &emissive, "emissiveStrength", 0, 1e30, &f->emissive_strength);
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_pbrSpecularGlossiness", &glossiness);
    if (status != FATHOM_OK) return status;
    return glossiness.json ? read_specular_glossiness(g, &glossiness, f) : read_metallic_roughness(g, at, f);
}

static fathom_status read_unlit(gltf *g, const gltf_value *at, factors *f) {
    gltf_value extensions, unlit;
    fathom_status status = gltf_extension(g, at, "KHR_materials_unlit", &extensions, &unlit);
    f->unlit = status == FATHOM_OK && unlit.json;
    return status;
}

static fathom_status read_sides(gltf *g, const gltf_value *at) {
    bool both = true;
    fathom_status status = gltf_flag(g, at, "doubleSided", &both);
    if (!both) gltf_note(g, at, "doubleSided", "back faces are seen, whatever doubleSided says");
    return status;
}

static fathom_status read_factors(gltf *g, const gltf_value *at, factors *f) {
    fathom_status status = read_unlit(g, at, f);
    if (status == FATHOM_OK) status = read_extensions(g, at, f);
    if (status == FATHOM_OK) status = gltf_numbers(g, at, "emissiveFactor", 3, 0, 1, f->emissive);
    if (status == FATHOM_OK) status = read_alpha(g, at, f);
    if (status == FATHOM_OK) status = read_sides(g, at);
    if (lacks_texture(g, at, "emissiveTexture", "black")) memset(f->emissive, 0, sizeof f->emissive);
    lacks_texture(g, at, "normalTexture", "flat");
    lacks_texture(g, at, "occlusionTexture", "none");
    return status;
}

fathom_status gltf_material_make(gltf *g, uint32_t index, gltf_material *out) {
    bool given = index != GLTF_ABSENT;
    gltf_material *kept = &g->material_table[given ? index : gltf_count(&g->materials)];
    if (kept->id == FATHOM_NONE) {
        gltf_value at = {.json = NULL};
        const char *name = NULL;
        factors f = default_factors;
        fathom_material material;
        fathom_status status = given ? gltf_item(g, &g->materials, index, &at) : FATHOM_OK;
        if (status == FATHOM_OK) status = gltf_text(g, &at, "name", &name);
        if (status == FATHOM_OK) status = read_factors(g, &at, &f);
        if (status != FATHOM_OK) return status;
        map(&f, &material);
        kept->flags = flags_of(&material);
        status = fathom_scene_add_material(g->scene, name, &material, &kept->id);
        if (status != FATHOM_OK) return gltf_within(g, &at, NULL, status);
    }
    *out = *kept;
    return FATHOM_OK;
}
