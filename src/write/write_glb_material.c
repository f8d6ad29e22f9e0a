/* Materials as glTF has them: a table of keys, of which those are written that differ from glTF's defaults.
 * Numbers are written so that they read back as the same float. */
#include "write/write_glb.h"

#include <string.h>

/* ---- the keys ---- */

typedef enum holder {
    PBR,
    CORE,
    IOR,
    SPECULAR,
    TRANSMISSION,
    VOLUME,
    CLEARCOAT,
    SHEEN,
    ANISOTROPY,
    IRIDESCENCE,
    DISPERSION,
    DIFFUSE_TRANSMISSION,
    STRENGTH,
    GLOSSINESS,
    UNLIT,
    HOLDERS
} holder;

static const char *const holder_names[HOLDERS] = {"pbrMetallicRoughness",
                                                  NULL,
                                                  "KHR_materials_ior",
                                                  "KHR_materials_specular",
                                                  "KHR_materials_transmission",
                                                  "KHR_materials_volume",
                                                  "KHR_materials_clearcoat",
                                                  "KHR_materials_sheen",
                                                  "KHR_materials_anisotropy",
                                                  "KHR_materials_iridescence",
                                                  "KHR_materials_dispersion",
                                                  "KHR_materials_diffuse_transmission",
                                                  "KHR_materials_emissive_strength",
                                                  "KHR_materials_pbrSpecularGlossiness",
                                                  "KHR_materials_unlit"};

/* A number or a colour; or, without a count, an image. */
typedef struct glb_key {
    holder of;
    const char *name;
    size_t offset; /* in fathom_material */
    unsigned count;
    double fallback;  /* what glTF takes for an absent number */
    int map, channel; /* channel: -1 for a colour */
} glb_key;

#define NUMBER(holder, name, member, fallback)                                                               \
    { holder, name, offsetof(fathom_material, member), 1, fallback, 0, 0 }
#define COLOR(holder, name, member, fallback)                                                                \
    { holder, name, offsetof(fathom_material, member), 3, fallback, 0, 0 }
