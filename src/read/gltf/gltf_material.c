/* glTF materials: metallic-roughness, with the classic model's equivalent of scene/metallic.h.
 *
 * - alphaMode MASK: a base alpha below the cutoff makes the surface absent (k_t = 1, ior 1:
 * scene/mesh/absent.h).
 * - alphaMode BLEND: base alpha is coverage.
 * - KHR_materials_clearcoat and KHR_materials_volume: path tracing alone; without a volume transmission is a
 * thin wall there, and solid for the classic model.
 * - KHR_materials_sheen, _anisotropy, _iridescence, _dispersion and _diffuse_transmission: path tracing alone
 *   (gltf_layers.c).
 * - KHR_materials_unlit: emission of the base colour, nothing else.
 * - KHR_materials_pbrSpecularGlossiness: an ior of 0 with the specular colour, a dielectric with the diffuse
 *   colour as b, and r = 1 - glossiness.
 *
 * Textures multiply the factors, point by point (FATHOM_MAP_ in fathom/scene.h); so do the colours of
 * vertices. Occlusion textures are left out without a word: what they show is computed. With MASK or BLEND,
 * the alpha of the base colour texture is a map of the opacity. The thickness of a volume is what its mesh
 * has; that of the factor and the texture do not matter, but for 0.
 *
 * A mesh whose material lets more than half of the light through casts no shadow, because shadow rays are all
 * or nothing. */
#include "read/gltf/gltf_layers.h"
#include "scene/metallic.h"

#include <math.h>
#include <string.h>

typedef enum alpha_mode { ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND } alpha_mode;

