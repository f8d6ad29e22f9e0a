/* Textures: images in files, data URIs and buffer views, with their samplers, as maps of materials. */
#include "read/gltf/gltf.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- images ---- */

/* The bytes of an image in a buffer view. */
static fathom_status view_image(gltf *g, uint32_t index, fathom_texture *out) {
    gltf_value at;
    gltf_view view;
    fathom_status status = gltf_view_open(g, index, &at, &view);
    out->bytes = view.bytes, out->byte_count = (size_t)view.length;
    return status;
}

/* *path: to be freed. *out names the image in one way or another, or in none: then that is noted. */
static fathom_status open_image(gltf *g, const gltf_value *image, fathom_texture *out, char **path) {
    const char *uri = NULL;
    uint32_t view = GLTF_ABSENT;
    fathom_status status = gltf_text(g, image, "uri", &uri);
    if (status == FATHOM_OK) status = gltf_text(g, image, "name", &out->name);
    if (status == FATHOM_OK) status = gltf_text(g, image, "mimeType", &out->mime);
    if (status == FATHOM_OK) status = gltf_index(g, image, "bufferView", &g->views, &view);
    if (status != FATHOM_OK) return status;
    if (view != GLTF_ABSENT) return view_image(g, view, out);
    if (!uri) {
        gltf_note(g, image, NULL, "an image with neither uri nor bufferView is left out");
        return FATHOM_OK;
    }
    if (gltf_is_data(uri)) {
        gltf_buffer *bytes = &g->image_table[image->index];
        if (!bytes->bytes) status = gltf_data_uri(g, image, uri, bytes);
        out->bytes = bytes->bytes, out->byte_count = (size_t)bytes->size;
        return status;
    }
    status = gltf_file_path(g, image, uri, path);
    if (status == FATHOM_OK && !*path) gltf_note(g, image, "uri", "there is no such file; it is left out");
    out->file = *path;
    return status;
}

/* ---- samplers ---- */

enum { GL_NEAREST = 9728, GL_LINEAR = 9729, GL_CLAMP = 33071, GL_MIRROR = 33648, GL_REPEAT = 10497 };

static fathom_status read_wrap(gltf *g, const gltf_value *sampler, const char *key, fathom_wrap *out) {
    uint64_t mode = GL_REPEAT;
    fathom_status status = gltf_integer(g, sampler, key, 0, UINT32_MAX, &mode);
    if (status != FATHOM_OK) return status;
    if (mode != GL_REPEAT && mode != GL_CLAMP && mode != GL_MIRROR)
        return gltf_fail(g, sampler, key, "is %llu; expected 10497 (repeat), 33071 (clamp) or 33648 (mirror)",
                         (unsigned long long)mode);
    *out = mode == GL_CLAMP ? FATHOM_WRAP_CLAMP : mode == GL_MIRROR ? FATHOM_WRAP_MIRROR : FATHOM_WRAP_REPEAT;
    return FATHOM_OK;
}

/* What is magnified to squares stays squares; a minification filter without mip levels does without them. */
static fathom_status read_sampler(gltf *g, uint32_t index, fathom_texture *out) {
    gltf_value at;
    uint64_t larger = GL_LINEAR, smaller = 0;
    fathom_status status = gltf_item(g, &g->samplers, index, &at);
    if (status == FATHOM_OK) status = read_wrap(g, &at, "wrapS", &out->wrap_u);
    if (status == FATHOM_OK) status = read_wrap(g, &at, "wrapT", &out->wrap_v);
    if (status == FATHOM_OK) status = gltf_integer(g, &at, "magFilter", 0, UINT32_MAX, &larger);
    if (status == FATHOM_OK) status = gltf_integer(g, &at, "minFilter", 0, UINT32_MAX, &smaller);
    if (larger == GL_NEAREST)
        out->filter = FATHOM_TEXTURE_NEAREST;
    else if (smaller == GL_NEAREST || smaller == GL_LINEAR)
        out->filter = FATHOM_TEXTURE_LINEAR;
    return status;
}

/* ---- textures ---- */

/* The image of a texture: an extension's, where it has one that is understood, else its own. */
static fathom_status find_source(gltf *g, const gltf_value *texture, uint32_t *source) {
    static const char *const extensions[] = {"EXT_texture_webp", "EXT_texture_avif"};
    fathom_status status = gltf_index(g, texture, "source", &g->images, source);
    for (size_t i = 0; i < 2 && status == FATHOM_OK; ++i) {
        gltf_value holder, extension;
        status = gltf_extension(g, texture, extensions[i], &holder, &extension);
        if (status != FATHOM_OK || !extension.json) continue;
        gltf_value place = {.json = extension.json, .parent = &holder, .key = extensions[i]};
        status = gltf_index(g, &place, "source", &g->images, source);
    }
    return status;
}

