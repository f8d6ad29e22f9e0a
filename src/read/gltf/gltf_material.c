/* glTF materials, read as metallic-roughness; scene/metallic.c has the equivalent in the classic model.
 *
 * - alphaMode MASK: if base alpha is below the cutoff, the surface is absent (k_t = 1, ior 1:
 *   scene/mesh/absent.h).
 * - alphaMode BLEND: base alpha is coverage.
 * - KHR_materials_clearcoat and KHR_materials_volume: only with path tracing. Without a volume, a surface
 *   that transmits light is a thin wall in path tracing, and solid in the classic model.
 * - KHR_materials_sheen, _anisotropy, _iridescence, _dispersion and _diffuse_transmission: only with path
 *   tracing.
 * - KHR_materials_unlit: only emission, of the base colour.
 * - KHR_materials_pbrSpecularGlossiness: a dielectric with ior 0, the specular colour, the diffuse colour as
 *   base colour, and roughness = 1 - glossiness.
 *
 * Textures multiply the factors at each point (FATHOM_MAP_ in fathom/scene.h); so do vertex colours.
 * Occlusion textures are ignored without a note, because occlusion is computed. With MASK or BLEND, the alpha
 * of the base colour texture is a map of the opacity. The mesh determines the thickness of a volume; the
 * thickness factor only matters if it is 0, and its texture is not used.
 *
 * A mesh whose material is clear (material_is_clear()) casts no shadow, because shadow rays do not refract.
 */
#include "read/gltf/gltf_material.h"
#include "read/gltf/gltf_keys.h"

#include <float.h>
#include <math.h>
#include <string.h>

typedef enum alpha_mode { ALPHA_OPAQUE, ALPHA_MASK, ALPHA_BLEND } alpha_mode;

/* A material while it is read. Alpha and opacity are combined at the end. */
typedef struct draft {
    fathom_material m;
    alpha_mode alpha;
    bool unlit;
} draft;

static void set_map(const fathom_map *map, int kind, int channel, bool inverted, draft *d) {
    if (!map) {
        if (kind != FATHOM_MAP_COLOR || !d->unlit) read_without_image(kind, &d->m);
        return;
    }
    d->m.maps[kind] = *map;
    d->m.maps[kind].channel = channel < 0 ? 0 : (uint32_t)channel;
    d->m.maps[kind].inverted = inverted;
}

/* True for an index of -1, or null. */
static bool names_no_texture(const json_t *info) {
    const json_t *index = json_object_get(info, "index");
    return json_is_null(index) || json_integer_value(index) == -1;
}

/* Some images have two parameters. */
static void read_image(gltf *g, const gltf_value *at, const gltf_key *key, draft *d) {
    fathom_map map;
    const json_t *info = json_object_get(at->json, key->name);
    if (!info) return;
    const fathom_map *found = gltf_map(g, at, key->name, material_map_is_color(key->map), &map) ? &map : NULL;
    if (names_no_texture(info)) return;
    set_map(found, key->map, key->channel, false, d);
    if (key->map == FATHOM_MAP_COLOR && d->alpha != ALPHA_OPAQUE)
        set_map(found, FATHOM_MAP_OPACITY, 3, false, d);
    if (key->map == FATHOM_MAP_METALLIC) set_map(found, FATHOM_MAP_ROUGHNESS, 1, false, d);
    if (key->of == GLTF_GLOSSINESS && key->map == FATHOM_MAP_SPECULAR_COLOR)
        set_map(found, FATHOM_MAP_ROUGHNESS, 3, true, d);
}

static void read_scale(gltf *g, const gltf_value *at, const char *key, float *scale) {
    gltf_value info;
    double number = 1;
    gltf_object(g, at, key, &info);
    gltf_number(g, &info, "scale", -1e3, 1e3, &number);
    *scale = (float)number;
}

static void read_number(gltf *g, const gltf_value *at, const gltf_key *key, draft *d) {
    float *to = (float *)(void *)((char *)&d->m + key->offset);
    double numbers[3];
    if (!json_object_get(at->json, key->name)) return;
    if (key->count == 1)
        gltf_number(g, at, key->name, key->low, key->high, numbers);
    else
        gltf_numbers(g, at, key->name, key->count, key->low, key->high, numbers);
    for (unsigned i = 0; i < key->count && gltf_fine(g); ++i) to[i] = (float)numbers[i];
}

