/* KHR_animation_pointer: animated values that are neither a node's transform nor its weights, such as colours
 * of materials, places of textures, cameras and lights. The value of the middle of the shutter time replaces
 * that of the document before its reader sees it. */
#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_keys.h"
#include "read/gltf/gltf_pose.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { LONGEST = 192 };

/* A kind of value: the pointer with * for each index, and how many numbers it has; 0: true or false. */
typedef struct value_kind {
    const char *name;
    unsigned count;
} value_kind;

static const value_kind kinds[] = {
    {"/materials/*/alphaCutoff", 1},
    {"/materials/*/pbrMetallicRoughness/baseColorFactor", 4},
    {"/materials/*/normalTexture/scale", 1},
    {"/materials/*/occlusionTexture/strength", 1}, /* occlusion is computed */
    {"/materials/*/extensions/KHR_materials_clearcoat/clearcoatNormalTexture/scale", 1},
    {"/cameras/*/perspective/yfov", 1},
    {"/cameras/*/perspective/znear", 1},
    {"/cameras/*/perspective/zfar", 1},
    {"/cameras/*/orthographic/xmag", 1},
    {"/cameras/*/orthographic/ymag", 1},
    {"/cameras/*/orthographic/znear", 1},
    {"/cameras/*/orthographic/zfar", 1},
    {"/extensions/KHR_lights_punctual/lights/*/color", 3},
    {"/extensions/KHR_lights_punctual/lights/*/intensity", 1},
    {"/extensions/KHR_lights_punctual/lights/*/spot/innerConeAngle", 1},
    {"/extensions/KHR_lights_punctual/lights/*/spot/outerConeAngle", 1},
    {"/nodes/*/extensions/KHR_node_visibility/visible", 0},
};

/* Endings after the pointer to a texture of a material. */
static const value_kind texture_kinds[] = {
    {"/extensions/KHR_texture_transform/offset", 2},
    {"/extensions/KHR_texture_transform/rotation", 1},
    {"/extensions/KHR_texture_transform/scale", 2},
};

/* Copies a pointer, with * for each index. */
static void generalize(const char *pointer, char out[LONGEST]) {
    size_t used = 0;
    while (*pointer && used + 2 < LONGEST) {
        out[used++] = *pointer++;
        const size_t digits = strspn(pointer, "0123456789");
        if (out[used - 1] != '/' || !digits || (pointer[digits] && pointer[digits] != '/')) continue;
        out[used++] = '*', pointer += digits;
    }
    out[used] = '\0';
}

/* Copies the pointer to a key of materials into `out`. */
static void print_key(const gltf_key *key, char out[LONGEST]) {
    const char *extensions = key->of == GLTF_PBR || key->of == GLTF_CORE ? "" : "extensions/";
    const char *holder = key->of == GLTF_CORE ? "" : gltf_holder_names[key->of];
    snprintf(out, LONGEST, "/materials/*/%s%s%s%s", extensions, holder, *holder ? "/" : "", key->name);
}

static int count_in(const value_kind *list, size_t length, const char *name) {
    for (size_t i = 0; i < length; ++i) {
        if (strcmp(list[i].name, name) == 0) return (int)list[i].count;
    }
    return -1;
}

/* How many numbers a kind has, 0 for true or false; -1: it is not read. */
static int count_of(const char *kind) {
    char one[LONGEST];
    const int count = count_in(kinds, sizeof kinds / sizeof *kinds, kind);
    for (size_t i = 0; i < gltf_key_count && count < 0; ++i) {
        const gltf_key *key = &gltf_keys[i];
        print_key(key, one);
        const size_t length = strlen(one);
        if (key->count && strcmp(one, kind) == 0) return (int)key->count;
        if (!key->count && strncmp(one, kind, length) == 0 && kind[length])
            return count_in(texture_kinds, sizeof texture_kinds / sizeof *texture_kinds, kind + length);
    }
    return count;
}

/* The object that holds the value, and the value's key in `pointer`. NULL: the file has no such object. */
static json_t *find_holder(const gltf *g, const char *pointer, const char **key) {
    json_t *at = g->root.json;
    for (;;) {
        char name[LONGEST];
        const size_t length = strcspn(++pointer, "/");
        if (!pointer[length]) break;
        snprintf(name, sizeof name, "%.*s", (int)length, pointer);
        at = json_is_array(at) ? json_array_get(at, strtoul(name, NULL, 10)) : json_object_get(at, name);
        pointer += length;
    }
    *key = pointer;
    return json_is_object(at) ? at : NULL;
}

/* True if each key of the sampler has this many numbers. */
static bool fits(gltf *g, const gltf_value *samplers, uint32_t sampler, unsigned numbers) {
    gltf_value at;
    gltf_item(g, samplers, sampler, &at);
    return gltf_components(g, &at, "output") == numbers;
}

void gltf_pointer_pose(gltf *g, const gltf_value *target, const char *pointer, const gltf_value *samplers,
                       uint32_t sampler) {
    const double open = g->moments.items[0].time, shutter = gltf_shutter(g);
    char kind[LONGEST];
    const char *key;
    double before[4], value[4], after[4];
    generalize(pointer, kind);
    const int count = count_of(kind);
    json_t *holder = count < 0 ? NULL : find_holder(g, pointer, &key);
    if (!holder) {
        gltf_note(g, target, NULL, "the animation of \"%.120s\" is ignored", kind);
        return;
    }
    const unsigned numbers = count ? (unsigned)count : 1;
    if (!fits(g, samplers, sampler, numbers) && gltf_fine(g)) {
        gltf_note(g, target, NULL, "the animation of \"%.120s\" is ignored: expected %u number%s a key", kind,
                  numbers, numbers > 1 ? "s" : "");
        return;
    }
    if (!gltf_sampler_value(g, samplers, sampler, numbers, open, before) ||
        !gltf_sampler_value(g, samplers, sampler, numbers, open + shutter / 2, value) ||
        !gltf_sampler_value(g, samplers, sampler, numbers, open + shutter, after))
        return;
    if (memcmp(before, after, numbers * sizeof *value) != 0)
        gltf_note(g, target, NULL,
                  "the animation of \"%.120s\" is not blurred; it keeps the value of the middle of the "
                  "shutter time",
                  kind);
    if (!json_arena_set(&g->arena, holder, key, value, (size_t)count)) gltf_fail_memory(g, sizeof value);
}
