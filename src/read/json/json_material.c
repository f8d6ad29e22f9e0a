/* Materials, and the images that they take parameters from. */
#include "base/parameter.h"
#include "read/json/json_scene.h"
#include "read/read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* By default, the image decides for maps of colours; maps of numbers are linear. */
static void set_space(const form_texture_values *v, int kind, fathom_texture *out) {
    out->color_space = material_map_is_color(kind) ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR;
    if (!v->color_space) return;
    out->color_space = FATHOM_COLOR_NAMED;
    out->color_space_name = v->color_space;
    if (strcmp(v->color_space, "srgb") == 0) out->color_space = FATHOM_COLOR_SRGB;
    if (strcmp(v->color_space, "linear") == 0) out->color_space = FATHOM_COLOR_LINEAR;
}

/* True if the texture is the first with its named color space. If the name is unknown, this one fails. */
static bool begins_space(const fathom_scene *scene, fathom_id id) {
    const fathom_texture *all = scene->textures.items;
    if (all[id].color_space != FATHOM_COLOR_NAMED || scene_origin_find(scene, SCENE_PART_COLOR_SPACE, id))
        return false;
    for (fathom_id i = 0; i < id; ++i) {
        if (all[i].color_space == FATHOM_COLOR_NAMED &&
            strcmp(all[i].color_space_name, all[id].color_space_name) == 0)
            return false;
    }
    return true;
}

/* As in glTF's KHR_texture_transform: scale, then rotation, then offset. */
static void set_transform(const form_texture_values *v, float out[6]) {
    const double turn = place_radians(v->rotation), c = cos(turn), s = sin(turn);
    out[0] = (float)(c * v->scale[0]), out[1] = (float)(s * v->scale[1]), out[2] = (float)v->offset[0];
    out[3] = (float)(-s * v->scale[0]), out[4] = (float)(c * v->scale[1]), out[5] = (float)v->offset[1];
}

/* Keys of textures that some kinds of maps ignore: channel where the image gives colours, directions, or two
 * parameters from fixed channels; inverted where it does not just scale parameters. */
#define KIND(kind) (1u << (kind))
enum {
    DIRECTIONS = KIND(FATHOM_MAP_NORMAL) | KIND(FATHOM_MAP_CLEARCOAT_NORMAL) | KIND(FATHOM_MAP_ANISOTROPY) |
                 KIND(FORM_METALLIC_ROUGHNESS)
};
static const struct {
    const char *key;
    unsigned ignored;
} texture_extras[] = {
    {"channel", DIRECTIONS | KIND(FATHOM_MAP_COLOR) | KIND(FATHOM_MAP_EMISSIVE) |
                    KIND(FATHOM_MAP_SPECULAR_COLOR) | KIND(FATHOM_MAP_SHEEN_COLOR) |
                    KIND(FATHOM_MAP_DIFFUSE_TRANSMISSION_COLOR)},
    {"inverted", DIRECTIONS | KIND(FATHOM_MAP_BUMP) | KIND(FATHOM_MAP_IRIDESCENCE_THICKNESS)},
};

static void warn_texture(const object_reader *r, const where *at, json_t *value, int kind) {
    for (size_t i = 0; i < sizeof texture_extras / sizeof *texture_extras; ++i) {
        const where key = {at, texture_extras[i].key, 0};
        if (texture_extras[i].ignored & KIND(kind) && doc_has(value, key.key))
            doc_warn(r->doc, &key, "it has no effect on this image");
    }
    const where space = {at, "colorSpace", 0};
    const char *name = json_string_value(json_object_get(value, space.key));
    if (DIRECTIONS & KIND(kind) && name && strcmp(name, "srgb") == 0)
        doc_warn(r->doc, &space, "expected \"linear\", because this image holds no colours");
}

static fathom_status add_texture(const object_reader *r, const where *at, const form_texture_values *v,
                                 int kind, fathom_map *out) {
    const where file = {at, "file", 0}, space = {at, "colorSpace", 0}, channel = {at, "channel", 0},
                filter = {at, "filter", 0};
    fathom_texture t;
    char *path;
    fathom_texture_default(&t);
    if (!*v->file) return doc_fail(r->doc, &file, "expected the name of a file, found \"\"");
    if (kind == FATHOM_MAP_BUMP && v->filter == FATHOM_TEXTURE_STOCHASTIC)
        return doc_fail(
            r->doc, &filter,
            "expected \"nearest\", \"linear\" or \"trilinear\", because texels chosen by chance have "
            "no slope");
    fathom_status status = read_beside(r->scene, r->doc->path, v->file, &path);
    if (status != FATHOM_OK) return doc_within(r->doc, &file, status);
    t.file = path;
    t.wrap_u = (fathom_wrap)v->wrap_u, t.wrap_v = (fathom_wrap)v->wrap_v;
    t.filter = (fathom_texture_filter)v->filter;
    set_space(v, kind, &t);
    out->uv_set = v->uv_set, out->channel = (uint32_t)v->channel, out->inverted = v->inverted;
    set_transform(v, out->transform);
    const size_t before = r->scene->textures.count;
    status = fathom_scene_add_texture(r->scene, &t, &out->texture);
    free(path);
    if (status != FATHOM_OK) return doc_within(r->doc, &file, status);
    if (r->scene->textures.count > before) status = place_origin(r, &file, SCENE_PART_TEXTURE, out->texture);
    if (status == FATHOM_OK && v->channel == 3 &&
        !scene_origin_find(r->scene, SCENE_PART_ALPHA, out->texture))
        status = place_origin(r, &channel, SCENE_PART_ALPHA, out->texture);
    if (status != FATHOM_OK) return status;
    return begins_space(r->scene, out->texture)
               ? place_origin(r, &space, SCENE_PART_COLOR_SPACE, out->texture)
               : FATHOM_OK;
}

