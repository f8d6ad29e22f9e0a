/* What the image helper says of images and textures, as the library reads it. */
#include "fuzz.h"

#include "image/helper/wire.h"
#include "texture/pyramid.h"

#include <fathom/texture.h>
#include <stdlib.h>
#include <string.h>

static void read_image(const uint8_t *data, size_t size) {
    wire_cursor c = {data, data + size, false};
    wire_image w;
    if (!wire_take_image(&c, &w)) return;
    size_t bytes = 0;
    for (size_t i = 0; i < w.img.channel_count; ++i) bytes += strlen(w.channels[i].name);
    for (size_t i = 0; i < w.img.attribute_count; ++i) {
        const image_attribute *a = &w.attributes[i];
        bytes += strlen(a->name) + (a->text ? strlen(a->text) : 0);
    }
    if (bytes > size) fuzz_wrong("%zu bytes of texts in %zu bytes", bytes, size);
    wire_image_free(&w);
}

static void plan(const image_texture_info *info) {
    pyramid p;
    pyramid_plan(&p, info->width, info->height, info->channels == 1 ? 1 : 4, info->kept, info->sent);
    const pyramid_level *last = &p.levels[p.count - 1];
    if (last->width != 1 || last->height != 1)
        fuzz_wrong("%u x %u: no last level", info->width, info->height);
    for (unsigned i = 0; i < p.count; ++i) {
        const pyramid_level *l = &p.levels[i];
        const uint64_t texels = (uint64_t)l->width * l->height;
        const uint64_t room = pyramid_part_bytes(&p, i < p.tail ? i : p.tail);
        if (l->offset + (texels << l->shift) > room) fuzz_wrong("level %u lies beyond its part", i);
    }
}

static bool read_level(void *user, uint64_t offset, const void *bytes, size_t size) {
    const pyramid *p = user;
    const unsigned char *from = bytes;
    unsigned any = 0;
    for (size_t i = 0; i < size; ++i) any |= from[i];
    if (offset + size > p->tail_bytes) fuzz_wrong("a level is written beyond the image");
    return any <= 255;
}

/* Images of bytes and of 16 bits; linear. */
static const float *table_of(image_texel type) {
    static float tables[2][65536];
    if (type > IMAGE_TEXEL_U16) return NULL;
    float *table = tables[type == IMAGE_TEXEL_U16];
    if (!(table[1] > 0)) pyramid_fill_table(table, type, false);
    return table;
}

enum { SIDE = PYRAMID_TILE }; /* such images are all tail */

/* The levels of a small image of which the rows are bytes as they come. */
static void make_levels(const image_texture_info *info, const uint8_t *data, size_t size) {
    const bool codes = info->sent <= IMAGE_TEXEL_U16;
    const size_t bytes = (size_t)info->width * info->channels * image_texel_size(info->sent);
    _Alignas(16) unsigned char row[SIDE * 4 * sizeof(float)];
    float least;
    pyramid p;
    if (info->width > SIDE || info->height > SIDE || bytes * info->height > size) return;
    pyramid_plan(&p, info->width, info->height, info->channels == 1 ? 1 : 4, info->sent,
                 codes ? IMAGE_TEXEL_HALF : info->sent);
    const pyramid_decoding d = {info->channels, info->sent, false, table_of(info->sent),
                                table_of(info->sent)};
    pyramid_builder *b = pyramid_builder_open(&p, &d, read_level, &p);
    size_t bad = 0;
    bool fine = b != NULL;
    for (uint32_t y = 0; fine && y < info->height; ++y) {
        memcpy(row, data + y * bytes, bytes);
        fine = pyramid_builder_row(b, row, &bad);
    }
    if (b && !fine && (codes || bad >= (size_t)info->width * p.channels))
        fuzz_wrong("a row of type %d is refused", (int)info->sent);
    pyramid_builder_close(b, &least);
}

static void read_texture(const uint8_t *data, size_t size) {
    wire_cursor c = {data, data + size, false};
    image_texture_info info, again;
    if (!wire_take_texture(&c, &info)) return;
    wire_buffer b = {NULL, 0, 0, false};
    wire_put_texture(&b, &info);
    wire_cursor second = {b.items, b.items + b.count, false};
    if (!wire_take_texture(&second, &again) || again.width != info.width || again.height != info.height ||
        again.band != info.band || again.mipmapped != info.mipmapped || again.integers != info.integers ||
        strcmp(again.format, info.format) != 0)
        fuzz_wrong("a description is not read as it was written");
    free(b.items);
    if (info.width <= FATHOM_TEXTURE_SIDE && info.height <= FATHOM_TEXTURE_SIDE) plan(&info);
    make_levels(&info, c.at, (size_t)(c.end - c.at));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_begin(size, 16);
    read_image(data, size);
    read_texture(data, size);
    fuzz_end();
    return 0;
}
