/* Materials as glTF: by the table of keys, writes those that differ from glTF's defaults. Numbers are written
 * so that they read back as the same float. */
#include "write/write_glb.h"

#include "read/gltf/gltf_keys.h"

#include <string.h>

/* ---- a material in glTF's terms ---- */

/* unlit: only emits its base colour. glossy: an older workflow; its roughness is one minus the alpha of an
 * image. */
typedef struct shape {
    fathom_material m;
    bool unlit, glossy, blends;
} shape;

static bool has_map(const fathom_material *m, int kind) { return m->maps[kind].texture != FATHOM_NONE; }

/* True if two maps can share one image. */
static bool same_place(const fathom_map *a, const fathom_map *b) {
    return a->texture == b->texture && a->uv_set == b->uv_set &&
           memcmp(a->transform, b->transform, sizeof a->transform) == 0;
}

/* The same for alpha, which no color space changes: scene JSON has it as a linear image. */
static bool same_alpha(const fathom_scene *scene, const fathom_map *alpha, const fathom_map *color) {
    if (color->texture == FATHOM_NONE) return false;
    const fathom_texture *a = &scene->textures.items[alpha->texture],
                         *b = &scene->textures.items[color->texture];
    const bool bytes = a->bytes && b->bytes && a->byte_count == b->byte_count &&
                       memcmp(a->bytes, b->bytes, a->byte_count) == 0;
    fathom_map moved = *alpha;
    moved.texture = color->texture;
    return (bytes || (a->file && b->file && strcmp(a->file, b->file) == 0)) && a->wrap_u == b->wrap_u &&
           a->wrap_v == b->wrap_v && a->filter == b->filter && same_place(&moved, color);
}

static void drop_map(shape *s, int kind, size_t *lost) {
    *lost += has_map(&s->m, kind);
    s->m.maps[kind].texture = FATHOM_NONE;
}