/* The key of a map in the form. */
static const char *key_of(const form *f, int kind) {
    const size_t offset =
        offsetof(form_material_values, textures) + (size_t)kind * sizeof(form_texture_values);
    for (const form_key *const *part = f->parts; *part; ++part) {
        for (const form_key *key = *part; key->name; ++key) {
            if (key->kind == FORM_OBJECT && key->offset == offset) return key->name;
        }
    }
    return NULL;
}

/* Where p is 1, 1 - (1 - p) image is 1. The image "kdTexture" multiplies p = "kd". */
static void warn_inverted(const object_reader *r, const where *at, const form *f,
                          const form_material_values *v) {
    char name[PARAMETER_NAME];
    snprintf(name, sizeof name, "%.*s", (int)(strlen(at->key) - strlen("Texture")), at->key);
    const form_key *factor = form_find(f, name);
    const where key = {at, "inverted", 0};
    if (!factor) return;
    const float *p = (const float *)(const void *)((const char *)v + factor->offset);
    for (unsigned i = 0; i < (factor->count ? factor->count : 1); ++i)
        if (p[i] != 1) return;
    doc_warn(r->doc, &key, "it has no effect where \"%s\" is 1; with 0 the surface has 1 - image", name);
}

static fathom_status add_textures(const object_reader *r, const where *at, json_t *value, const form *f,
                                  form_material_values *v) {
    fathom_map *maps = v->material.maps, both;
    fathom_status status = FATHOM_OK;
    for (int kind = 0; kind <= FORM_METALLIC_ROUGHNESS && status == FATHOM_OK; ++kind) {
        const char *key = key_of(f, kind);
        if (!key || !doc_has(value, key)) continue;
        const where texture = {at, key, 0};
        warn_texture(r, &texture, json_object_get(value, key), kind);
        if (v->textures[kind].inverted) warn_inverted(r, &texture, f, v);
        status = add_texture(r, &texture, &v->textures[kind], kind,
                             kind == FORM_METALLIC_ROUGHNESS ? &both : &maps[kind]);
        if (status != FATHOM_OK || kind != FORM_METALLIC_ROUGHNESS) continue;
        both.inverted = false;
        maps[FATHOM_MAP_METALLIC] = maps[FATHOM_MAP_ROUGHNESS] = both;
        maps[FATHOM_MAP_METALLIC].channel = 2, maps[FATHOM_MAP_ROUGHNESS].channel = 1;
    }
    return status;
}

static fathom_status add_material(const object_reader *r, const where *at, const char *name, json_t *value) {
    form_material_values v;
    fathom_id id;
    const form *f;
    memset(&v, 0, sizeof v);
    fathom_material_default(&v.material);
    for (int k = 0; k <= FORM_METALLIC_ROUGHNESS; ++k)
        v.textures[k] = (form_texture_values){.scale = {1, 1}, .filter = FATHOM_TEXTURE_TRILINEAR};
    fathom_status status = doc_choose(r->doc, at, value, &form_material, &f);
    if (status == FATHOM_OK) status = doc_read(r->doc, at, value, f, &v);
    if (status == FATHOM_OK) status = add_textures(r, at, value, f, &v);
    if (status != FATHOM_OK) return status;
    v.material.model = (fathom_model)f->id;
    status = fathom_scene_add_material(r->scene, name, &v.material, &id);
    if (status != FATHOM_OK) return doc_within(r->doc, at, status);
    status = light_group_set(r, at, "group", FATHOM_SOURCE_MATERIAL, id, id + (size_t)1, v.group);
    if (status != FATHOM_OK) return status;
    if (json_object_set_new(r->materials, name, json_integer(id)) != 0)
        return fail_memory(r->scene->context, strlen(name));
    return FATHOM_OK;
}

