/* Decodes images with the helper, and writes their tiles to the store. */
#include "base/file.h"
#include "image/helper/helper.h"
#include "texture/cache.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Bytes of rows per request. */
#define BAND_BYTES ((size_t)4 << 20)

/* ---- sources ---- */

fathom_status cache_open_source(const texture_cache *cache, const fathom_texture *t, image_texture **out,
                                image_texture_info *info, image_message *why) {
    image_texture_request request = {.path = t->file,
                                     .descriptor = -1,
                                     .config = cache->config,
                                     .most_side = FATHOM_TEXTURE_SIDE,
                                     .most_texels = FATHOM_TEXTURE_TEXELS,
                                     .threads = cache->threads,
                                     .helpers = cache->helpers};
    if (t->color_space == FATHOM_COLOR_NAMED) request.space = t->color_space_name;
    if (!t->file && (request.descriptor = file_in_memory(t->bytes, t->byte_count)) < 0) {
        snprintf(why->text, sizeof why->text, "out of memory");
        return FATHOM_OUT_OF_RESOURCES;
    }
    const fathom_status status = image_calls.texture.open(&request, out, info, why);
    if (!t->file) close(request.descriptor);
    return status;
}

void cache_close_source(cache_image *img) {
    if (img->source) image_calls.texture.close(img->source);
    img->source = NULL;
}

/* Adds an open file. If there are too many, closes the one that was opened first and is not being read. */
static void remember_source(texture_cache *cache, cache_image *img) {
    pthread_mutex_lock(&cache->lock);
    for (unsigned tries = 0; tries < CACHE_OPEN; ++tries) {
        cache_image **place = &cache->open[cache->next_open++ % CACHE_OPEN], *old = *place;
        if (old && pthread_mutex_trylock(&old->lock) != 0) continue;
        *place = img;
        if (old) {
            cache_close_source(old);
            pthread_mutex_unlock(&old->lock);
        }
        break;
    }
    pthread_mutex_unlock(&cache->lock);
}

/* The caller holds the image's lock. */
static fathom_status reopen(texture_cache *cache, cache_image *img, image_message *why) {
    image_texture_info again;
    if (img->source) return FATHOM_OK;
    const fathom_status status = cache_open_source(cache, img->texture, &img->source, &again, why);
    if (status != FATHOM_OK) return status;
    if (memcmp(&again.width, &img->info.width, 2 * sizeof again.width) != 0 ||
        again.channels != img->info.channels || again.sent != img->info.sent ||
        again.mipmapped != img->info.mipmapped) {
        cache_close_source(img);
        snprintf(why->text, sizeof why->text, "was changed while it was in use");
        return FATHOM_BAD_INPUT;
    }
    remember_source(cache, img);
    return FATHOM_OK;
}

static void forget_source(texture_cache *cache, cache_image *img) {
    pthread_mutex_lock(&cache->lock);
    for (unsigned i = 0; i < CACHE_OPEN; ++i) {
        if (cache->open[i] == img) cache->open[i] = NULL;
    }
    pthread_mutex_unlock(&cache->lock);
    cache_close_source(img);
}

/* Tries again if the helper ended, because another file may be the cause. */
static fathom_status read_region(texture_cache *cache, cache_image *img, const image_region *r, void *texels,
                                 size_t bytes, image_message *why) {
    fathom_status status = reopen(cache, img, why);
    if (status == FATHOM_OK) status = image_calls.texture.read(img->source, r, texels, bytes, why);
    if (status != FATHOM_OUT_OF_RESOURCES) return status;
    forget_source(cache, img);
    why->text[0] = '\0';
    status = reopen(cache, img, why);
    return status == FATHOM_OK ? image_calls.texture.read(img->source, r, texels, bytes, why) : status;
}

/* ---- filling the store ---- */

typedef struct filling {
    texture_cache *cache;
    cache_image *img;
    image_message why;
} filling;

static bool write_tiles(void *user, uint64_t offset, const void *bytes, size_t size) {
    filling *f = user;
    store *s = &f->cache->store;
    if (store_write(s, offset, bytes, size)) return true;
    snprintf(f->why.text, sizeof f->why.text, "its tiles cannot be kept: %s%s", strerror(errno),
             offset >= s->kept ? "; name a larger folder in $TMPDIR" : "");
    return false;
}