typedef struct factors {
    metallic_factors to; /* base and cover once all is read */
    double base[4], cutoff;
    double thickness, attenuation_color[3], attenuation_distance; /* path tracing alone, */
    double clearcoat, clearcoat_roughness;                        /* these, too */
    gltf_layers layers;                                           /* and these */
    alpha_mode alpha;
    fathom_map maps[FATHOM_MAPS];
    float normal_scale, coat_normal_scale;
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

static unsigned flags_of(const fathom_material *m) {
    return m->k_t[0] + m->k_t[1] + m->k_t[2] > 1.5f ? FATHOM_CASTS_NO_SHADOW : 0;
}

/* ---- reading ---- */

/* A map of one parameter, and where `second` is another, one more of the same texture. */
typedef struct use {
    int kind, channel;
    bool color, inverted;
} use;

/* A texture that cannot be read is noted. Its factor is mostly 1 and means little alone, so the least wrong
 * even value stands in: grey, no metal and rough, no emission, no transmission. */
static void without_image(int kind, factors *f) {
    if (kind == FATHOM_MAP_METALLIC) f->to.metallic = 0;
    if (kind == FATHOM_MAP_ROUGHNESS) f->to.roughness = 1;
    if (kind == FATHOM_MAP_TRANSMISSION) f->to.transmission = 0;
    for (int c = 0; c < 3; ++c) {
        if (kind == FATHOM_MAP_COLOR) f->base[c] *= 0.5;
        if (kind == FATHOM_MAP_SPECULAR_COLOR) f->to.specular_color[c] *= 0.04;
        if (kind == FATHOM_MAP_EMISSIVE) f->to.emissive[c] = 0;
    }
}

static fathom_status read_maps(gltf *g, const gltf_value *at, const char *key, const use *uses, int count,
                               factors *f) {
    bool there;
    fathom_map map;
    fathom_status status = gltf_map(g, at, key, uses[0].color, &there, &map);
    for (int k = 0; k < count && status == FATHOM_OK && json_object_get(at->json, key); ++k) {
        fathom_map *to = &f->maps[uses[k].kind];
        if (!there) {
            without_image(uses[k].kind, f);
            continue;
        }
        *to = map;
        to->channel = (uint32_t)uses[k].channel, to->inverted = uses[k].inverted;
    }
    return status;
}

static fathom_status read_map(gltf *g, const gltf_value *at, const char *key, use one, factors *f) {
    return read_maps(g, at, key, &one, 1, f);
}

/* The colour and, where alpha counts, the opacity; of an unlit material, what it sends out. */
static fathom_status read_base_map(gltf *g, const gltf_value *at, const char *key, factors *f) {
    const use uses[2] = {{.kind = f->to.unlit ? FATHOM_MAP_EMISSIVE : FATHOM_MAP_COLOR, .color = true},
                         {.kind = FATHOM_MAP_OPACITY, .channel = 3}};
    return read_maps(g, at, key, uses, f->alpha == ALPHA_OPAQUE ? 1 : 2, f);
}

static fathom_status read_metallic_roughness(gltf *g, const gltf_value *at, factors *f) {
    static const use uses[2] = {{.kind = FATHOM_MAP_METALLIC, .channel = 2},
                                {.kind = FATHOM_MAP_ROUGHNESS, .channel = 1}};
    gltf_value pbr;
    fathom_status status = gltf_object(g, at, "pbrMetallicRoughness", &pbr);
    if (status == FATHOM_OK) status = gltf_numbers(g, &pbr, "baseColorFactor", 4, 0, 1, f->base);
    if (status == FATHOM_OK) status = gltf_number(g, &pbr, "metallicFactor", 0, 1, &f->to.metallic);
    if (status == FATHOM_OK) status = gltf_number(g, &pbr, "roughnessFactor", 0, 1, &f->to.roughness);
    if (status == FATHOM_OK) status = read_base_map(g, &pbr, "baseColorTexture", f);
    return status == FATHOM_OK ? read_maps(g, &pbr, "metallicRoughnessTexture", uses, 2, f) : status;
}

/* The older workflow, instead of metallic and roughness. */
static fathom_status read_specular_glossiness(gltf *g, const gltf_value *pbr, factors *f) {
    static const use uses[2] = {{.kind = FATHOM_MAP_SPECULAR_COLOR, .color = true},
                                {.kind = FATHOM_MAP_ROUGHNESS, .channel = 3, .inverted = true}};
    double glossiness = 1;
    fathom_status status = gltf_numbers(g, pbr, "diffuseFactor", 4, 0, 1, f->base);
    if (status == FATHOM_OK) status = gltf_numbers(g, pbr, "specularFactor", 3, 0, 1, f->to.specular_color);
    if (status == FATHOM_OK) status = gltf_number(g, pbr, "glossinessFactor", 0, 1, &glossiness);
    if (status == FATHOM_OK) status = read_base_map(g, pbr, "diffuseTexture", f);
    f->to.metallic = f->to.ior = 0;
    f->to.roughness = 1 - glossiness;
    return status == FATHOM_OK ? read_maps(g, pbr, "specularGlossinessTexture", uses, 2, f) : status;
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
    if (status == FATHOM_OK)
        status = read_map(g, &specular, "specularTexture", (use){FATHOM_MAP_SPECULAR, 3, false, false}, f);
    if (status == FATHOM_OK)
        status = read_map(g, &specular, "specularColorTexture",
                          (use){.kind = FATHOM_MAP_SPECULAR_COLOR, .color = true}, f);
    return status;
}

/* attenuationDistance is infinite where it is absent. */
static fathom_status read_volume(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value volume;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_volume", &volume);
    if (status == FATHOM_OK) status = gltf_number(g, &volume, "thicknessFactor", 0, 1e30, &f->thickness);
    if (json_object_get(volume.json, "thicknessTexture"))
        gltf_note(g, &volume, "thicknessTexture",
                  "the thickness of a volume is what its mesh has; the texture does not matter");
    if (status == FATHOM_OK)
        status = gltf_numbers(g, &volume, "attenuationColor", 3, 0, 1, f->attenuation_color);
    if (status == FATHOM_OK)
        status = gltf_number(g, &volume, "attenuationDistance", 0, 1e30, &f->attenuation_distance);
    return status;
}

static fathom_status read_normal(gltf *g, const gltf_value *at, const char *key, int kind, float *scale,
                                 factors *f) {
    gltf_value info;
    double number = 1;
    fathom_status status = gltf_object(g, at, key, &info);
    if (status == FATHOM_OK) status = gltf_number(g, &info, "scale", -1e3, 1e3, &number);
    *scale = (float)number;
    return status == FATHOM_OK ? read_map(g, at, key, (use){.kind = kind}, f) : status;
}

static fathom_status read_clearcoat(gltf *g, const gltf_value *extensions, factors *f) {
    gltf_value coat;
    fathom_status status = gltf_object(g, extensions, "KHR_materials_clearcoat", &coat);
    if (status == FATHOM_OK) status = gltf_number(g, &coat, "clearcoatFactor", 0, 1, &f->clearcoat);
    if (status == FATHOM_OK)
        status = gltf_number(g, &coat, "clearcoatRoughnessFactor", 0, 1, &f->clearcoat_roughness);
    if (status == FATHOM_OK)
        status = read_map(g, &coat, "clearcoatTexture", (use){.kind = FATHOM_MAP_CLEARCOAT}, f);
    if (status == FATHOM_OK)
        status = read_map(g, &coat, "clearcoatRoughnessTexture",
                          (use){.kind = FATHOM_MAP_CLEARCOAT_ROUGHNESS, .channel = 1}, f);
    if (status == FATHOM_OK)
        status = read_normal(g, &coat, "clearcoatNormalTexture", FATHOM_MAP_CLEARCOAT_NORMAL,
                             &f->coat_normal_scale, f);
    return status;
}

static fathom_status read_extensions(gltf *g, const gltf_value *at, factors *f) {
    gltf_value extensions, transmission, emissive, glossiness;
    fathom_status status = gltf_object(g, at, "extensions", &extensions);
    if (status == FATHOM_OK) status = read_ior(g, &extensions, f);
    if (status == FATHOM_OK) status = read_specular(g, &extensions, f);
    if (status == FATHOM_OK) status = read_volume(g, &extensions, f);
    if (status == FATHOM_OK) status = read_clearcoat(g, &extensions, f);
    if (status == FATHOM_OK) status = gltf_layers_read(g, &extensions, f->maps, &f->layers);
    if (status == FATHOM_OK)
        status = gltf_object(g, &extensions, "KHR_materials_transmission", &transmission);
    if (status != FATHOM_OK) return status;
    status = gltf_number(g, &transmission, "transmissionFactor", 0, 1, &f->to.transmission);
    if (status == FATHOM_OK)
        status = read_map(g, &transmission, "transmissionTexture", (use){.kind = FATHOM_MAP_TRANSMISSION}, f);
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

/* An unlit material sends out its base colour, and has no emission besides. */
static fathom_status read_factors(gltf *g, const gltf_value *at, factors *f) {
    fathom_status status = read_unlit(g, at, f);
    if (status == FATHOM_OK) status = read_alpha(g, at, f);
    if (status == FATHOM_OK) status = read_extensions(g, at, f);
    if (status == FATHOM_OK) status = gltf_numbers(g, at, "emissiveFactor", 3, 0, 1, f->to.emissive);
    if (status == FATHOM_OK && !f->to.unlit)
        status = read_map(g, at, "emissiveTexture", (use){.kind = FATHOM_MAP_EMISSIVE, .color = true}, f);
    if (status == FATHOM_OK)
        status = read_normal(g, at, "normalTexture", FATHOM_MAP_NORMAL, &f->normal_scale, f);
    return status == FATHOM_OK ? read_sides(g, at) : status;
}

/* The material of path tracing, and its classic equivalent. */
static void make(factors *f, fathom_material *material, fathom_material *classic) {
    memcpy(f->to.base, f->base, sizeof f->to.base);
    f->to.cover = f->alpha == ALPHA_OPAQUE ? 1 : f->base[3];
    metallic_to_material(&f->to, material);
    if (f->alpha == ALPHA_MASK) material->opacity_cutoff = (float)fmax(f->cutoff, 1e-6);
    f->to.cover = (double)material_opacity(material);
    metallic_to_classic(&f->to, classic);
    memcpy(material->maps, f->maps, sizeof material->maps);
    material->normal_scale = f->normal_scale;
    material->clearcoat_normal_scale = f->coat_normal_scale;
    material->thickness = (float)f->thickness;
    if (!f->to.unlit) gltf_layers_set(&f->layers, material);
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
        for (int k = 0; k < FATHOM_MAPS; ++k) f.maps[k].texture = FATHOM_NONE;
        f.layers = gltf_layers_default();
        fathom_material material, classic;
        fathom_status status = given ? gltf_item(g, &g->materials, index, &at) : FATHOM_OK;
        if (status == FATHOM_OK) status = gltf_text(g, &at, "name", &name);
        if (status == FATHOM_OK) status = read_factors(g, &at, &f);
        if (status != FATHOM_OK) return status;
        make(&f, &material, &classic);
        kept->flags = material_has_maps(&material) ? 0 : flags_of(&classic);
        kept->blends = f.alpha != ALPHA_OPAQUE;
        status = scene_add_material_as(g->scene, name, &material, &classic, &kept->id);
        if (status != FATHOM_OK) return gltf_within(g, &at, NULL, status);
    }
    *out = *kept;
    return FATHOM_OK;
}
