#include "texture/cache.h"

#include "image/helper/helper.h"
#include "scene/scene.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Bytes of rows that are asked for at once. */
#define BAND_BYTES ((size_t)4 << 20)

static const char *name_of(const fathom_texture *texture) {
    return texture->name ? texture->name : texture->file ? texture->file : "(texture in memory)";
}

/* ---- sources ---- */

/* A file in memory with the bytes; -1 without memory. */
static int descriptor_of(const fathom_texture *t) {
    const int descriptor = memfd_create("fathom-texture", MFD_CLOEXEC);
    if (descriptor < 0) return -1;
    store s = {.descriptor = descriptor};
    if (store_write(&s, 0, t->bytes, t->byte_count)) return descriptor;
    close(descriptor);
    return -1;
}

static fathom_status open_source(const texture_cache *cache, const fathom_texture *t, image_texture **out,
                                 image_texture_info *info, image_message *why) {
    image_texture_request request = {.path = t->file,
                                     .descriptor = -1,
                                     .config = cache->config,
                                     .most_side = FATHOM_TEXTURE_SIDE,
                                     .most_texels = FATHOM_TEXTURE_TEXELS,
                                     .threads = cache->threads};
    if (t->color_space == FATHOM_COLOR_NAMED) request.space = t->color_space_name;
    if (!t->file && (request.descriptor = descriptor_of(t)) < 0) {
        snprintf(why->text, sizeof why->text, "out of memory");
        return FATHOM_OUT_OF_RESOURCES;
    }
    const fathom_status status = image_calls.texture.open(&request, out, info, why);
    if (!t->file) close(request.descriptor);
    return status;
}

static void close_source(cache_image *img) {
    if (img->source) image_calls.texture.close(img->source);
    img->source = NULL;
}

/* Under the lock. Files that were open longest are closed for others. */
static fathom_status reopen(texture_cache *cache, cache_image *img, image_message *why) {
    image_texture_info again;
    if (img->source) return FATHOM_OK;
    const fathom_status status = open_source(cache, img->texture, &img->source, &again, why);
    if (status != FATHOM_OK) return status;
    if (memcmp(&again.width, &img->info.width, 2 * sizeof again.width) != 0 ||
        again.channels != img->info.channels || again.sent != img->info.sent ||
        again.mipmapped != img->info.mipmapped) {
        close_source(img);
        snprintf(why->text, sizeof why->text, "was changed while it was in use");
        return FATHOM_BAD_INPUT;
    }
    cache_image **place = &cache->open[cache->next_open++ % CACHE_OPEN];
    if (*place) close_source(*place);
    *place = img;
    return FATHOM_OK;
}

static void forget_source(texture_cache *cache, cache_image *img) {
    for (unsigned i = 0; i < CACHE_OPEN; ++i) {
        if (cache->open[i] == img) cache->open[i] = NULL;
    }
    close_source(img);
}

/* Asks again if the helper has ended, perhaps on behalf of another file. */
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
    if (store_write(f->img->store, f->img->offset + offset, bytes, size)) return true;
    snprintf(f->why.text, sizeof f->why.text, "its tiles cannot be kept: %s%s", strerror(errno),
             f->img->store->dropping ? "; name a larger folder in $TMPDIR" : "");
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

/* Decodes the whole image and makes its levels. */
static fathom_status fill_all(filling *f) {
    cache_image *img = f->img;
    image_texture *source;
    image_texture_info again;
    fathom_status status = open_source(f->cache, img->texture, &source, &again, &f->why);
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
    pyramid_builder_close(b, img->mean, &img->least_alpha);
    image_calls.texture.close(source);
    const uint64_t first = img->offset >> PYRAMID_CHUNK_SHIFT;
    for (uint64_t i = 0; status == FATHOM_OK && i < img->plan.bytes >> PYRAMID_CHUNK_SHIFT; ++i)
        store_fill(img->store, first + i);
    if (status == FATHOM_OK) __atomic_store_n(&img->decoded, true, __ATOMIC_RELEASE);
    return status;
}

