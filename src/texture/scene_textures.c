/* The textures of a scene. */
#include "base/hash.h"
#include "base/sized.h"
#include "image/helper/helper.h"
#include "scene/scene.h"
#include "texture/texture.h"

#include <stdlib.h>
#include <string.h>

SIZED_DEFAULT_OWN(fathom_texture, {.filter = FATHOM_TEXTURE_TRILINEAR})

static fathom_status check(fathom_context *context, const fathom_texture *t) {
    if (!t->file == !t->bytes)
        return fail_field(context, FATHOM_BAD_USAGE, "texture", "expected either a file or bytes");
    if (t->bytes && !t->byte_count)
        return fail_field(context, FATHOM_BAD_INPUT, t->name ? t->name : "texture",
                          "expected an image, found no bytes");
    if ((unsigned)t->color_space > FATHOM_COLOR_NAMED)
        return fail_field(context, FATHOM_BAD_USAGE, "color_space", "there is no color space %u",
                          (unsigned)t->color_space);
    if (t->color_space == FATHOM_COLOR_NAMED && (!t->color_space_name || !*t->color_space_name))
        return fail_field(context, FATHOM_BAD_USAGE, "color_space_name",
                          "expected the name of a color space");
    if ((unsigned)t->wrap_u > FATHOM_WRAP_CLAMP || (unsigned)t->wrap_v > FATHOM_WRAP_CLAMP)
        return fail_field(context, FATHOM_BAD_USAGE, "wrap_u", "there is no wrap mode %u",
                          (unsigned)(t->wrap_u > t->wrap_v ? t->wrap_u : t->wrap_v));
    if ((unsigned)t->filter > FATHOM_TEXTURE_STOCHASTIC)
        return fail_field(context, FATHOM_BAD_USAGE, "filter", "there is no filter %u", (unsigned)t->filter);
    if (t->bytes) return FATHOM_OK;
    file_map map;
    fathom_status status = file_open(context, t->file, &map);
    if (status == FATHOM_OK) file_close(&map);
    return status;
}

static bool same_text(const char *a, const char *b) { return a == b || (a && b && strcmp(a, b) == 0); }

static bool same(const fathom_texture *a, const fathom_texture *b) {
    return same_text(a->file, b->file) && a->byte_count == b->byte_count &&
           (!a->bytes || memcmp(a->bytes, b->bytes, a->byte_count) == 0) &&
           a->color_space == b->color_space && same_text(a->color_space_name, b->color_space_name) &&
           a->wrap_u == b->wrap_u && a->wrap_v == b->wrap_v && a->filter == b->filter;
}

/* Replaces *data by a copy that the scene owns; NULL stays NULL. */
static fathom_status keep(fathom_scene *scene, const void **data, size_t bytes) {
    void *copy;
    if (!*data) return FATHOM_OK;
    fathom_status status = scene_allocate(scene, bytes, &copy);
    if (status != FATHOM_OK) return status;
    memcpy(copy, *data, bytes);
    *data = copy;
    return FATHOM_OK;
}

static fathom_status keep_text(fathom_scene *scene, const char **text) {
    const void *data = *text;
    fathom_status status = keep(scene, &data, *text ? strlen(*text) + 1 : 0);
    *text = data;
    return status;
}

fathom_status fathom_scene_add_texture(fathom_scene *scene, const fathom_texture *texture, fathom_id *out) {
    if (!scene) return FATHOM_BAD_USAGE;
    fathom_texture t;
    fathom_status status = SIZED_OWN(scene->context, fathom_texture, texture, &t);
    if (status == FATHOM_OK) status = check(scene->context, &t);
    if (t.file) t.byte_count = 0;
    for (size_t i = 0; status == FATHOM_OK && i < scene->textures.count; ++i) {
        if (!same(&scene->textures.items[i], &t)) continue;
        if (out) *out = (fathom_id)i;
        return FATHOM_OK;
    }
    if (status == FATHOM_OK) status = keep_text(scene, &t.file);
    if (status == FATHOM_OK) status = keep_text(scene, &t.mime);
    if (status == FATHOM_OK) status = keep_text(scene, &t.name);
    if (status == FATHOM_OK) status = keep_text(scene, &t.color_space_name);
    if (status == FATHOM_OK) status = keep(scene, &t.bytes, t.byte_count);
    if (status != FATHOM_OK) return status;
    if (!array_push(&scene->textures, t)) return fail_memory(scene->context, sizeof t);
    if (out) *out = (fathom_id)(scene->textures.count - 1);
    return FATHOM_OK;
}

/* The color space of texture i if no earlier texture has it; otherwise NULL. */
static const char *new_space(const fathom_scene *scene, size_t i) {
    const fathom_texture *all = scene->textures.items;
    if (all[i].color_space != FATHOM_COLOR_NAMED) return NULL;
    for (size_t k = 0; k < i; ++k) {
        if (same_text(all[k].color_space_name, all[i].color_space_name)) return NULL;
    }
    return all[i].color_space_name;
}

uint64_t texture_color_files(const fathom_scene *scene) {
    const image_view_request request = {.config = getenv("OCIO")};
    uint64_t all = 0;
    if (!request.config || !*request.config) return 0;
    for (size_t i = 0; i < scene->textures.count; ++i) {
        image_message why = {""};
        const char *space = new_space(scene, i);
        uint64_t files = 0;
        if (space) image_calls.view_files(&request, space, &files, &why);
        if (files) all = hash_of((uint64_t[]){all, files}, 2 * sizeof files);
    }
    return all;
}