/* FATHOM_NONE, and noted, where it has no image that can be read. */
static fathom_status read_texture(gltf *g, uint32_t index, bool color, fathom_id *out) {
    gltf_value at, image;
    uint32_t source = GLTF_ABSENT, sampler = GLTF_ABSENT;
    char *path = NULL;
    fathom_texture t;
    fathom_texture_default(&t);
    t.color_space = color ? FATHOM_COLOR_SRGB : FATHOM_COLOR_LINEAR;
    *out = FATHOM_NONE;
    fathom_status status = gltf_item(g, &g->textures, index, &at);
    if (status == FATHOM_OK) status = find_source(g, &at, &source);
    if (status == FATHOM_OK) status = gltf_index(g, &at, "sampler", &g->samplers, &sampler);
    if (status == FATHOM_OK && sampler != GLTF_ABSENT) status = read_sampler(g, sampler, &t);
    if (status != FATHOM_OK) return status;
    if (source == GLTF_ABSENT) {
        gltf_note(g, &at, NULL, "a texture without an image that can be read is left out");
        return FATHOM_OK;
    }
    status = gltf_item(g, &g->images, source, &image);
    if (status == FATHOM_OK) status = open_image(g, &image, &t, &path);
    const size_t before = g->scene->textures.count;
    if (status == FATHOM_OK && (t.file || t.bytes))
        status = gltf_within(g, &image, NULL, fathom_scene_add_texture(g->scene, &t, out));
    /* Each way to look an image up has a copy of its bytes. */
    if (status == FATHOM_OK && t.bytes && g->scene->textures.count > before)
        status = gltf_charge(g, &at, NULL, t.byte_count);
    free(path);
    return status;
}

/* ---- maps ---- */

/* offset, then rotation, then scale, as the extension multiplies them. */
static fathom_status read_transform(gltf *g, const gltf_value *info, double *set, fathom_map *out) {
    gltf_value holder, at;
    double offset[2] = {0, 0}, scale[2] = {1, 1}, rotation = 0;
    fathom_status status = gltf_extension(g, info, "KHR_texture_transform", &holder, &at);
    if (status != FATHOM_OK || !at.json) return status;
    status = gltf_numbers(g, &at, "offset", 2, -1e6, 1e6, offset);
    if (status == FATHOM_OK) status = gltf_numbers(g, &at, "scale", 2, -1e6, 1e6, scale);
    if (status == FATHOM_OK) status = gltf_number(g, &at, "rotation", -1e6, 1e6, &rotation);
    if (status == FATHOM_OK) status = gltf_number(g, &at, "texCoord", 0, 1e6, set);
    const double c = cos(rotation), s = sin(rotation);
    out->transform[0] = (float)(c * scale[0]), out->transform[1] = (float)(s * scale[1]);
    out->transform[3] = (float)(-s * scale[0]), out->transform[4] = (float)(c * scale[1]);
    out->transform[2] = (float)offset[0], out->transform[5] = (float)offset[1];
    return status;
}

fathom_status gltf_map(gltf *g, const gltf_value *parent, const char *key, bool color, bool *there,
                       fathom_map *out) {
    gltf_value info;
    uint32_t index = GLTF_ABSENT;
    double set = 0;
    fathom_map map = {.texture = FATHOM_NONE, .transform = {1, 0, 0, 0, 1, 0}};
    *there = false;
    fathom_status status = gltf_object(g, parent, key, &info);
    if (status != FATHOM_OK || !info.json) return status;
    status = gltf_index(g, &info, "index", &g->textures, &index);
    if (status == FATHOM_OK && index == GLTF_ABSENT)
        return gltf_fail(g, &info, "index", "is missing; expected an index into textures");
    if (status == FATHOM_OK) status = gltf_number(g, &info, "texCoord", 0, 1e6, &set);
    if (status == FATHOM_OK) status = read_transform(g, &info, &set, &map);
    if (status != FATHOM_OK) return status;
    if (set != 0 && set != 1) {
        gltf_note(g, &info, "texCoord", "%s uses a uv set beyond the second; it is left out", key);
        return FATHOM_OK;
    }
    map.uv_set = (uint32_t)set;
    status = read_texture(g, index, color, &map.texture);
    *there = status == FATHOM_OK && map.texture != FATHOM_NONE;
    if (*there) *out = map;
    return status;
}
