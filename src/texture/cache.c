#include "texture/texture.h"

#include "image/image.h"
#include "image/pack.h"
#include "scene/scene.h"

#include <stdlib.h>

typedef struct plain {
    const fathom_texture *texture;
    const image *img;
} plain;

struct texture_cache {
    size_t count;
    plain items[];
};

void texture_cache_close(texture_cache *cache) {
    for (size_t i = 0; cache && i < cache->count; ++i) image_release(cache->items[i].img);
    free(cache);
}

fathom_status texture_cache_open(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                 texture_cache **out) {
    const size_t count = scene->textures.count, bytes = sizeof **out + count * sizeof(plain);
    fathom_status status = FATHOM_OK;
    (void)limit;
    *out = calloc(1, bytes);
    if (!*out) return fail_memory(context, bytes);
    (*out)->count = count;
    for (size_t i = 0; status == FATHOM_OK && i < count; ++i) {
        plain *p = &(*out)->items[i];
        p->texture = &scene->textures.items[i];
        if (!p->texture->file) return fail(context, FATHOM_INTERNAL, "bytes are not read yet");
        status = image_read(context, p->texture->file, &p->img);
    }
    if (status == FATHOM_OK) return status;
    texture_cache_close(*out);
    *out = NULL;
    return status;
}

static double decoded(const plain *p, double value, int channel) {
    if (p->texture->color_space != FATHOM_COLOR_SRGB || channel == 3) return value;
    return value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4);
}

static float texel(const plain *p, long x, long y, int c) {
    const image *img = p->img;
    const size_t channels = img->channel_count;
    const size_t at = channels < 3 ? (c == 3 ? 1 : 0) : (size_t)c;
    if (at >= channels) return 1;
    const image_channel *channel = &img->channels[at];
    float value;
    memcpy(&value, (const char *)channel->data + ((size_t)y * img->width + (size_t)x) * channel->stride,
           sizeof value);
    return (float)decoded(p, (double)value, c);
}

static long wrapped(double at, long size, fathom_wrap mode) {
    long i = (long)floor(at);
    if (mode == FATHOM_WRAP_CLAMP) return i < 0 ? 0 : i >= size ? size - 1 : i;
    const long period = mode == FATHOM_WRAP_MIRROR ? 2 * size : size;
    i = ((i % period) + period) % period;
    return i < size ? i : period - 1 - i;
}

static float look(const plain *p, double u, double v, int c) {
    const long w = (long)p->img->width, h = (long)p->img->height;
    const double x = u * (double)w - 0.5, y = v * (double)h - 0.5, a = x - floor(x), b = y - floor(y);
    const long x0 = wrapped(x, w, p->texture->wrap_u), x1 = wrapped(x + 1, w, p->texture->wrap_u);
    const long y0 = wrapped(y, h, p->texture->wrap_v), y1 = wrapped(y + 1, h, p->texture->wrap_v);
    const double top = (1 - a) * (double)texel(p, x0, y0, c) + a * (double)texel(p, x1, y0, c);
    const double low = (1 - a) * (double)texel(p, x0, y1, c) + a * (double)texel(p, x1, y1, c);
    return (float)((1 - b) * top + b * low);
}

void texture_lookup(texture_cache *cache, const texture_queries *q, float rgba[4][TEXTURE_BLOCK]) {
    for (unsigned i = 0; i < q->count; ++i) {
        for (int c = 0; c < 4; ++c)
            rgba[c][i] = look(&cache->items[q->texture[i]], (double)q->u[i], (double)q->v[i], c);
    }
}

fathom_status texture_cache_check(texture_cache *cache, fathom_context *context) {
    (void)cache, (void)context;
    return FATHOM_OK;
}

void texture_size(const texture_cache *cache, fathom_id texture, uint32_t *width, uint32_t *height) {
    const image *img = cache->items[texture].img;
    *width = img->width, *height = img->height;
}

fathom_status texture_average(texture_cache *cache, fathom_context *context, fathom_id texture,
                              float rgba[4]) {
    const plain *p = &cache->items[texture];
    const long w = (long)p->img->width, h = (long)p->img->height;
    (void)context;
    for (int c = 0; c < 4; ++c) {
        double sum = 0;
        for (long i = 0; i < w * h; ++i) sum += (double)texel(p, i % w, i / w, c);
        rgba[c] = (float)(sum / (double)(w * h));
    }
    return FATHOM_OK;
}

fathom_status texture_is_opaque(texture_cache *cache, fathom_context *context, fathom_id texture, bool *out) {
    const size_t channels = cache->items[texture].img->channel_count;
    (void)context;
    *out = channels == 1 || channels == 3;
    return FATHOM_OK;
}