static size_t sent_bytes(const cache_image *img, size_t texels) {
    return texels * img->info.channels * image_texel_size(img->info.sent);
}

static fathom_status bad_texel(filling *f, unsigned level, uint32_t x, uint32_t y, size_t channel) {
    static const char *const names[] = {"R", "G", "B", "A"};
    char where[32] = "";
    if (level) snprintf(where, sizeof where, " of mip level %u", level);
    snprintf(f->why.text, sizeof f->why.text,
             "texel (%u, %u)%s, counted from the top left, is not finite in channel %s; expected numbers", x,
             y, where, f->img->plan.channels == 1 ? "Y" : names[channel]);
    return FATHOM_BAD_INPUT;
}

static fathom_status build_rows(filling *f, pyramid_builder *b, const unsigned char *rows, uint32_t y0,
                                uint32_t y1) {
    for (uint32_t y = y0; y < y1; ++y) {
        size_t bad;
        const unsigned char *row = rows + sent_bytes(f->img, (size_t)(y - y0) * f->img->info.width);
        if (pyramid_builder_row(b, row, &bad)) continue;
        if (bad == SIZE_MAX) return FATHOM_OUT_OF_RESOURCES;
        const unsigned channels = f->img->plan.channels;
        return bad_texel(f, 0, (uint32_t)(bad / channels), y, bad % channels);
    }
    return FATHOM_OK;
}

static fathom_status read_rows(filling *f, image_texture *source, pyramid_builder *b) {
    const image_texture_info *info = &f->img->info;
    const size_t row = sent_bytes(f->img, info->width);
    uint32_t band = info->band, at_once = (uint32_t)(BAND_BYTES / row / band) * band;
    if (at_once < band) at_once = band;
    if (at_once > info->height) at_once = info->height;
    unsigned char *rows = malloc(row * at_once);
    fathom_status status = rows ? FATHOM_OK : FATHOM_OUT_OF_RESOURCES;
    for (uint32_t y = 0; status == FATHOM_OK && y < info->height; y += at_once) {
        const uint32_t end = info->height - y < at_once ? info->height : y + at_once;
        const image_region r = {.x1 = info->width, .y0 = y, .y1 = end};
        status = image_calls.texture.read(source, &r, rows, row * (end - y), &f->why);
        if (status == FATHOM_OK) status = build_rows(f, b, rows, y, end);
    }
    free(rows);
    return status;
}

/* Marks the part's chunks as present in the store. */
static void fill_part(const filling *f, unsigned part) {
    const pyramid *p = &f->img->plan;
    const uint64_t end = p->levels[part].offset + pyramid_part_bytes(p, part);
    for (uint64_t at = p->levels[part].offset; at < end; at += PYRAMID_CHUNK)
        store_fill(&f->cache->store, at >> PYRAMID_CHUNK_SHIFT);
}

/* Decodes the whole image and makes its levels. */
static fathom_status fill_all(filling *f) {
    cache_image *img = f->img;
    image_texture *source;
    image_texture_info again;
    fathom_status status = cache_open_source(f->cache, img->texture, &source, &again, &f->why);
    if (status != FATHOM_OK) return status;
    if (again.width != img->info.width || again.height != img->info.height ||
        again.channels != img->info.channels || again.sent != img->info.sent) {
        snprintf(f->why.text, sizeof f->why.text, "was changed while it was in use");
        status = FATHOM_BAD_INPUT;
    }
    pyramid_builder *b = NULL;
    if (status == FATHOM_OK) {
        b = pyramid_builder_open(&img->plan, &img->decoding, write_tiles, f);
        status = b ? read_rows(f, source, b) : FATHOM_OUT_OF_RESOURCES;
    }
    pyramid_builder_close(b, &img->least_alpha);
    image_calls.texture.close(source);
    for (unsigned i = 0; status == FATHOM_OK && i <= img->plan.tail; ++i) fill_part(f, i);
    if (status == FATHOM_OK) __atomic_store_n(&img->decoded, true, __ATOMIC_RELEASE);
    return status;
}

