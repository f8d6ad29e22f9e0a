#include "image/pack.h"

#include "image/byte.h"
#include "image/half.h"

#include <string.h>

size_t pack_storage_size(image_storage storage) {
    switch (storage) {
    case IMAGE_STORE_U8: return 1;
    case IMAGE_STORE_HALF: return 2;
    case IMAGE_STORE_FLOAT:
    case IMAGE_STORE_UINT: return 4;
    }
    return 0;
}

static const unsigned char *row_of(const image *img, const image_channel *channel, uint32_t y) {
    return (const unsigned char *)channel->data + (size_t)y * img->width * channel->stride;
}

static float load(const unsigned char *from) {
    float value;
    memcpy(&value, from, sizeof value);
    return value;
}

void pack_row(const image_packing *packing, uint32_t y, unsigned char *out) {
    const image *img = packing->img;
    for (size_t c = 0; c < img->channel_count; ++c) {
        const image_channel *channel = &img->channels[c];
        const unsigned char *from = row_of(img, channel, y);
        size_t size = pack_storage_size(packing->storage[c]), step = packing->pixel_bytes;
        for (size_t x = 0; x < img->width; ++x, from += channel->stride) {
            if (size == 2) {
                uint16_t half = half_from_float(load(from));
                memcpy(out + x * step, &half, 2);
            } else {
                memcpy(out + x * step, from, 4); /* floats and unsigned alike */
            }
        }
        out += size;
    }
}

/* What a view is given: views are made for numbers, and some turn infinity into NaN and 1e30 into black. The
 * largest half is white in all of them. */
static float viewable(float value) {
    const float largest = 65504.0f;
    if (!(value > -largest)) return value <= -largest ? -largest : 0.0f; /* NaN is 0 */
    return value < largest ? value : largest;
}

static const image_channel *alpha_of(const image *img) {
    return img->channel_count > 3 ? &img->channels[3] : NULL;
}

static float load_at(const image *img, const image_channel *channel, uint32_t y, size_t x) {
    return load(row_of(img, channel, y) + x * channel->stride);
}

/* Colours as they are without their alpha: it is taken out of light, not out of what the view makes of it.
 * Where alpha is 0 there is nothing to divide by, and the colour is kept. */
static float scale_by(const image_packing *packing, float alpha) {
    return alpha > 0.0f && alpha < 1.0f ? packing->gain / alpha : packing->gain;
}

void pack_row_for_view(const image_packing *packing, uint32_t y, float *rgba) {
    const image *img = packing->img;
    const image_channel *alpha = alpha_of(img);
    for (size_t x = 0; x < img->width; ++x) {
        float scale = scale_by(packing, alpha ? load_at(img, alpha, y, x) : 1.0f);
        for (size_t c = 0; c < 3; ++c)
            rgba[4 * x + c] = viewable(load_at(img, &img->channels[c], y, x) * scale);
        rgba[4 * x + 3] = 1.0f;
    }
}

void pack_row_srgb(const image_packing *packing, uint32_t y, unsigned char *out) {
    const image *img = packing->img;
    const image_channel *alpha = alpha_of(img);
    for (size_t x = 0; x < img->width; ++x) {
        float a = alpha ? load_at(img, alpha, y, x) : 1.0f, scale = scale_by(packing, a);
        for (size_t c = 0; c < 3; ++c)
            *out++ = srgb_code(packing->srgb, load_at(img, &img->channels[c], y, x) * scale);
        if (alpha) *out++ = byte_from_float(a);
    }
}

void pack_row_from_view(const image_packing *packing, uint32_t y, const float *rgba, unsigned char *out) {
    const image *img = packing->img;
    const image_channel *alpha = alpha_of(img);
    for (size_t x = 0; x < img->width; ++x) {
        for (size_t c = 0; c < 3; ++c) *out++ = byte_from_float(rgba[4 * x + c]);
        if (alpha) *out++ = byte_from_float(load_at(img, alpha, y, x));
    }
}
