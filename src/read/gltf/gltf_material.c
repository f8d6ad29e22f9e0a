/* glTF materials: metallic-roughness, with the classic model's equivalent of scene/metallic.h.
 *
 * - alphaMode MASK: a base alpha below the cutoff makes the surface absent (k_t = 1, ior 1:
 * scene/mesh/absent.h).
 * - alphaMode BLEND: base alpha is coverage.
 * - KHR_materials_clearcoat and KHR_materials_volume: path tracing alone; without a volume transmission is a
 * thin wall there, and solid for the classic model.
 * - KHR_materials_unlit: emission of the base colour, nothing else.
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
#include "scene/metallic.h"

#include <math.h>
#include <string.h>

typedef enum alpha_mode { ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND } alpha_mode;

typedef struct factors {
    metallic_factors to; /* base and cover once all is read */
    double base[4], cutoff;
    double thickness, attenuation_color[3], attenuation_distance; /* path tracing alone, */
    double clearcoat, clearcoat_roughness;                        /* these, too */
    alpha_mode alpha;
} factors;

static const factors default_factors = {.to = {.metallic = 1,
                                               .roughness = 1,
                                               .emissive_strength = 1,
                                               .ior = 1.5,
                                               .specular = 1,
                                               .specular_color = {1, 1, 1}},
                                        .base = {1, 1, 1, 1},
                                        .attenuation_color = {1, 1, 1},
                                        .cutoff = 0.5};

/* The part of the surface that is there; light passes straight through the remaining part. */
static double coverage_of(const factors *f) {
    switch (f->alpha) {
    case ALPHA_OPAQUE: return 1;
    case ALPHA_MASK: return f->base[3] >= f->cutoff ? 1 : 0;
    case ALPHA_BLEND: return f->base[3];
    }
    return 1;
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
    f->to.unlit = false;
}

static fathom_status read_metallic_roughness(gltf *g, const gltf_value *at, factors *f) {
    gltf_value pbr;
    fathom_status status = gltf_object(g, at, "pbrMetallicRoughness", &pbr);
    if (status == FATHOM_OK) status = gltf_numbers(g, &pbr, "baseColorFactor", 4, 0, 1, f->base);
    if (status == FATHOM_OK) status = gltf_number(g, &pbr, "metallicFactor", 0, 1, &f->to.metallic);
    if (status == FATHOM_OK) status = gltf_number(g, &pbr, "roughnessFactor", 0, 1, &f->to.roughness);
    if (lacks_texture(g, &pbr, "baseColorTexture",
                      f->to.unlit ? "grey 0.5, and the material as lit" : "grey 0.5"))
        without_base(f);
    if (lacks_texture(g, &pbr, "metallicRoughnessTexture", "no metal, and rough")) f->to.metallic = 0;
    return status;
}

