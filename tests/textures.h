/* Texture files of tests, and what caches of them look up. */
#pragma once

#include "image/image.h"
#include "owned.h"
#include "scene/scene.h"
#include "texture/cache.h"
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

/* TIFF of one row: grey, or R, G, B that are multiplied by A; of 8 or 16 bits. */
static inline void put_tiff(const char *name, uint16_t width, unsigned channels, unsigned bits,
                            const void *texels) {
    enum { ENTRIES = 10, HEADER = 8 + 2 + ENTRIES * 12 + 4 };
    const uint32_t bytes = width * channels * (bits / 8), color = channels > 1;
    /* Width, height, bits, compression, photometric, offset, samples, rows of the strip, its bytes, kind of
     * the fourth sample, which is left out for grey. */
    const uint32_t entries[ENTRIES][2] = {{256, width},     {257, 1},      {258, bits},     {259, 1},
                                          {262, color + 1}, {273, HEADER}, {277, channels}, {278, 1},
                                          {279, bytes},     {338, 1}};
    unsigned char header[HEADER] = {'I', 'I', 42, 0, 8, 0, 0, 0, (unsigned char)(ENTRIES - !color)};
    for (unsigned i = 0; i < header[8]; ++i) {
        unsigned char *e = header + 10 + 12 * i;
        e[0] = (unsigned char)entries[i][0], e[1] = (unsigned char)(entries[i][0] >> 8);
        e[2] = 4, e[4] = 1; /* one number of 32 bits */
        memcpy(e + 8, &entries[i][1], 4);
    }
    put_file(name, header, sizeof header, texels, bytes);
}

/* Floats, by the library's own writer; `half` rounds them. Grey: one plane; else R, G, B and perhaps A. */
static inline void put_image(const char *name, unsigned width, unsigned height, const float *planes,
                             size_t count, bool half) {
    static const char *const names[] = {"R", "G", "B", "A"};
    const size_t texels = (size_t)width * height;
    image_channel channels[4];
    for (size_t c = 0; c < count; ++c)
        channels[c] = (image_channel){names[c], IMAGE_FLOAT, half, planes + c * texels, sizeof(float)};
    const image img = {width, height, 0, 0, width, height, channels, count, NULL, 0, 0};
    fathom_write_options options = default_write_options();
    assert_ok(context, image_write(context, &img, in_folder(name), &options));
}

/* ---- caches ---- */

UNIT_OWNS(cache, texture_cache, texture_cache_close)

typedef struct opened {
    fathom_scene *scene;
    texture_cache *cache;
} opened;

static inline fathom_texture texture_of(const char *name, fathom_color_space space) {
    fathom_texture t = default_texture();
    t.file = in_folder(name), t.color_space = space;
    return t;
}

static inline opened open_textures(const fathom_texture *textures, size_t count, uint64_t limit) {
    opened o = {.scene = new_scene(context)};
    for (size_t i = 0; i < count; ++i)
        assert_ok(context, fathom_scene_add_texture(o.scene, &textures[i], NULL));
    assert_ok(context, texture_cache_open(context, o.scene, limit, &o.cache));
    own_cache(o.cache);
    return o;
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
    const float area = (float)p->levels[0].width * (float)p->levels[0].height;
    look(cache, id, ((float)x + 0.5f) / (float)p->levels[level].width,
         ((float)y + 0.5f) / (float)p->levels[level].height, (float)(1u << level) / sqrtf(area), rgba);
}

/* Writes the texture of file `from` as a mip-mapped one. */
static inline void write_texture(const char *from, fathom_color_space space, const char *to) {
    const fathom_texture t = texture_of(from, space);
    assert_ok(context, fathom_texture_write(context, &t, in_folder(to)));
}

static inline double srgb(double x) { return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4); }

/* Texels of a file of integers, and of the mip-mapped file that is made of it: code / most is decoded as sRGB
 * unless the texture is linear, and alpha never. */
static inline void check_codes(const char *name, const unsigned (*codes)[4], unsigned texels, unsigned most) {
    write_texture(name, FATHOM_COLOR_AUTO, "written.tx");
    const fathom_texture t[3] = {texture_of(name, FATHOM_COLOR_AUTO), texture_of(name, FATHOM_COLOR_LINEAR),
                                 texture_of("written.tx", FATHOM_COLOR_AUTO)};
    opened o = open_textures(t, 3, ALL);
    for (fathom_id id = 0; id < 3; ++id) {
        for (unsigned i = 0; i < texels; ++i) {
            float rgba[4];
            texel(o.cache, id, 0, i, 0, rgba);
            for (int c = 0; c < 4; ++c) {
                const double at = codes[i][c] / (double)most;
                assert_true(rgba[c] == (float)(c < 3 && id != 1 ? srgb(at) : at));
            }
        }
    }
}