/* Reads tiles of a mip-mapped file: [x0, x1) × [y0, y1) texels, in one row of tiles. */
static fathom_status fill_region(filling *f, const image_region *r) {
    cache_image *img = f->img;
    const pyramid_level *l = &img->plan.levels[r->level];
    const uint32_t width = r->x1 - r->x0, height = r->y1 - r->y0;
    const size_t texels = (size_t)width * height, bytes = sent_bytes(img, texels);
    const size_t tile = (size_t)l->stride * (l->stride < PYRAMID_TILE ? height : PYRAMID_TILE) << l->shift;
    void *sent = malloc(bytes);
    float *linear = malloc(texels * img->plan.channels * sizeof *linear);
    unsigned char *kept = calloc((width + PYRAMID_TILE - 1) / PYRAMID_TILE, tile);
    fathom_status status = sent && linear && kept ? FATHOM_OK : FATHOM_OUT_OF_RESOURCES;
    if (status == FATHOM_OK) status = read_region(f->cache, img, r, sent, bytes, &f->why);
    if (status == FATHOM_OK) {
        pyramid_decode(&img->plan, &img->decoding, sent, texels, linear);
        const size_t bad = pyramid_find_bad(linear, texels * img->plan.channels),
                     at = bad / img->plan.channels;
        if (at < texels)
            status = bad_texel(f, r->level, r->x0 + (uint32_t)(at % width), r->y0 + (uint32_t)(at / width),
                               bad % img->plan.channels);
    }
    for (uint32_t y = 0; status == FATHOM_OK && y < height; ++y) {
        for (uint32_t x = 0; x < width; x += PYRAMID_TILE) {
            const size_t from = (size_t)y * width + x,
                         count = width - x < PYRAMID_TILE ? width - x : PYRAMID_TILE;
            pyramid_keep(&img->plan, l, &img->decoding, (char *)sent + sent_bytes(img, from),
                         linear + from * img->plan.channels, count,
                         kept + x / PYRAMID_TILE * tile + ((size_t)y * l->stride << l->shift));
        }
    }
    const uint64_t index = (uint64_t)r->y0 / PYRAMID_TILE * l->across + r->x0 / PYRAMID_TILE;
    if (status == FATHOM_OK && !write_tiles(f, l->offset + ((index * PYRAMID_TILE_TEXELS) << l->shift), kept,
                                            (width + PYRAMID_TILE - 1) / PYRAMID_TILE * tile))
        status = FATHOM_OUT_OF_RESOURCES;
    free(sent), free(linear), free(kept);
    return status;
}

static fathom_status fill_tail(filling *f) {
    const pyramid *p = &f->img->plan;
    fathom_status status = FATHOM_OK;
    for (unsigned i = p->tail; status == FATHOM_OK && i < p->count; ++i)
        status = fill_region(f, &(image_region){i, 0, 0, p->levels[i].width, p->levels[i].height});
    if (status == FATHOM_OK) fill_part(f, p->tail);
    return status;
}

/* Reads the tiles of one chunk of a mip-mapped file. */
static fathom_status fill_chunk(filling *f, uint64_t chunk) {
    const pyramid *p = &f->img->plan;
    const uint64_t at = chunk << PYRAMID_CHUNK_SHIFT;
    fathom_status status = FATHOM_OK;
    unsigned i = 0;
    while (i < p->tail && at - p->levels[i].offset >= pyramid_part_bytes(p, i)) ++i;
    if (i == p->tail) return fill_tail(f);
    const pyramid_level *l = &p->levels[i];
    const uint64_t tile = (uint64_t)PYRAMID_TILE_TEXELS << l->shift, first = (at - l->offset) / tile;
    const uint64_t end = first + PYRAMID_CHUNK / tile;
    for (uint64_t t = first; status == FATHOM_OK && t < end;) {
        const uint32_t x = (uint32_t)(t % l->across), y = (uint32_t)(t / l->across) * PYRAMID_TILE;
        const uint64_t in_row = l->across - x < end - t ? l->across - x : end - t;
        if (y >= l->height) break;
        const uint32_t x1 = (x + (uint32_t)in_row) * PYRAMID_TILE, y1 = y + PYRAMID_TILE;
        status = fill_region(f, &(image_region){i, x * PYRAMID_TILE, y, x1 < l->width ? x1 : l->width,
                                                y1 < l->height ? y1 : l->height});
        t += in_row;
    }
    if (status == FATHOM_OK) store_fill(&f->cache->store, chunk);
    return status;
}

