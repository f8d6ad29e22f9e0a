/* Textures: images in files, data URIs and buffer views, with their samplers, as maps of materials. */
#include "read/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- images ---- */

/* The bytes of an image in a buffer view. */
static void view_image(gltf *g, uint32_t index, fathom_texture *out) {
    gltf_value at;
    gltf_view view;
    gltf_view_open(g, index, &at, &view);
    out->bytes = view.bytes, out->byte_count = (size_t)view.length;
}

/* *path: the caller frees it. Sets the image's file or bytes in *out. If there is none, adds a note. */
static void open_image(gltf *g, const gltf_value *image, fathom_texture *out, char **path) {
    const char *uri = NULL;
    uint32_t view = GLTF_ABSENT;
    gltf_text(g, image, "uri", &uri);
    gltf_text(g, image, "name", &out->name);
    gltf_text(g, image, "mimeType", &out->mime);
    gltf_index(g, image, "bufferView", &g->views, &view);
    if (!gltf_fine(g)) return;
    if (view != GLTF_ABSENT) {
        view_image(g, view, out);
    } else if (!uri) {
        gltf_note(g, image, NULL, "an image with neither uri nor bufferView is left out");
    } else if (gltf_is_data(uri)) {
        gltf_buffer *bytes = &g->image_table[image->index];
        if (!bytes->bytes) gltf_data_uri(g, image, uri, bytes);
        out->bytes = bytes->bytes, out->byte_count = (size_t)bytes->size;
    } else {
        out->file = *path = gltf_image_path(g, image, uri);
    }
}

/* ---- samplers ---- */

enum { GL_NEAREST = 9728, GL_LINEAR = 9729, GL_CLAMP = 33071, GL_MIRROR = 33648, GL_REPEAT = 10497 };

static fathom_wrap read_wrap(gltf *g, const gltf_value *sampler, const char *key) {
    uint64_t mode = GL_REPEAT;
    gltf_integer(g, sampler, key, 0, UINT32_MAX, &mode);
    if (mode != GL_REPEAT && mode != GL_CLAMP && mode != GL_MIRROR)
        gltf_note(g, sampler, key,
                  "a way to wrap that is none of 10497 (repeat), 33071 (clamp) and 33648 (mirror); images "
                  "are repeated");
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

/* Whether the extension names an image, which *source then is. */
static bool takes_source(gltf *g, const gltf_value *texture, const char *name, uint32_t *source) {
    gltf_value holder, extension;
    gltf_extension(g, texture, name, &holder, &extension);
    gltf_index(g, &extension, "source", &g->images, source);
    return json_object_get(extension.json, "source");
}

/* The image of a texture: that of a supported extension, if there is one, else the texture's own. *basisu:
 * the image is that of KHR_texture_basisu. */
static uint32_t find_source(gltf *g, const gltf_value *texture, bool *basisu) {
    uint32_t source = GLTF_ABSENT;
    gltf_index(g, texture, "source", &g->images, &source);
    takes_source(g, texture, "EXT_texture_webp", &source);
    takes_source(g, texture, "EXT_texture_avif", &source);
    takes_source(g, texture, "MSFT_texture_dds", &source);
    *basisu = takes_source(g, texture, "KHR_texture_basisu", &source);
    return source;
}

static void add_texture(gltf *g, const gltf_value *image, const fathom_texture *t, fathom_id *out) {
    const size_t before = g->scene->textures.count;
    gltf_spot spot;
    gltf_within(g, image, NULL, fathom_scene_add_texture(g->scene, t, out));
    if (!gltf_fine(g) || g->scene->textures.count == before) return;
    g->status = scene_origin_add(g->scene, SCENE_PART_TEXTURE, *out, gltf_field(g, image, &spot));
    /* A new texture has its own copy of the image's bytes. */
    if (t->bytes && gltf_fine(g)) gltf_charge(g, image, NULL, t->byte_count);
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
    /* The extension wants colours to be sRGB, whatever the image says. */
    if (basisu && color) t.color_space = FATHOM_COLOR_SRGB;
    gltf_index(g, &at, "sampler", &g->samplers, &sampler);
    if (sampler != GLTF_ABSENT) read_sampler(g, sampler, &t);
    if (source == GLTF_ABSENT) {
        gltf_note(g, &at, NULL, "a texture without an image that can be read is left out");
        return FATHOM_NONE;
    }
    gltf_item(g, &g->images, source, &image);
    open_image(g, &image, &t, &path);
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