/* The older workflow, instead of metallic and roughness. */
static fathom_status read_specular_glossiness(gltf *g, const gltf_value *pbr, factors *f) {
    double glossiness = 1;
    fathom_status status = gltf_numbers(g, pbr, "diffuseFactor", 4, 0, 1, f->base);
    if (status == FATHOM_OK) status = gltf_numbers(g, pbr, "specularFactor", 3, 0, 1, f->to.specular_color);
    if (status == FATHOM_OK) status = gltf_number(g, pbr, "glossinessFactor", 0, 1, &glossiness);
    if (lacks_texture(g, pbr, "diffuseTexture",
                      f->to.unlit ? "grey 0.5, and the material as lit" : "grey 0.5"))
        without_base(f);
    f->to.metallic = f->to.ior = 0;
    f->to.roughness = 1 - glossiness;
    if (lacks_texture(g, pbr, "specularGlossinessTexture", "specular 0.04, and rough")) {
        for (int i = 0; i < 3; ++i) f->to.specular_color[i] *= 0.04;
        f->to.roughness = 1;
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
    if (status == FATHOM_OK) status = gltf_number(g, &ior, "ior", 0, 1e3, &f->to.ior);
    if (status == FATHOM_OK && f->to.ior > 0 && f->to.ior < 1)
        return gltf_fail(g, &ior, "ior", "is %g; expected 0 or a number >= 1", f->to.ior);
    return status;
}

static fathom_status read_specular(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value specular;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_specular", &specular);
    if (status == FATHOM_OK) status = gltf_number(g, &specular, "specularFactor", 0, 1, &f->to.specular);
    if (status == FATHOM_OK)
        status = gltf_numbers(g, &specular, "specularColorFactor", 3, 0, 1e6, f->to.specular_color);
    lacks_texture(g, &specular, "specularTexture", "1");
    lacks_texture(g, &specular, "specularColorTexture", "white");
    return status;
}

/* attenuationDistance is infinite where it is absent. */
static fathom_status read_volume(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value volume;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_volume", &volume);
    if (status == FATHOM_OK) status = gltf_number(g, &volume, "thicknessFactor", 0, 1e30, &f->thickness);
    if (status == FATHOM_OK)
        status = gltf_numbers(g, &volume, "attenuationColor", 3, 0, 1, f->attenuation_color);
    if (status == FATHOM_OK)
        status = gltf_number(g, &volume, "attenuationDistance", 0, 1e30, &f->attenuation_distance);
    lacks_texture(g, &volume, "thicknessTexture", "1");
    return status;
}

static fathom_status read_clearcoat(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value coat;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_clearcoat", &coat);
    if (status == FATHOM_OK) status = gltf_number(g, &coat, "clearcoatFactor", 0, 1, &f->clearcoat);
    if (status == FATHOM_OK)
        status = gltf_number(g, &coat, "clearcoatRoughnessFactor", 0, 1, &f->clearcoat_roughness);
    lacks_texture(g, &coat, "clearcoatTexture", "1");
    lacks_texture(g, &coat, "clearcoatRoughnessTexture", "1");
    lacks_texture(g, &coat, "clearcoatNormalTexture", "flat");
    return status;
}

static fathom_status read_extensions(gltf *g, const gltf_value *at, factors *f) {
    gltf_value extensions, transmission, emissive, glossiness;
    fathom_status status = gltf_object(g, at, "extensions", &extensions);
    if (status == FATHOM_OK) status = read_ior(g, &extensions, f);
    if (status == FATHOM_OK) status = read_specular(g, &extensions, f);
    if (status == FATHOM_OK) status = read_volume(g, &extensions, f);
    if (status == FATHOM_OK) status = read_clearcoat(g, &extensions, f);
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_transmission", &transmission);
    if (status != FATHOM_OK) return status;
    status = gltf_number(g, &transmission, "transmissionFactor", 0, 1, &f->to.transmission);
    if (lacks_texture(g, &transmission, "transmissionTexture", "opaque")) f->to.transmission = 0;
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_emissive_strength", &emissive);
    if (status == FATHOM_OK)
        status = gltf_number(g, &emissive, "emissiveStrength", 0, 1e30, &f->to.emissive_strength);
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_pbrSpecularGlossiness", &glossiness);
    if (status != FATHOM_OK) return status;
    return glossiness.json ? read_specular_glossiness(g, &glossiness, f) : read_metallic_roughness(g, at, f);
}

static fathom_status read_unlit(gltf *g, const gltf_value *at, factors *f) {
    gltf_value extensions, unlit;
    fathom_status status = gltf_extension(g, at, "KHR_materials_unlit", &extensions, &unlit);
    f->to.unlit = status == FATHOM_OK && unlit.json;
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
    if (status == FATHOM_OK) status = gltf_numbers(g, at, "emissiveFactor", 3, 0, 1, f->to.emissive);
    if (status == FATHOM_OK) status = read_alpha(g, at, f);
    if (status == FATHOM_OK) status = read_sides(g, at);
    if (lacks_texture(g, at, "emissiveTexture", "black")) memset(f->to.emissive, 0, sizeof f->to.emissive);
    lacks_texture(g, at, "normalTexture", "flat");
    lacks_texture(g, at, "occlusionTexture", "none");
    return status;
}

/* The material of path tracing, and its classic equivalent. */
static void make(factors *f, fathom_material *material, fathom_material *classic) {
    memcpy(f->to.base, f->base, sizeof f->to.base);
    f->to.cover = coverage_of(f);
    metallic_to_classic(&f->to, classic);
    metallic_to_material(&f->to, material);
    material->thickness = (float)f->thickness;
    material->clearcoat = (float)f->clearcoat;
    material->clearcoat_roughness = (float)f->clearcoat_roughness;
    material->attenuation_distance = (float)f->attenuation_distance;
    for (int c = 0; c < 3; ++c) material->attenuation_color[c] = (float)f->attenuation_color[c];
}

fathom_status gltf_material_make(gltf *g, uint32_t index, gltf_material *out) {
    bool given = index != GLTF_ABSENT;
    gltf_material *kept = &g->material_table[given ? index : gltf_count(&g->materials)];
    if (kept->id == FATHOM_NONE) {
        gltf_value at = {.json = NULL};
        const char *name = NULL;
        factors f = default_factors;
        fathom_material material, classic;
        fathom_status status = given ? gltf_item(g, &g->materials, index, &at) : FATHOM_OK;
        if (status == FATHOM_OK) status = gltf_text(g, &at, "name", &name);
        if (status == FATHOM_OK) status = read_factors(g, &at, &f);
        if (status != FATHOM_OK) return status;
        make(&f, &material, &classic);
        kept->flags = flags_of(&classic);
        status = scene_add_material_as(g->scene, name, &material, &classic, &kept->id);
        if (status != FATHOM_OK) return gltf_within(g, &at, NULL, status);
    }
    *out = *kept;
    return FATHOM_OK;
}