/* Meshes without the set of texture coordinates that an image of their material takes. */
static void warn_set(const object_reader *r, const where *at, json_t *value, const form *f, fathom_id id,
                     unsigned set) {
    size_t bare = 0;
    for (size_t i = 0; i < r->scene->meshes.count; ++i) {
        const fathom_mesh *mesh = &r->scene->meshes.items[i];
        bare += mesh->material == id && !(set ? mesh->uvs_1 : mesh->uvs) && mesh->triangle_count;
    }
    for (int kind = 0; kind <= FORM_METALLIC_ROUGHNESS && bare; ++kind) {
        const char *key = key_of(f, kind);
        const where texture = {at, key, 0}, set_key = {&texture, "uvSet", 0};
        json_t *image = key ? json_object_get(value, key) : NULL;
        if (!image || json_number_value(json_object_get(image, set_key.key)) != set) continue;
        doc_warn(r->doc, set ? &set_key : &texture,
                 "a mesh with this material has no \"%s\", so each of its triangles shows half the image",
                 set ? "uvs1" : "uvs");
        return;
    }
}

/* Warns of keys without effect that the rules of the form cannot tell. */
static void warn_more(const object_reader *r, const where *at, json_t *value) {
    const where image = {at, "metallicRoughnessTexture", 0}, through = {at, "transmission", 0},
                volume = {at, "thickness", 0};
    const double transmission = json_number_value(json_object_get(value, through.key));
    if (doc_has(value, volume.key) && !doc_has(value, through.key) && !doc_has(value, "diffuseTransmission"))
        doc_warn(r->doc, &volume,
                 "it has no effect without one of \"transmission\", \"diffuseTransmission\"");
    if (doc_has(value, image.key) && !doc_has(value, "metallic"))
        doc_warn(r->doc, &image, "its blue has no effect without \"metallic\"");
    if (transmission > 0 && json_number_value(json_object_get(value, "metallic")) == 1 &&
        !doc_has(value, image.key) && !doc_has(value, "metallicTexture"))
        doc_warn(r->doc, &through, "it has no effect where \"metallic\" is 1");
}

static void warn_material(const object_reader *r, const where *at, const char *name, json_t *value) {
    const char *also = scene_has_opacities(r->scene) ? FORM_OPACITIES : NULL;
    const form *f;
    if (doc_choose(r->doc, at, value, &form_material, &f) != FATHOM_OK) return;
    const fathom_id id = (fathom_id)json_integer_value(json_object_get(r->materials, name));
    doc_warn_useless(r->doc, at, value, f, also);
    warn_set(r, at, value, f, id, 0);
    warn_set(r, at, value, f, id, 1);
    warn_more(r, at, value);
}

/* ---- all materials of the file ---- */

fathom_status materials_add(const object_reader *r, json_t *materials) {
    const where at = {NULL, "materials", 0};
    fathom_status status = FATHOM_OK;
    const char *name;
    json_t *value;
    /* Reserves the exact size, because a growing array takes up to two and a half times the memory. */
    if (!array_room(&r->scene->materials, json_object_size(materials)))
        return fail_memory(r->scene->context, json_object_size(materials) * sizeof(scene_named_material));
    json_object_foreach(materials, name, value) {
        const where item = {&at, name, 0};
        if (status == FATHOM_OK) status = add_material(r, &item, name, value);
    }
    return status;
}

/* Warns of the first material that nothing has. */
static fathom_status warn_unused(const object_reader *r, json_t *materials) {
    const fathom_scene *scene = r->scene;
    const where at = {NULL, "materials", 0};
    bool *used = calloc(scene->materials.count, sizeof *used);
    if (!used) return fail_memory(scene->context, scene->materials.count);
    for (size_t i = 0; i < scene->objects.count; ++i) used[scene_object_material(scene, (fathom_id)i)] = true;
    for (size_t i = 0; i < scene->instances.count; ++i)
        if (scene->instances.items[i].material != FATHOM_NONE)
            used[scene->instances.items[i].material] = true;
    const char *name, *first = NULL;
    json_t *value;
    size_t unused = 0;
    json_object_foreach(materials, name, value) {
        if (used[json_integer_value(json_object_get(r->materials, name))]) continue;
        if (!unused++) first = name;
    }
    const where item = {&at, first, 0};
    if (unused == 1) doc_warn(r->doc, &item, "no object has this material");
    if (unused > 1) doc_warn(r->doc, &item, "no object has this material, the first of %zu such", unused);
    free(used);
    return FATHOM_OK;
}

fathom_status materials_warn(const object_reader *r, json_t *materials) {
    const where at = {NULL, "materials", 0};
    const char *name;
    json_t *value;
    json_object_foreach(materials, name, value) {
        const where item = {&at, name, 0};
        warn_material(r, &item, name, value);
    }
    return warn_unused(r, materials);
}