static void keep_failure(texture_cache *cache, cache_image *img, fathom_status status,
                         const image_message *why) {
    pthread_mutex_lock(&cache->lock);
    if (cache->status == FATHOM_OK) {
        cache->failed = img;
        cache->why = *why;
        if (!why->text[0]) snprintf(cache->why.text, sizeof cache->why.text, "out of memory");
        __atomic_store_n(&cache->status, status, __ATOMIC_RELEASE);
    }
    pthread_mutex_unlock(&cache->lock);
    __atomic_store_n(&img->broken, true, __ATOMIC_RELEASE);
}

static bool is_broken(const cache_image *img) { return __atomic_load_n(&img->broken, __ATOMIC_ACQUIRE); }

static bool is_filled(const texture_cache *cache, uint64_t chunk) {
    return __atomic_load_n(&cache->store.filled[chunk], __ATOMIC_ACQUIRE);
}

/* A thread that would wait for an image decodes the next one instead: the same material often uses it. If
 * this fails, the lookup of that image fails again and reports the error. */
static void fill_another(texture_cache *cache, const cache_image *busy) {
    for (cache_image *img = cache->images; img < cache->images + cache->image_count; ++img) {
        if (img <= busy || img->info.mipmapped || __atomic_load_n(&img->decoded, __ATOMIC_ACQUIRE) ||
            is_broken(img) || pthread_mutex_trylock(&img->lock) != 0)
            continue;
        filling f = {.cache = cache, .img = img};
        if (!img->decoded) fill_all(&f);
        pthread_mutex_unlock(&img->lock);
        return;
    }
}

bool cache_fill(texture_cache *cache, cache_image *img, uint64_t chunk) {
    if (is_broken(img)) return false;
    if (is_filled(cache, chunk)) return true;
    if (pthread_mutex_trylock(&img->lock) != 0) {
        if (cache->helpers > 1 && !img->info.mipmapped) fill_another(cache, img);
        pthread_mutex_lock(&img->lock);
    }
    filling f = {.cache = cache, .img = img};
    fathom_status status = FATHOM_OK;
    if (!is_broken(img) && !is_filled(cache, chunk))
        status = img->info.mipmapped ? fill_chunk(&f, chunk) : fill_all(&f);
    if (status != FATHOM_OK) keep_failure(cache, img, status, &f.why);
    pthread_mutex_unlock(&img->lock);
    return !is_broken(img);
}

/* Reads the texels from the file. If they are close together, one read gets them all: the texels of a filter
 * are mostly in one tile. */
static bool copy_texels(const store *s, const uint64_t *places, unsigned count, size_t size, cache_copy *copy,
                        const unsigned char **at) {
    uint64_t low = places[0], high = places[0];
    for (unsigned i = 1; i < count; ++i) {
        low = places[i] < low ? places[i] : low;
        high = places[i] > high ? places[i] : high;
    }
    const bool close = high - low + size <= sizeof copy->bytes;
    for (unsigned i = 0; i < count; ++i) {
        at[i] = copy->bytes + (close ? places[i] - low : i * size);
        if (!close && !store_read(s, places[i], copy->bytes + i * size, size)) return false;
    }
    return !close || store_read(s, low, copy->bytes, high - low + size);
}

bool cache_fetch(texture_cache *cache, cache_image *img, const uint64_t *places, unsigned count, size_t size,
                 unsigned lookups, cache_copy *copy, const unsigned char **at) {
    store *s = &cache->store;
    bool mapped = true;
    for (unsigned i = 0; i < count; ++i) {
        const uint64_t chunk = places[i] >> PYRAMID_CHUNK_SHIFT;
        if (!cache_fill(cache, img, chunk)) return false;
        const bool again = i > 0 && chunk == places[i - 1] >> PYRAMID_CHUNK_SHIFT;
        if (!again) mapped &= store_admit(s, chunk, lookups);
    }
    if (!mapped && copy_texels(s, places, count, size, copy, at)) return true;
    for (unsigned i = 0; i < count; ++i) at[i] = s->bytes + places[i];
    return true;
}
