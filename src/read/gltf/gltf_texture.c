/* Textures: images with their samplers, as maps of materials. */
#include "read/gltf/gltf_material.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- samplers ---- */

enum { GL_NEAREST = 9728, GL_LINEAR = 9729, GL_CLAMP = 33071, GL_MIRROR = 33648, GL_REPEAT = 10497 };

static fathom_wrap read_wrap(gltf *g, const gltf_value *sampler, const char *key) {
    uint64_t mode = GL_REPEAT;
    gltf_integer(g, sampler, key, 0, UINT32_MAX, &mode);
    if (mode != GL_REPEAT && mode != GL_CLAMP && mode != GL_MIRROR)
        gltf_note(
            g, sampler, key,
            "a wrap mode other than 10497 (repeat), 33071 (clamp) and 33648 (mirror) is read as repeat");
    return mode == GL_CLAMP ? FATHOM_WRAP_CLAMP : mode == GL_MIRROR ? FATHOM_WRAP_MIRROR : FATHOM_WRAP_REPEAT;
}

/* If the magnification filter is nearest, so is the texture's filter. A minification filter without mip
 * levels means linear. */
static void read_sampler(gltf *g, uint32_t index, fathom_texture *out) {
    gltf_value at;
    uint64_t larger = GL_LINEAR, smaller = 0;
    gltf_item(g, &g->samplers, index, &at);
    out->wrap_u = read_wrap(g, &at, "wrapS");
    out->wrap_v = read_wrap(g, &at, "wrapT");
    gltf_integer(g, &at, "magFilter", 0, UINT32_MAX, &larger);
    gltf_integer(g, &at, "minFilter", 0, UINT32_MAX, &smaller);
    if (larger == GL_NEAREST)
        out->filter = FATHOM_TEXTURE_NEAREST;
    else if (smaller == GL_NEAREST || smaller == GL_LINEAR)
        out->filter = FATHOM_TEXTURE_LINEAR;
}

/* ---- textures ---- */

/* The image that the extension names, or GLTF_ABSENT. */
static uint32_t source_of(gltf *g, const gltf_value *texture, const char *extension) {
    gltf_value holder, at;
    uint32_t source = GLTF_ABSENT;
    gltf_extension(g, texture, extension, &holder, &at);
    gltf_index(g, &at, "source", &g->images, &source);
    return source;
}

/* The image of a texture: that of a supported extension, else the texture's own. An image that cannot be read
 * is passed over if another one follows. *basisu: the image is that of KHR_texture_basisu. */
static uint32_t find_source(gltf *g, const gltf_value *texture, bool *basisu) {
    static const char *const extensions[] = {"KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif",
                                             "EXT_texture_webp"};
    enum { EXTENSIONS = sizeof extensions / sizeof *extensions };
    uint32_t sources[EXTENSIONS + 1], count = 0, taken = 0;
    for (size_t i = 0; i < EXTENSIONS; ++i) {
        sources[count] = source_of(g, texture, extensions[i]);
        if (i == 0) *basisu = sources[0] != GLTF_ABSENT;
        count += sources[count] != GLTF_ABSENT;
    }
    sources[count] = GLTF_ABSENT;
    gltf_index(g, texture, "source", &g->images, &sources[count]);
    count += sources[count] != GLTF_ABSENT;
    while (taken + 1 < count && !gltf_image_opens(g, sources[taken])) ++taken;
    *basisu &= taken == 0;
    return count ? sources[taken] : GLTF_ABSENT;
}

static void add_texture(gltf *g, const gltf_value *image, const fathom_texture *t, fathom_id *out) {
    const size_t before = g->scene->textures.count;
    where_spot spot;
    gltf_within(g, image, NULL, fathom_scene_add_texture(g->scene, t, out));
    if (!gltf_fine(g) || g->scene->textures.count == before) return;
    g->status = scene_origin_add(g->scene, SCENE_PART_TEXTURE, *out, gltf_field(g, image, &spot));
    /* A new texture has its own copy of the image's bytes. */
    if (t->bytes && gltf_fine(g)) gltf_charge(g, image, NULL, t->byte_count);
}