/* Notes an image whose factor is 0, "xTexture" of "xFactor" or of "xStrength". Factors of layers are 0 by
 * default. */
static void note_idle(gltf *g, const gltf_value *at, const gltf_key *image, const draft *d) {
    const size_t stem = strlen(image->name) - strlen("Texture");
    for (const gltf_key *key = gltf_keys; key < gltf_keys + gltf_key_count; ++key) {
        const float *factor = (const float *)(const void *)((const char *)&d->m + key->offset);
        const char *rest = key->name + stem;
        float sum = 0;
        if (key->of != image->of || !key->count || strncmp(key->name, image->name, stem) != 0 ||
            (strcmp(rest, "Factor") != 0 && strcmp(rest, "Strength") != 0))
            continue;
        for (unsigned i = 0; i < key->count; ++i) sum += factor[i];
        if (sum > 0) continue;
        gltf_note(g, at, image->name,
                  "%s has no effect, because its factor %s is 0%s; expected a factor above 0", image->name,
                  key->name, json_object_get(at->json, key->name) ? "" : ", the default");
    }
}

/* Reads colour and opacity, which are one value in glTF. */
static void read_base(gltf *g, const gltf_value *at, const char *key, draft *d) {
    double base[4] = {1, 1, 1, 1};
    gltf_numbers(g, at, key, 4, 0, 1, base);
    for (int c = 0; c < 3; ++c) d->m.base_color[c] = (float)base[c];
    if (d->alpha != ALPHA_OPAQUE) d->m.opacity = (float)base[3];
}

static void read_keys(gltf *g, const gltf_value *at, gltf_holder of, draft *d) {
    for (size_t i = 0; i < gltf_key_count && gltf_fine(g); ++i) {
        const gltf_key *key = &gltf_keys[i];
        if (key->of == of && key->count) read_number(g, at, key, d);
        if (key->of == of && !key->count) read_image(g, at, key, d);
    }
    for (size_t i = 0; i < gltf_key_count && gltf_fine(g); ++i) {
        const gltf_key *key = &gltf_keys[i];
        if (key->of == of && !key->count && d->m.maps[key->map].texture != FATHOM_NONE)
            note_idle(g, at, key, d);
    }
}

/* ---- other parts ---- */

/* A length in metres, at most the largest that a material may have. */
static float scaled(const gltf *g, float length) { return (float)fmin((double)length * gltf_unit(g), 1e30); }

static void read_alpha(gltf *g, const gltf_value *at, draft *d) {
    const char *mode = "OPAQUE";
    double cutoff = 0.5;
    gltf_text(g, at, "alphaMode", &mode);
    gltf_number(g, at, "alphaCutoff", 0, 1000, &cutoff);
    if (strcmp(mode, "MASK") == 0)
        d->alpha = cutoff > 0 ? ALPHA_MASK : ALPHA_OPAQUE; /* no alpha is below 0 */
    else if (strcmp(mode, "BLEND") == 0)
        d->alpha = ALPHA_BLEND;
    else if (strcmp(mode, "OPAQUE") != 0)
        gltf_note(g, at, "alphaMode", "\"%.40s\" is none of OPAQUE, MASK and BLEND; OPAQUE is taken", mode);
    if (d->alpha == ALPHA_MASK) d->m.opacity_cutoff = (float)fmax(cutoff, FLT_MIN);
}

/* Reads the older workflow, which replaces metallic-roughness. */
static void read_glossiness(gltf *g, const gltf_value *at, draft *d) {
    double glossiness = 1;
    gltf_number(g, at, "glossinessFactor", 0, 1, &glossiness);
    d->m.metallic = d->m.ior = 0;
    d->m.roughness = (float)(1 - glossiness);
    read_base(g, at, "diffuseFactor", d);
    read_keys(g, at, GLTF_GLOSSINESS, d);
}