#define IMAGE(holder, name, map, channel)                                                                    \
    { holder, name, 0, 0, 0, FATHOM_MAP_##map, channel }
static const glb_key keys[] = {
    NUMBER(PBR, "metallicFactor", metallic, 1),
    NUMBER(PBR, "roughnessFactor", roughness, 1),
    IMAGE(PBR, "baseColorTexture", COLOR, -1),
    IMAGE(PBR, "metallicRoughnessTexture", METALLIC, 2),
    COLOR(CORE, "emissiveFactor", emissive, 0),
    IMAGE(CORE, "emissiveTexture", EMISSIVE, -1),
    IMAGE(CORE, "normalTexture", NORMAL, -1),
    NUMBER(IOR, "ior", ior, 1.5),
    NUMBER(SPECULAR, "specularFactor", specular_factor, 1),
    COLOR(SPECULAR, "specularColorFactor", specular_color, 1),
    IMAGE(SPECULAR, "specularTexture", SPECULAR, 3),
    IMAGE(SPECULAR, "specularColorTexture", SPECULAR_COLOR, -1),
    NUMBER(TRANSMISSION, "transmissionFactor", transmission, 0),
    IMAGE(TRANSMISSION, "transmissionTexture", TRANSMISSION, 0),
    NUMBER(VOLUME, "thicknessFactor", thickness, 0),
    COLOR(VOLUME, "attenuationColor", attenuation_color, 1),
    NUMBER(VOLUME, "attenuationDistance", attenuation_distance, 0),
    NUMBER(CLEARCOAT, "clearcoatFactor", clearcoat, 0),
    NUMBER(CLEARCOAT, "clearcoatRoughnessFactor", clearcoat_roughness, 0),
    IMAGE(CLEARCOAT, "clearcoatTexture", CLEARCOAT, 0),
    IMAGE(CLEARCOAT, "clearcoatRoughnessTexture", CLEARCOAT_ROUGHNESS, 1),
    IMAGE(CLEARCOAT, "clearcoatNormalTexture", CLEARCOAT_NORMAL, -1),
    COLOR(SHEEN, "sheenColorFactor", sheen_color, 0),
    NUMBER(SHEEN, "sheenRoughnessFactor", sheen_roughness, 0),
    IMAGE(SHEEN, "sheenColorTexture", SHEEN_COLOR, -1),
    IMAGE(SHEEN, "sheenRoughnessTexture", SHEEN_ROUGHNESS, 3),
    NUMBER(ANISOTROPY, "anisotropyStrength", anisotropy, 0),
    NUMBER(ANISOTROPY, "anisotropyRotation", anisotropy_rotation, 0),
    IMAGE(ANISOTROPY, "anisotropyTexture", ANISOTROPY, 0),
    NUMBER(IRIDESCENCE, "iridescenceFactor", iridescence, 0),
    NUMBER(IRIDESCENCE, "iridescenceIor", iridescence_ior, 1.3),
    NUMBER(IRIDESCENCE, "iridescenceThicknessMinimum", iridescence_thickness_min, 100),
    NUMBER(IRIDESCENCE, "iridescenceThicknessMaximum", iridescence_thickness_max, 400),
    IMAGE(IRIDESCENCE, "iridescenceTexture", IRIDESCENCE, 0),
    IMAGE(IRIDESCENCE, "iridescenceThicknessTexture", IRIDESCENCE_THICKNESS, 1),
    NUMBER(DISPERSION, "dispersion", dispersion, 0),
    NUMBER(DIFFUSE_TRANSMISSION, "diffuseTransmissionFactor", diffuse_transmission, 0),
    COLOR(DIFFUSE_TRANSMISSION, "diffuseTransmissionColorFactor", diffuse_transmission_color, 1),
    IMAGE(DIFFUSE_TRANSMISSION, "diffuseTransmissionTexture", DIFFUSE_TRANSMISSION, 3),
    IMAGE(DIFFUSE_TRANSMISSION, "diffuseTransmissionColorTexture", DIFFUSE_TRANSMISSION_COLOR, -1),
    NUMBER(STRENGTH, "emissiveStrength", emissive_strength, 1),
    COLOR(GLOSSINESS, "specularFactor", specular_color, 1),
    IMAGE(GLOSSINESS, "diffuseTexture", COLOR, -1),
    IMAGE(GLOSSINESS, "specularGlossinessTexture", SPECULAR_COLOR, -1),
};
enum { KEYS = sizeof keys / sizeof *keys };

/* ---- a material in glTF's terms ---- */

/* unlit: it sends out its base colour and nothing else. glossy: an older workflow, whose roughness is one
 * minus the alpha of an image. */
typedef struct shape {
    fathom_material m;
    bool unlit, glossy, blends;
} shape;

static bool is_black(const float c[3]) { return c[0] == 0 && c[1] == 0 && c[2] == 0; }

static bool has_map(const fathom_material *m, int kind) { return m->maps[kind].texture != FATHOM_NONE; }

/* One image of two parameters. */
static bool same_place(const fathom_map *a, const fathom_map *b) {
    return a->texture == b->texture && a->uv_set == b->uv_set &&
           memcmp(a->transform, b->transform, sizeof a->transform) == 0;
}

static void drop_map(shape *s, int kind, size_t *lost) {
    *lost += has_map(&s->m, kind);
    s->m.maps[kind].texture = FATHOM_NONE;
}

static bool is_unlit(const fathom_material *m) {
    return is_black(m->base_color) && m->metallic == 0 && m->specular_factor == 0 && m->transmission == 0 &&
           m->emissive_strength == 1 && !is_black(m->emissive) &&
           !(m->emissive[0] > 1 || m->emissive[1] > 1 || m->emissive[2] > 1);
}

static void make_unlit(shape *s) {
    fathom_material *m = &s->m;
    memcpy(m->base_color, m->emissive, sizeof m->emissive);
    m->maps[FATHOM_MAP_COLOR] = m->maps[FATHOM_MAP_EMISSIVE];
    m->maps[FATHOM_MAP_EMISSIVE].texture = FATHOM_NONE;
    m->specular_factor = 1;
    memset(m->emissive, 0, sizeof m->emissive);
}

static bool is_glossy(const fathom_material *m) {
    const fathom_map *rough = &m->maps[FATHOM_MAP_ROUGHNESS];
    return has_map(m, FATHOM_MAP_ROUGHNESS) && rough->inverted && rough->channel == 3 && m->metallic == 0 &&
           m->ior == 0 && same_place(rough, &m->maps[FATHOM_MAP_SPECULAR_COLOR]);
}

/* glTF's factors of emission end at 1; a power of two moves the rest into the strength without rounding. */
static void limit_emission(fathom_material *m) {
    const float most = fmaxf(m->emissive[0], fmaxf(m->emissive[1], m->emissive[2]));
    int exponent;
    if (!(most > 1)) return;
    frexpf(most, &exponent);
    m->emissive_strength = ldexpf(m->emissive_strength, exponent);
    for (int c = 0; c < 3; ++c) m->emissive[c] = ldexpf(m->emissive[c], -exponent);
}

/* glTF fixes the channel of each image, and has no image of metal or roughness alone, nor of an opacity that
 * is not the colour's alpha. *lost: images without a place. */
static void drop_strangers(shape *s, size_t *lost) {
    fathom_map *maps = s->m.maps, *metal = &maps[FATHOM_MAP_METALLIC], *rough = &maps[FATHOM_MAP_ROUGHNESS],
               *alpha = &maps[FATHOM_MAP_OPACITY];
    if (has_map(&s->m, FATHOM_MAP_OPACITY) &&
        (alpha->channel != 3 || alpha->inverted || !same_place(alpha, &maps[FATHOM_MAP_COLOR])))
        drop_map(s, FATHOM_MAP_OPACITY, lost);
    const bool both = same_place(metal, rough) && metal->channel == 2 && rough->channel == 1 &&
                      !metal->inverted && !rough->inverted;
    if (!both) drop_map(s, FATHOM_MAP_METALLIC, lost);
    if (!both && !s->glossy) drop_map(s, FATHOM_MAP_ROUGHNESS, lost);
    for (size_t i = 0; i < KEYS; ++i) {
        const glb_key *key = &keys[i];
        if (key->count || key->channel < 0 || key->map == FATHOM_MAP_METALLIC) continue;
        if (maps[key->map].channel != (uint32_t)key->channel || maps[key->map].inverted)
            drop_map(s, key->map, lost);
    }
}

/* A material does not tell that alpha counts where only the vertices' colours have one. */
static bool has_alpha_vertices(const fathom_scene *scene, fathom_id material) {
    for (size_t i = 0; i < scene->meshes.count; ++i) {
        const fathom_mesh *mesh = &scene->meshes.items[i];
        if (mesh->material == material && mesh->colors && mesh->color_channels == 4) return true;
    }
    return false;
}

/* glTF has that, with the light that it sends out. */
static bool is_lambert(const fathom_material *m) {
    return m->specular == FATHOM_SPECULAR_NONE && is_black(m->k_r) && is_black(m->k_t) && m->k_a[0] < 0 &&
           !m->lit_from_behind;
}

static shape shape_of(const glb *g, fathom_id id) {
    const fathom_material *given = &g->scene->materials.items[id].value;
    const bool classic = given->model == FATHOM_MODEL_CLASSIC;
    shape s = {.m = classic ? glb_classic(given) : *given};
    size_t lost = 0;
    s.unlit = is_unlit(&s.m);
    if (s.unlit) make_unlit(&s);
    s.glossy = is_glossy(&s.m);
    limit_emission(&s.m);
    drop_strangers(&s, &lost);
    s.blends = s.m.opacity < 1 || s.m.opacity_cutoff > 0 || has_map(&s.m, FATHOM_MAP_OPACITY) ||
               has_alpha_vertices(g->scene, id);
    if (lost)
        notes_add(g->notes, lost, "",
                  "an image that glTF has no place for, by its parameter or its channel, "
                  "is left out");
    if (s.blends && has_map(&s.m, FATHOM_MAP_COLOR) && !has_map(&s.m, FATHOM_MAP_OPACITY))
        notes_add(g->notes, 1, "",
                  "the alpha of a material's colour image, if it has one, counts as opacity");
    if (classic && !is_lambert(given))
        notes_add(g->notes, 1, "",
                  "a material of the model classic becomes its nearest metallicRoughness "
                  "one");
    if (s.m.priority || !s.m.multiscatter)
        notes_add(g->notes, 1, "", "priority and multiscatter of a material have no place in glTF");
    if (s.m.ior > 0 && s.m.ior < 1) {
        notes_add(g->notes, 1, "", "an index of refraction below 1 has no place in glTF, and becomes 1");
        s.m.ior = 1;
    }
    return s;
}

/* ---- text ---- */

static float number_of(const fathom_material *m, const glb_key *key, unsigned i) {
    return ((const float *)(const void *)((const char *)m + key->offset))[i];
}

static bool is_given(const shape *s, const glb_key *key) {
    const bool tint = key->of == SPECULAR && (key->count == 3 || key->map == FATHOM_MAP_SPECULAR_COLOR);
    const bool replaced = s->glossy ? key->of == PBR || key->of == IOR || tint : key->of == GLOSSINESS;
    if (replaced) return false;
    if (!key->count) return has_map(&s->m, key->map);
    for (unsigned i = 0; i < key->count; ++i) {
        if ((double)number_of(&s->m, key, i) != (double)(float)key->fallback) return true;
    }
    return false;
}

static void put_floats(file_writer *t, const char *name, const float *values, unsigned count) {
    file_writer_print(t, "\"%s\":%s", name, count > 1 ? "[" : "");
    for (unsigned i = 0; i < count; ++i) file_writer_print(t, "%s%.9g", i ? "," : "", (double)values[i]);
    file_writer_print(t, count > 1 ? "]" : "");
}

/* The inverse of reading: columns are the scaled axes of a rotation. */
static void put_transform(file_writer *t, const float m[6]) {
    const write_turn turn = write_turn_of(m);
    if (turn.plain) return;
    file_writer_print(t,
                      ",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[%.9g,%.9g],\"rotation\":%.17g,"
                      "\"scale\":[%.17g,%.17g]}}",
                      (double)m[2], (double)m[5], turn.radians, turn.scale[0], turn.scale[1]);
}

static void put_map(file_writer *t, const shape *s, const glb_key *key) {
    const fathom_map *map = &s->m.maps[key->map];
    file_writer_print(t, "\"%s\":{\"index\":%u,\"texCoord\":%u", key->name, map->texture, map->uv_set);
    if (key->map == FATHOM_MAP_NORMAL) file_writer_print(t, ",\"scale\":%.9g", (double)s->m.normal_scale);
    if (key->map == FATHOM_MAP_CLEARCOAT_NORMAL)
        file_writer_print(t, ",\"scale\":%.9g", (double)s->m.clearcoat_normal_scale);
    put_transform(t, map->transform);
    file_writer_print(t, "}");
}

/* The colour and the opacity, which glTF has as one. */
static void put_base(file_writer *t, const shape *s) {
    const float *c = s->m.base_color, rgba[4] = {c[0], c[1], c[2], s->m.opacity};
    put_floats(t, s->glossy ? "diffuseFactor" : "baseColorFactor", rgba, 4);
    if (s->glossy) file_writer_print(t, ",\"glossinessFactor\":%.17g", 1 - (double)s->m.roughness);
}

static void put_keys(file_writer *t, const shape *s, holder of, const char *comma) {
    for (size_t i = 0; i < KEYS; ++i) {
        if (keys[i].of != of || !is_given(s, &keys[i])) continue;
        float values[3];
        for (unsigned k = 0; k < keys[i].count; ++k) values[k] = number_of(&s->m, &keys[i], k);
        file_writer_print(t, "%s", comma);
        if (keys[i].count)
            put_floats(t, keys[i].name, values, keys[i].count);
        else
            put_map(t, s, &keys[i]);
        comma = ",";
    }
}

/* A bit for each holder. */
static unsigned holders_of(const shape *s) {
    unsigned used = (s->unlit ? 1u << UNLIT : 0) | 1u << (s->glossy ? GLOSSINESS : PBR);
    for (size_t i = 0; i < KEYS; ++i) {
        if (is_given(s, &keys[i])) used |= 1u << keys[i].of;
    }
    return used;
}

static void put_material(file_writer *t, const char *name, const shape *s) {
    const unsigned used = holders_of(s);
    const char *open = ",\"extensions\":{";
    file_writer_print(t, "{\"doubleSided\":true");
    if (name) {
        file_writer_print(t, ",\"name\":");
        write_quoted(t, name);
    }
    if (!s->glossy) {
        file_writer_print(t, ",\"%s\":{", holder_names[PBR]);
        put_base(t, s);
        put_keys(t, s, PBR, ",");
        file_writer_print(t, "}");
    }
    put_keys(t, s, CORE, ",");
    if (s->m.opacity_cutoff > 0)
        file_writer_print(t, ",\"alphaMode\":\"MASK\",\"alphaCutoff\":%.9g", (double)s->m.opacity_cutoff);
    else if (s->blends)
        file_writer_print(t, ",\"alphaMode\":\"BLEND\"");
    for (int h = CORE + 1; h < HOLDERS; ++h) {
        if (!(used >> h & 1)) continue;
        file_writer_print(t, "%s\"%s\":{", open, holder_names[h]);
        if (h == GLOSSINESS) put_base(t, s);
        put_keys(t, s, (holder)h, h == GLOSSINESS ? "," : "");
        file_writer_print(t, "}");
        open = ",";
    }
    file_writer_print(t, *open == ',' && !open[1] ? "}}" : "}");
}

static bool has_transforms(const shape *s) {
    for (int k = 0; k < FATHOM_MAPS; ++k) {
        if (has_map(&s->m, k) && !write_turn_of(s->m.maps[k].transform).plain) return true;
    }
    return false;
}

void glb_put_materials(glb *g, file_writer *t) {
    unsigned used = 0;
    bool transforms = false, webp = false, avif = false;
    file_writer_print(t, ",\n\"materials\":[");
    for (uint32_t i = 0; i < g->scene->materials.count; ++i) {
        const shape s = shape_of(g, i);
        used |= holders_of(&s);
        transforms |= has_transforms(&s);
        file_writer_print(t, i ? ",\n" : "\n");
        put_material(t, g->scene->materials.items[i].name, &s);
    }
    for (uint32_t i = 0; i < g->images.count; ++i) {
        const char *type = write_image_type(&g->images.items[i]);
        webp |= type && strcmp(type, "image/webp") == 0;
        avif |= type && strcmp(type, "image/avif") == 0;
    }
    const struct {
        bool used;
        const char *name;
    } others[] = {{transforms, "KHR_texture_transform"},
                  {webp, "EXT_texture_webp"},
                  {avif, "EXT_texture_avif"},
                  {glb_has_lights(g), "KHR_lights_punctual"}};
    const char *comma = "";
    file_writer_print(t, "],\n\"extensionsUsed\":[");
    for (int h = CORE + 1; h < HOLDERS; ++h) {
        if (used >> h & 1) file_writer_print(t, "%s\"%s\"", comma, holder_names[h]), comma = ",";
    }
    for (size_t i = 0; i < sizeof others / sizeof *others; ++i) {
        if (others[i].used) file_writer_print(t, "%s\"%s\"", comma, others[i].name), comma = ",";
    }
    file_writer_print(t, "]");
}
