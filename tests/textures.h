/* Texture files of tests, and what caches of them look up. */
#ifndef TESTS_TEXTURES_H
#define TESTS_TEXTURES_H

#include "scene/scene.h"
#include "texture/kernels.h"
#include "unit_folder.h"

enum { ALL = 1000000000 };

/* ---- files ---- */

static unsigned char file_bytes[1 << 20];

static inline size_t put_file(const char *name, const void *header, size_t size, const void *body,
                              size_t more) {
    assert_true(size + more <= sizeof file_bytes);
    memcpy(file_bytes, header, size);
    memcpy(file_bytes + size, body, more);
    unit_write_file(in_folder(name), file_bytes, size + more);
    return size + more;
}

static inline size_t put_ppm(const char *name, unsigned width, unsigned height, const unsigned char *rgb) {
    char header[64];
    snprintf(header, sizeof header, "P6\n%u %u\n255\n", width, height);
    return put_file(name, header, strlen(header), rgb, (size_t)width * height * 3);
}

/* ---- caches ---- */

typedef struct opened {
    fathom_scene *scene;
    texture_cache *cache;
} opened;

static inline fathom_texture texture_of(const char *name, fathom_color_space space) {
    fathom_texture t;
    fathom_texture_default(&t);
    t.file = in_folder(name), t.color_space = space;
    return t;
}

static inline opened open_textures(const fathom_texture *textures, size_t count, uint64_t limit) {
    opened o;
    assert_ok(context, fathom_scene_create(context, &o.scene));
    for (size_t i = 0; i < count; ++i)
        assert_ok(context, fathom_scene_add_texture(o.scene, &textures[i], NULL));
    assert_ok(context, texture_cache_open(context, o.scene, limit, &o.cache));
    return o;
}

static inline void close_textures(opened *o) {
    texture_cache_close(o->cache);
    fathom_scene_destroy(o->scene);
}

static inline void look(texture_cache *cache, fathom_id texture, float u, float v, float width,
                        float rgba[4]) {
    const texture_queries q = {.count = 1, .texture = {texture}, .u = {u}, .v = {v}, .width = {width}};
    float found[4][TEXTURE_BLOCK];
    texture_lookup(cache, &q, found);
    for (int c = 0; c < 4; ++c) rgba[c] = found[c][0];
}

/* Texel (x, y) of a level, by a lookup at its centre with a footprint that is exactly as wide. */
static inline void texel(texture_cache *cache, fathom_id id, unsigned level, unsigned x, unsigned y,
                         float rgba[4]) {
    const pyramid *p = &cache->slots[id].image->plan;
    const uint32_t w = p->levels[0].width, h = p->levels[0].height;
    look(cache, id, ((float)x + 0.5f) / (float)p->levels[level].width,
         ((float)y + 0.5f) / (float)p->levels[level].height, (float)(1u << level) / (float)(w > h ? w : h),
         rgba);
}

#endif
