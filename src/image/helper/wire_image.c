#include "image/helper/wire_image.h"

#include <stdlib.h>
#include <string.h>

static void put_channel(wire_buffer *b, const image_channel *channel, image_storage storage) {
    wire_put_text(b, channel->name);
    wire_put_u32(b, channel->type);
    wire_put_u32(b, channel->color);
    wire_put_u32(b, storage);
}

void wire_put_image(wire_buffer *b, const image *img, const image_storage *storage) {
    const uint32_t sizes[6] = {img->width, img->height, img->x, img->y, img->full_width, img->full_height};
    for (int i = 0; i < 6; ++i) wire_put_u32(b, sizes[i]);
    wire_put_u32(b, (uint32_t)img->channel_count);
    wire_put_u32(b, (uint32_t)img->attribute_count);
    for (size_t i = 0; i < img->channel_count; ++i)
        put_channel(b, &img->channels[i], storage ? storage[i] : IMAGE_STORE_FLOAT);
    for (size_t i = 0; i < img->attribute_count; ++i) {
        const image_attribute *a = &img->attributes[i];
        wire_put_text(b, a->name);
        wire_put_text(b, a->text);
        wire_put_u32(b, a->text ? 0 : (uint32_t)a->count);
        if (!a->text) wire_put(b, a->numbers, a->count * sizeof *a->numbers);
    }
}

static bool take_channels(wire_cursor *c, wire_image *out) {
    for (size_t i = 0; i < out->img.channel_count; ++i) {
        image_channel *channel = &out->channels[i];
        channel->name = wire_take_text(c);
        channel->type = wire_take_u32(c) == IMAGE_UINT ? IMAGE_UINT : IMAGE_FLOAT;
        channel->color = wire_take_u32(c) != 0;
        uint32_t storage = wire_take_u32(c);
        out->storage[i] = storage <= IMAGE_STORE_UINT ? (image_storage)storage : IMAGE_STORE_FLOAT;
        if (c->bad || !channel->name) return false;
    }
    return true;
}

/* `numbers` has room for all that the memory can hold. */
static bool take_attributes(wire_cursor *c, wire_image *out) {
    double *room = out->numbers;
    for (size_t i = 0; i < out->img.attribute_count; ++i) {
        image_attribute *a = &out->attributes[i];
        a->name = wire_take_text(c);
        a->text = wire_take_text(c);
        a->count = wire_take_u32(c);
        const void *numbers = wire_take(c, a->count * sizeof *room);
        if (c->bad || !a->name) return false;
        if (a->count) memcpy(room, numbers, a->count * sizeof *room);
        a->numbers = room;
        room += a->count;
    }
    return true;
}

/* A channel takes 13 bytes at least, an attribute 12: no more can be announced than there is room for. */
bool wire_take_image(wire_cursor *c, wire_image *out) {
    *out = (wire_image){.storage = NULL};
    image *img = &out->img;
    uint32_t *sizes[6] = {&img->width, &img->height, &img->x, &img->y, &img->full_width, &img->full_height};
    for (int i = 0; i < 6; ++i) *sizes[i] = wire_take_u32(c);
    img->channel_count = wire_take_u32(c);
    img->attribute_count = wire_take_u32(c);
    size_t left = (size_t)(c->end - c->at);
    if (c->bad || img->channel_count > left / 13 || img->attribute_count > left / 12) return false;
    out->channels = calloc(img->channel_count + 1, sizeof *out->channels);
    out->storage = calloc(img->channel_count + 1, sizeof *out->storage);
    out->attributes = calloc(img->attribute_count + 1, sizeof *out->attributes);
    out->numbers = malloc(left + sizeof(double));
    img->channels = out->channels, img->attributes = out->attributes;
    bool there = out->channels && out->storage && out->attributes && out->numbers;
    if (there && take_channels(c, out) && take_attributes(c, out)) return true;
    wire_image_free(out);
    return false;
}

void wire_image_free(wire_image *w) {
    free(w->channels), free(w->storage), free(w->attributes), free(w->numbers);
    *w = (wire_image){.storage = NULL};
}