static void read_extensions(gltf *g, const gltf_value *at, const gltf_value *extensions, draft *d) {
    gltf_value part;
    for (int of = GLTF_IOR; of < GLTF_GLOSSINESS && gltf_fine(g); ++of) {
        gltf_object(g, extensions, gltf_holder_names[of], &part);
        if (!part.json) continue;
        read_keys(g, &part, (gltf_holder)of, d);
        if (of == GLTF_IOR && d->m.ior > 0 && d->m.ior < 1) {
            gltf_note(g, &part, "ior", "ior: expected 0 or a number >= 1; 1 is taken");
            d->m.ior = 1;
        }
        if (of == GLTF_CLEARCOAT)
            read_scale(g, &part, "clearcoatNormalTexture", &d->m.clearcoat_normal_scale);
        if (of == GLTF_VOLUME) {
            d->m.thickness = scaled(g, d->m.thickness);
            d->m.attenuation_distance = scaled(g, d->m.attenuation_distance);
        }
        if (of == GLTF_VOLUME && json_object_get(part.json, "thicknessTexture"))
            gltf_note(g, &part, "thicknessTexture",
                      "the thickness of a volume is what its mesh has; the texture does not matter");
    }
    gltf_object(g, extensions, gltf_holder_names[GLTF_TRANSMISSION], &part);
    if (d->m.transmission > 0 && !(d->m.thickness > 0) && gltf_blender(g))
        gltf_note(g, &part, "transmissionFactor",
                  "belongs to a thin wall without a thickness, while glass refracts in Blender: give the "
                  "material a node group \"glTF Material Output\" with a Thickness above 0");
    gltf_object(g, extensions, gltf_holder_names[GLTF_GLOSSINESS], &part);
    if (part.json) {
        read_glossiness(g, &part, d);
        return;
    }
    gltf_object(g, at, gltf_holder_names[GLTF_PBR], &part);
    read_base(g, &part, "baseColorFactor", d);
    read_keys(g, &part, GLTF_PBR, d);
}

/* The surface emits its base colour, and reflects nothing. */
static void make_unlit(draft *d) {
    const fathom_material given = d->m;
    fathom_material *m = &d->m;
    fathom_material_default(m);
    memcpy(m->emissive, given.base_color, sizeof m->emissive);
    memset(m->base_color, 0, sizeof m->base_color);
    m->specular_factor = 0;
    m->double_sided = given.double_sided, m->opacity = given.opacity,
    m->opacity_cutoff = given.opacity_cutoff;
    m->maps[FATHOM_MAP_EMISSIVE] = given.maps[FATHOM_MAP_COLOR];
    m->maps[FATHOM_MAP_OPACITY] = given.maps[FATHOM_MAP_OPACITY];
}

/* glTF's defaults are those of fathom_material, except metallic, roughness and double_sided. */
static void read_material(gltf *g, const gltf_value *at, draft *d) {
    gltf_value extensions, unlit;
    fathom_material_default(&d->m);
    d->m.metallic = d->m.roughness = 1;
    gltf_object(g, at, "extensions", &extensions);
    gltf_object(g, &extensions, gltf_holder_names[GLTF_UNLIT], &unlit);
    d->unlit = unlit.json != NULL;
    read_alpha(g, at, d);
    read_extensions(g, at, &extensions, d);
    read_keys(g, at, GLTF_CORE, d);
    read_scale(g, at, "normalTexture", &d->m.normal_scale);
    d->m.double_sided = false;
    gltf_flag(g, at, "doubleSided", &d->m.double_sided);
    if (d->unlit) make_unlit(d);
    d->m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
}

bool gltf_material_make(gltf *g, uint32_t index, gltf_material *out) {
    const bool given = index != GLTF_ABSENT;
    if (!gltf_fine(g)) return false;
    gltf_material *kept = &g->material_table[given ? index : gltf_count(&g->materials)];
    if (kept->id == FATHOM_NONE) {
        gltf_value at = {.json = NULL};
        const char *name = NULL;
        draft d = {.alpha = ALPHA_OPAQUE};
        if (given) gltf_item(g, &g->materials, index, &at);
        gltf_text(g, &at, "name", &name);
        read_material(g, &at, &d);
        if (gltf_fine(g))
            gltf_within(g, &at, NULL, fathom_scene_add_material(g->scene, name, &d.m, &kept->id));
        if (!gltf_fine(g)) return false;
        const scene_named_material *made = &g->scene->materials.items[kept->id];
        const bool clear = material_is_clear(made, g->scene->settings.integrator);
        kept->flags = clear ? FATHOM_CASTS_NO_SHADOW : 0;
        kept->blends = d.alpha != ALPHA_OPAQUE;
    }
    *out = *kept;
    return true;
}