/* Tiles of a mip-mapped file: [x0, x1) × [y0, y1) texels, in one row of tiles. */
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
    for (uint64_t at = 0; status == FATHOM_OK && at < p->tail_bytes; at += PYRAMID_CHUNK)
        store_fill(f->img->store, (f->img->offset + at) >> PYRAMID_CHUNK_SHIFT);
    return status;
}

/* The tiles in a chunk of a mip-mapped file. */
static fathom_status fill_chunk(filling *f, uint64_t chunk) {
    const pyramid *p = &f->img->plan;
    const uint64_t at = (chunk << PYRAMID_CHUNK_SHIFT) - f->img->offset;
    fathom_status status = FATHOM_OK;
    if (at < p->tail_bytes) return fill_tail(f);
    unsigned i = 0;
    while (i + 1 < p->tail && p->levels[i + 1].offset <= at) ++i;
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
    if (status == FATHOM_OK) store_fill(f->img->store, chunk);
    return status;
}

/* Under the lock. */
static void keep_failure(texture_cache *cache, cache_image *img, fathom_status status,
                         const image_message *why) {
    if (cache->status == FATHOM_OK) {
        cache->failed = name_of(img->texture);
        cache->why = *why;
        if (!why->text[0]) snprintf(cache->why.text, sizeof cache->why.text, "out of memory");
        __atomic_store_n(&cache->status, status, __ATOMIC_RELEASE);
    }
    __atomic_store_n(&img->broken, true, __ATOMIC_RELEASE);
}

static bool is_broken(const cache_image *img) { return __atomic_load_n(&img->broken, __ATOMIC_ACQUIRE); }

/* Fills the chunk, or all if the image is no mip-mapped file. */
static bool fill(texture_cache *cache, cache_image *img, uint64_t chunk) {
    filling f = {.cache = cache, .img = img};
    pthread_mutex_lock(&cache->lock);
    if (!is_broken(img) && !img->store->filled[chunk]) {
        const fathom_status status = img->info.mipmapped ? fill_chunk(&f, chunk) : fill_all(&f);
        if (status != FATHOM_OK) keep_failure(cache, img, status, &f.why);
    }
    pthread_mutex_unlock(&cache->lock);
    return !is_broken(img);
}

bool cache_touch(texture_cache *cache, cache_image *img, uint64_t chunk) {
    if (is_broken(img)) return false;
    if (!__atomic_load_n(&img->store->filled[chunk], __ATOMIC_ACQUIRE) && !fill(cache, img, chunk))
        return false;
    if (img->store->dropping) store_admit(img->store, chunk);
    return true;
}

/* ---- opening ---- */

static bool same_image(const fathom_texture *a, const fathom_texture *b) {
    if (a->color_space != b->color_space || !a->file != !b->file || a->byte_count != b->byte_count)
        return false;
    if (a->color_space == FATHOM_COLOR_NAMED && strcmp(a->color_space_name, b->color_space_name) != 0)
        return false;
    return a->file ? strcmp(a->file, b->file) == 0 : memcmp(a->bytes, b->bytes, a->byte_count) == 0;
}

static cache_image *find_image(texture_cache *cache, const fathom_texture *t) {
    for (size_t i = 0; i < cache->image_count; ++i) {
        if (same_image(cache->images[i].texture, t)) return &cache->images[i];
    }
    return NULL;
}

static const float *table_of(texture_cache *cache, image_texel type, bool srgb) {
    const unsigned wide = type == IMAGE_TEXEL_U16;
    float **table = &cache->tables[wide][srgb];
    if (type > IMAGE_TEXEL_U16 || *table) return *table;
    *table = malloc((wide ? 65536 : 256) * sizeof **table);
    if (*table) pyramid_fill_table(*table, type, srgb);
    return *table;
}