static bool is_unlit(const fathom_material *m) {
    return material_only_emits(m) && m->emissive_strength == 1 && !write_is_black(m->emissive) &&
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

static bool is_glossy(const fathom_scene *scene, const fathom_material *m) {
    const fathom_map *rough = &m->maps[FATHOM_MAP_ROUGHNESS];
    return has_map(m, FATHOM_MAP_ROUGHNESS) && rough->inverted && rough->channel == 3 && m->metallic == 0 &&
           m->ior == 0 && same_alpha(scene, rough, &m->maps[FATHOM_MAP_SPECULAR_COLOR]);
}

/* glTF limits the emissive factor to 1. A power of two moves the excess into the strength without rounding
 * error, up to the largest strength that reads back. */
static void limit_emission(fathom_material *m, note_list *notes) {
    const float most = fmaxf(m->emissive[0], fmaxf(m->emissive[1], m->emissive[2]));
    int exponent;
    if (!(most > 1)) return;
    frexpf(most, &exponent);
    m->emissive_strength = ldexpf(m->emissive_strength, exponent);
    notes_add(notes, m->emissive_strength > 1e30f, "", "an emission above 1e30 becomes 1e30");
    m->emissive_strength = fminf(m->emissive_strength, 1e30f);
    for (int c = 0; c < 3; ++c) m->emissive[c] = ldexpf(m->emissive[c], -exponent);
}

/* Drops maps that glTF cannot hold: glTF fixes the channel of each image, has no heights and no separate
 * images for metalness and roughness, and needs opacity in the alpha of the colour. *lost: counts the dropped
 * maps. */
static void drop_strangers(const fathom_scene *scene, shape *s, size_t *lost) {
    fathom_map *maps = s->m.maps, *metal = &maps[FATHOM_MAP_METALLIC], *rough = &maps[FATHOM_MAP_ROUGHNESS],
               *alpha = &maps[FATHOM_MAP_OPACITY];
    if (has_map(&s->m, FATHOM_MAP_OPACITY) &&
        (alpha->channel != 3 || alpha->inverted || !same_alpha(scene, alpha, &maps[FATHOM_MAP_COLOR])))
        drop_map(s, FATHOM_MAP_OPACITY, lost);
    drop_map(s, FATHOM_MAP_BUMP, lost);
    const bool both = same_place(metal, rough) && metal->channel == 2 && rough->channel == 1 &&
                      !metal->inverted && !rough->inverted;
    if (!both) drop_map(s, FATHOM_MAP_METALLIC, lost);
    if (!both && !s->glossy) drop_map(s, FATHOM_MAP_ROUGHNESS, lost);
    for (size_t i = 0; i < gltf_key_count; ++i) {
        const gltf_key *key = &gltf_keys[i];
        if (key->count || key->channel < 0 || key->map == FATHOM_MAP_METALLIC) continue;
        if (maps[key->map].channel != (uint32_t)key->channel || maps[key->map].inverted)
            drop_map(s, key->map, lost);
    }
}

/* True if some placement of the mesh has the material. */
static bool wears(const glb_group *group, const fathom_mesh *mesh, fathom_id material) {
    for (size_t i = 0; i < group->overrides.count; ++i) {
        const fathom_id override = group->overrides.items[i];
        if ((override != FATHOM_NONE ? override : mesh->material) == material) return true;
    }
    return false;
}

/* If only vertex colours have alpha, the material itself does not show that alpha is used. */
static bool has_alpha_vertices(const glb *g, fathom_id material) {
    uint32_t unused;
    for (uint32_t k = 0; k < g->graph->order_count; ++k) {
        const uint32_t group = g->graph->order[k];
        for (uint32_t i = g->graph->objects.first[group]; i < g->graph->objects.first[group + 1]; ++i) {
            const fathom_mesh *mesh = glb_object_mesh(g, i, &unused);
            if (mesh && mesh->colors && mesh->color_channels == 4 && wears(&g->groups[group], mesh, material))
                return true;
        }
    }
    return false;
}

static shape shape_of(const glb *g, fathom_id id) {
    const fathom_material *given = &g->scene->materials.items[id].value;
    const bool classic = given->model == FATHOM_MODEL_CLASSIC;
    size_t lost = 0;
    shape s = {.m = classic ? glb_classic(given, &lost) : *given};
    s.unlit = is_unlit(&s.m);
    if (s.unlit) make_unlit(&s);
    s.glossy = is_glossy(g->scene, &s.m);
    limit_emission(&s.m, g->notes);
    drop_strangers(g->scene, &s, &lost);
    s.blends = s.m.opacity < 1 || s.m.opacity_cutoff > 0 || has_map(&s.m, FATHOM_MAP_OPACITY) ||
               has_alpha_vertices(g, id);
    if (lost)
        notes_add(g->notes, lost, "",
                  "an image that glTF has no place for, by its parameter or its channel, is left out");
    if (s.blends && has_map(&s.m, FATHOM_MAP_COLOR) && !has_map(&s.m, FATHOM_MAP_OPACITY))
        notes_add(g->notes, 1, "",
                  "the alpha of a material's colour image, if it has one, counts as opacity");
    if (classic && !glb_is_exact(given))
        notes_add(g->notes, 1, "",
                  "a material of the model classic becomes its nearest metallicRoughness one");
    if (s.m.priority || !s.m.multiscatter)
        notes_add(g->notes, 1, "", "priority and multiscatter of a material have no place in glTF");
    if (s.m.ior > 0 && s.m.ior < 1) {
        notes_add(g->notes, 1, "", "an index of refraction below 1 has no place in glTF, and becomes 1");
        s.m.ior = 1;
    }
    return s;
}

/* ---- text ---- */

static float number_of(const fathom_material *m, const gltf_key *key, unsigned i) {
    return ((const float *)(const void *)((const char *)m + key->offset))[i];
}

static bool is_given(const shape *s, const gltf_key *key) {
    const bool tint = key->of == GLTF_SPECULAR && (key->count == 3 || key->map == FATHOM_MAP_SPECULAR_COLOR);
    const bool replaced =
        s->glossy ? key->of == GLTF_PBR || key->of == GLTF_IOR || tint : key->of == GLTF_GLOSSINESS;
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

/* The inverse of reading. */
static void put_transform(file_writer *t, const float m[6]) {
    const write_turn turn = write_turn_of(m);
    if (turn.plain) return;
    file_writer_print(t,
                      ",\"extensions\":{\"KHR_texture_transform\":{\"offset\":[%.9g,%.9g],\"rotation\":%.17g,"
                      "\"scale\":[%.17g,%.17g]}}",
                      (double)m[2], (double)m[5], turn.radians, turn.scale[0], turn.scale[1]);
}

static void put_map(file_writer *t, const shape *s, const gltf_key *key) {
    const fathom_map *map = &s->m.maps[key->map];
    file_writer_print(t, "\"%s\":{\"index\":%u,\"texCoord\":%u", key->name, map->texture, map->uv_set);
    if (key->map == FATHOM_MAP_NORMAL) file_writer_print(t, ",\"scale\":%.9g", (double)s->m.normal_scale);
    if (key->map == FATHOM_MAP_CLEARCOAT_NORMAL)
        file_writer_print(t, ",\"scale\":%.9g", (double)s->m.clearcoat_normal_scale);
    put_transform(t, map->transform);
    file_writer_print(t, "}");
}

/* Writes colour and opacity, which are one value in glTF. */
static void put_base(file_writer *t, const shape *s) {
    const float *c = s->m.base_color, rgba[4] = {c[0], c[1], c[2], s->m.opacity};
    put_floats(t, s->glossy ? "diffuseFactor" : "baseColorFactor", rgba, 4);
    if (s->glossy) file_writer_print(t, ",\"glossinessFactor\":%.17g", 1 - (double)s->m.roughness);
}

static void put_keys(file_writer *t, const shape *s, gltf_holder of, const char *comma) {
    for (size_t i = 0; i < gltf_key_count; ++i) {
        if (gltf_keys[i].of != of || !is_given(s, &gltf_keys[i])) continue;
        float values[3];
        for (unsigned k = 0; k < gltf_keys[i].count; ++k) values[k] = number_of(&s->m, &gltf_keys[i], k);
        file_writer_print(t, "%s", comma);
        if (gltf_keys[i].count)
            put_floats(t, gltf_keys[i].name, values, gltf_keys[i].count);
        else
            put_map(t, s, &gltf_keys[i]);
        comma = ",";
    }
}

/* A bit for each holder that the material needs. */
static unsigned holders_of(const shape *s) {
    unsigned used = (s->unlit ? 1u << GLTF_UNLIT : 0) | 1u << (s->glossy ? GLTF_GLOSSINESS : GLTF_PBR);
    for (size_t i = 0; i < gltf_key_count; ++i) {
        if (is_given(s, &gltf_keys[i])) used |= 1u << gltf_keys[i].of;
    }
    return used;
}

static void put_material(file_writer *t, const char *name, const shape *s) {
    const unsigned used = holders_of(s);
    const char *open = ",\"extensions\":{";
    file_writer_print(t, "{\"doubleSided\":%s", s->m.double_sided ? "true" : "false");
    if (name) glb_put_name(t, ",", name);
    if (!s->glossy) {
        file_writer_print(t, ",\"%s\":{", gltf_holder_names[GLTF_PBR]);
        put_base(t, s);
        put_keys(t, s, GLTF_PBR, ",");
        file_writer_print(t, "}");
    }
    put_keys(t, s, GLTF_CORE, ",");
    if (s->m.opacity_cutoff > 0)
        file_writer_print(t, ",\"alphaMode\":\"MASK\",\"alphaCutoff\":%.9g", (double)s->m.opacity_cutoff);
    else if (s->blends)
        file_writer_print(t, ",\"alphaMode\":\"BLEND\"");
    for (gltf_holder h = GLTF_CORE + 1; h < GLTF_HOLDERS; ++h) {
        if (!(used >> h & 1)) continue;
        file_writer_print(t, "%s\"%s\":{", open, gltf_holder_names[h]);
        if (h == GLTF_GLOSSINESS) put_base(t, s);
        put_keys(t, s, h, h == GLTF_GLOSSINESS ? "," : "");
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

/* The names whose bit is set, as a list. */
static void put_names(file_writer *t, const char *key, const char *const *names, unsigned used) {
    const char *open = "[";
    if (!used) return;
    file_writer_print(t, ",\n\"%s\":", key);
    for (unsigned i = 0; used >> i; ++i) {
        if (used >> i & 1) file_writer_print(t, "%s\"%s\"", open, names[i]), open = ",";
    }
    file_writer_print(t, "]");
}

/* Images of some types are only named by extensions, so that a reader has to know these. */
static void put_extensions(const glb *g, file_writer *t, unsigned holders, bool transforms) {
    enum { TRANSFORM = GLTF_HOLDERS, WEBP, AVIF, BASISU, LIGHTS, NAMES };
    const char *names[NAMES] = {[TRANSFORM] = "KHR_texture_transform",
                                [WEBP] = "EXT_texture_webp",
                                [AVIF] = "EXT_texture_avif",
                                [BASISU] = "KHR_texture_basisu",
                                [LIGHTS] = "KHR_lights_punctual"};
    unsigned needed = 0;
    memcpy(names, gltf_holder_names, sizeof gltf_holder_names);
    for (uint32_t i = 0; i < g->images.count; ++i) {
        const char *type = write_image_type(&g->images.items[i]);
        if (type && strcmp(type, "image/webp") == 0) needed |= 1u << WEBP;
        if (type && strcmp(type, "image/avif") == 0) needed |= 1u << AVIF;
        if (type && strcmp(type, "image/ktx2") == 0) needed |= 1u << BASISU;
    }
    const unsigned parts = 1u << GLTF_PBR | 1u << GLTF_CORE, lights = glb_has_lights(g);
    put_names(t, "extensionsUsed", names,
              (holders & ~parts) | (unsigned)transforms << TRANSFORM | lights << LIGHTS | needed);
    put_names(t, "extensionsRequired", names, needed);
}

void glb_put_materials(glb *g, file_writer *t) {
    unsigned holders = 0;
    bool transforms = false;
    file_writer_print(t, ",\n\"materials\":[");
    for (uint32_t i = 0; i < g->scene->materials.count; ++i) {
        const shape s = shape_of(g, i);
        holders |= holders_of(&s);
        transforms |= has_transforms(&s);
        file_writer_print(t, i ? ",\n" : "\n");
        put_material(t, g->scene->materials.items[i].name, &s);
    }
    file_writer_print(t, "]");
    put_extensions(g, t, holders, transforms);
}
