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
        for (size_t k = 0; !a->text && k < a->count; ++k) bytes += memcmp(&a->numbers[k], "\0", 1) != 0;
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

static void read_texture(const uint8_t *data, size_t size) {
    wire_cursor c = {data, data + size, false};
    image_texture_info info, again;
    if (!wire_take_texture(&c, &info)) return;
    wire_buffer b = {NULL, 0, 0, false};
    wire_put_texture(&b, &info);
    wire_cursor second = {b.items, b.items + b.count, false};
    if (!wire_take_texture(&second, &again) || again.width != info.width || again.height != info.height ||
        again.band != info.band || again.mipmapped != info.mipmapped ||
        strcmp(again.format, info.format) != 0)
        fuzz_wrong("a description is not read as it was written");
    free(b.items);
    if (info.width <= FATHOM_TEXTURE_SIDE && info.height <= FATHOM_TEXTURE_SIDE) plan(&info);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    fuzz_begin(size, 16);
    read_image(data, size);
    read_texture(data, size);
    fuzz_end();
    return 0;
}