/* Smaller levels are means, which have more digits than the texels that they come from. */
static image_texel type_of_means(const image_texture_info *info) {
    if (info->mipmapped) return info->kept;
    return info->kept == IMAGE_TEXEL_U8 || info->kept == IMAGE_TEXEL_HALF ? IMAGE_TEXEL_HALF
                                                                          : IMAGE_TEXEL_FLOAT;
}

static fathom_status plan_image(texture_cache *cache, fathom_context *context, cache_image *img) {
    const image_texture_info *info = &img->info;
    const bool srgb = img->texture->color_space == FATHOM_COLOR_SRGB;
    if (info->width > FATHOM_TEXTURE_SIDE || info->height > FATHOM_TEXTURE_SIDE)
        return fail_file(context, FATHOM_BAD_INPUT, name_of(img->texture),
                         "expected at most %u texels on a side", FATHOM_TEXTURE_SIDE);
    pyramid_plan(&img->plan, info->width, info->height, info->channels == 1 ? 1 : 4, info->kept,
                 type_of_means(info));
    img->decoding = (pyramid_decoding){.sent_channels = info->channels,
                                       .sent = info->sent,
                                       .srgb = srgb,
                                       .color = table_of(cache, info->sent, srgb),
                                       .alpha = table_of(cache, info->sent, false)};
    img->least_alpha = 1;
    if (info->sent <= IMAGE_TEXEL_U16 && (!img->decoding.color || !img->decoding.alpha))
        return fail_memory(context, 65536 * sizeof(float));
    return FATHOM_OK;
}

/* A declared type that is wrong: the content decides. */
static void check_mime(fathom_context *context, const fathom_texture *t, const char *format) {
    static const char *const known[][2] = {
        {"image/png", "png"}, {"image/jpeg", "jpeg"}, {"image/webp", "webp"}, {"image/x-exr", "openexr"}};
    for (size_t i = 0; t->mime && i < sizeof known / sizeof *known; ++i) {
        if (strcmp(t->mime, known[i][0]) == 0 && strcmp(format, known[i][1]) != 0)
            warn(context, "%s: is declared as %s, and read as %s, which it is", name_of(t), t->mime, format);
    }
}

static fathom_status open_image(texture_cache *cache, fathom_context *context, const fathom_texture *t,
                                cache_image **out) {
    cache_image *img = *out = &cache->images[cache->image_count];
    image_message why = {""};
    img->texture = t;
    fathom_status status = open_source(cache, t, &img->source, &img->info, &why);
    if (status != FATHOM_OK)
        return fail_file(context, status == FATHOM_BAD_USAGE ? FATHOM_BAD_INPUT : status, name_of(t),
                         "cannot be read as a texture: %s", why.text[0] ? why.text : "out of memory");
    close_source(img);
    ++cache->image_count;
    check_mime(context, t, img->info.format);
    return plan_image(cache, context, img);
}

/* Images go to memory in their order, up to three quarters of the limit; the disk has the others, and the
 * remaining quarter to show them. */
static fathom_status place_images(texture_cache *cache, fathom_context *context, uint64_t limit) {
    uint64_t sizes[2] = {0, 0};
    for (size_t i = 0; i < cache->image_count; ++i) {
        cache_image *img = &cache->images[i];
        const bool disk = sizes[0] + img->plan.bytes > limit / 4 * 3;
        img->store = disk ? &cache->disk : &cache->memory;
        img->offset = sizes[disk];
        sizes[disk] += img->plan.bytes;
    }
    fathom_status status = store_open(context, sizes[0], 0, &cache->memory);
    if (status == FATHOM_OK) status = store_open(context, sizes[1], limit - sizes[0], &cache->disk);
    return status;
}

static fathom_status open_all(texture_cache *cache, fathom_context *context, const fathom_scene *scene) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; status == FATHOM_OK && i < cache->count; ++i) {
        const fathom_texture *t = &scene->textures.items[i];
        cache_image *img = find_image(cache, t);
        if (!img) status = open_image(cache, context, t, &img);
        cache->slots[i] = (cache_slot){img, t->wrap_u, t->wrap_v, t->filter};
    }
    return status;
}