static bool is_png(const fathom_texture *t) {
    static const unsigned char first[] = {0x89, 'P', 'N', 'G'};
    char extension[16] = "";
    if (t->file) file_extension(t->file, extension);
    return strcmp(extension, "png") == 0 ||
           (t->byte_count > sizeof first && memcmp(t->bytes, first, sizeof first) == 0);
}

/* FATHOM_NONE, with a note, if the texture has no readable image. */
static fathom_id read_texture(gltf *g, uint32_t index, bool color) {
    gltf_value at, image;
    uint32_t sampler = GLTF_ABSENT;
    char *path = NULL;
    fathom_texture t;
    fathom_id out = FATHOM_NONE;
    fathom_texture_default(&t);
    t.color_space = color ? FATHOM_COLOR_AUTO : FATHOM_COLOR_LINEAR;
    gltf_item(g, &g->textures, index, &at);
    bool basisu = false;
    const uint32_t source = find_source(g, &at, &basisu);
    gltf_index(g, &at, "sampler", &g->samplers, &sampler);
    if (sampler != GLTF_ABSENT) read_sampler(g, sampler, &t);
    if (source == GLTF_ABSENT) {
        gltf_note(g, &at, NULL, "a texture without an image that can be read is left out");
        return FATHOM_NONE;
    }
    gltf_item(g, &g->images, source, &image);
    gltf_image_open(g, &image, &t, &path);
    /* The format wants colours to be sRGB, whatever the image says. */
    if (color && (basisu || is_png(&t))) t.color_space = FATHOM_COLOR_SRGB;
    if (gltf_fine(g) && (t.file || t.bytes)) add_texture(g, &image, &t, &out);
    free(path);
    return out;
}

/* ---- maps ---- */

/* offset · rotation · scale, in the extension's order of multiplication. */
static void read_transform(gltf *g, const gltf_value *info, double *set, fathom_map *out) {
    gltf_value holder, at;
    double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
    gltf_extension(g, info, "KHR_texture_transform", &holder, &at);
    gltf_numbers(g, &at, "offset", 2, -1e6, 1e6, offset);
    gltf_numbers(g, &at, "scale", 2, -1e6, 1e6, scale);
    gltf_number(g, &at, "rotation", -1e6, 1e6, &rotation);
    gltf_number(g, &at, "texCoord", 0, 1e6, set);
    const double c = cos(rotation), s = sin(rotation);
    out->transform[0] = (float)(c * scale[0]), out->transform[1] = (float)(s * scale[1]);
    out->transform[3] = (float)(-s * scale[0]), out->transform[4] = (float)(c * scale[1]);
    out->transform[2] = (float)offset[0], out->transform[5] = (float)offset[1];
}

bool gltf_map(gltf *g, const gltf_value *parent, const char *key, bool color, fathom_map *out) {
    gltf_value info;
    uint32_t index = GLTF_ABSENT;
    double set = 0;
    *out = (fathom_map){.texture = FATHOM_NONE};
    gltf_object(g, parent, key, &info);
    if (!info.json) return false;
    gltf_index(g, &info, "index", &g->textures, &index);
    if (!json_object_get(info.json, "index"))
        gltf_fail(g, &info, "index", "is missing; expected an index into textures");
    if (index == GLTF_ABSENT) return false;
    gltf_number(g, &info, "texCoord", 0, 1e6, &set);
    read_transform(g, &info, &set, out);
    if (!gltf_fine(g)) return false;
    if (set != 0 && set != 1) {
        gltf_note(g, &info, "texCoord", "%s uses a uv set beyond the second; it is left out", key);
        return false;
    }
    out->uv_set = (uint32_t)set;
    out->texture = read_texture(g, index, color);
    return gltf_fine(g) && out->texture != FATHOM_NONE;
}