fathom_status texture_cache_open(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                 texture_cache **out) {
    const size_t count = scene->textures.count, bytes = count * (sizeof(cache_slot) + sizeof(cache_image));
    const char *config = getenv("OCIO");
    texture_cache *cache = *out = calloc(1, sizeof *cache);
    if (!cache) return fail_memory(context, sizeof *cache);
    *cache = (texture_cache){.config = config && *config ? config : NULL,
                             .threads = fathom_context_threads(context),
                             .count = count,
                             .memory.descriptor = -1,
                             .disk.descriptor = -1};
    pthread_mutex_init(&cache->lock, NULL);
    cache->slots = calloc(count + 1, sizeof *cache->slots);
    cache->images = calloc(count + 1, sizeof *cache->images);
    fathom_status status = cache->slots && cache->images ? FATHOM_OK : fail_memory(context, bytes);
    if (status == FATHOM_OK) status = open_all(cache, context, scene);
    if (status == FATHOM_OK) status = place_images(cache, context, limit);
    if (status == FATHOM_OK) return status;
    texture_cache_close(cache);
    *out = NULL;
    return status;
}

void texture_cache_close(texture_cache *cache) {
    if (!cache) return;
    for (size_t i = 0; i < cache->image_count; ++i) close_source(&cache->images[i]);
    store_close(&cache->memory);
    store_close(&cache->disk);
    for (int i = 0; i < 4; ++i) free(cache->tables[i / 2][i % 2]);
    free(cache->slots);
    free(cache->images);
    pthread_mutex_destroy(&cache->lock);
    free(cache);
}

/* ---- facts ---- */

fathom_status texture_cache_check(texture_cache *cache, fathom_context *context) {
    const fathom_status status = __atomic_load_n(&cache->status, __ATOMIC_ACQUIRE);
    if (status == FATHOM_OK) return status;
    return fail_file(context, status, cache->failed, "cannot be read as a texture: %s", cache->why.text);
}

void texture_size(const texture_cache *cache, fathom_id texture, uint32_t *width, uint32_t *height) {
    const image_texture_info *info = &cache->slots[texture].image->info;
    *width = info->width, *height = info->height;
}

/* Decodes the image, unless it is a mip-mapped file. */
static fathom_status be_decoded(texture_cache *cache, fathom_context *context, cache_image *img) {
    if (__atomic_load_n(&img->decoded, __ATOMIC_ACQUIRE) || img->info.mipmapped) return FATHOM_OK;
    if (cache_touch(cache, img, img->offset >> PYRAMID_CHUNK_SHIFT)) return FATHOM_OK;
    return texture_cache_check(cache, context);
}

fathom_status texture_average(texture_cache *cache, fathom_context *context, fathom_id texture,
                              float rgba[4]) {
    cache_image *img = cache->slots[texture].image;
    fathom_status status = be_decoded(cache, context, img);
    if (status != FATHOM_OK) return status;
    if (!img->info.mipmapped) {
        memcpy(rgba, img->mean, sizeof img->mean);
        return status;
    }
    /* The last level is the mean; a footprint wider than the image shows it. */
    const cache_slot whole = {img, FATHOM_WRAP_CLAMP, FATHOM_WRAP_CLAMP, FATHOM_TEXTURE_TRILINEAR};
    cache_look_up(cache, &whole, 0.5f, 0.5f, 2, NULL, rgba);
    return texture_cache_check(cache, context);
}

fathom_status texture_is_opaque(texture_cache *cache, fathom_context *context, fathom_id texture, bool *out) {
    cache_image *img = cache->slots[texture].image;
    *out = img->info.channels % 2 == 1;
    if (*out || img->info.mipmapped) return FATHOM_OK;
    const fathom_status status = be_decoded(cache, context, img);
    if (status == FATHOM_OK) *out = img->least_alpha >= 1;
    return status;
}
