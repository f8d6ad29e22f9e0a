#include "texture/cache.h"

#include "image/helper/helper.h"
#include "scene/scene.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

/* Mip levels above 0 store means, which need more precision than the texels of level 0. */
static image_texel type_of_means(const image_texture_info *info) {
    if (info->mipmapped) return info->kept;
    return info->kept == IMAGE_TEXEL_U8 || info->kept == IMAGE_TEXEL_HALF ? IMAGE_TEXEL_HALF
                                                                          : IMAGE_TEXEL_FLOAT;
}

/* A file that says how its colours are encoded is believed, unless the scene says otherwise. */
static bool is_srgb(const cache_image *img) {
    const fathom_color_space space = img->texture->color_space;
    if (space != FATHOM_COLOR_AUTO) return space == FATHOM_COLOR_SRGB;
    if (img->info.transfer == IMAGE_TRANSFER_SRGB) return true;
    return img->info.integers && img->info.transfer != IMAGE_TRANSFER_LINEAR;
}

static fathom_status plan_image(texture_cache *cache, fathom_context *context, cache_image *img) {
    const image_texture_info *info = &img->info;
    const bool srgb = is_srgb(img);
    if (info->width > FATHOM_TEXTURE_SIDE || info->height > FATHOM_TEXTURE_SIDE)
        return fail_file(context, FATHOM_BAD_INPUT, cache_name(img->texture),
                         "expected at most %u texels on a side", FATHOM_TEXTURE_SIDE);
    pyramid_plan(&img->plan, info->width, info->height, info->channels == 1 ? 1 : 4, info->kept,
                 type_of_means(info));
    for (unsigned k = 0; k <= img->plan.tail; ++k) cache->bytes += pyramid_part_bytes(&img->plan, k);
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

/* A warning about an image, after the place where the scene's file names it. */
__attribute__((format(printf, 3, 4))) static void warn_image(fathom_context *context, const cache_image *img,
                                                             const char *format, ...) {
    const fathom_place *at = img->place;
    char text[256];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    warn(context, "%s%s%s%s%s: %s", at ? at->file : "", at ? ": " : "", at ? at->field : "", at ? ": " : "",
         cache_name(img->texture), text);
}

/* Warns if the declared type is wrong; the content determines the type. */
static void check_mime(fathom_context *context, const cache_image *img, const char *format) {
    const fathom_texture *t = img->texture;
    static const char *const known[][2] = {{"image/png", "png"},
                                           {"image/jpeg", "jpeg"},
                                           {"image/webp", "webp"},
                                           {"image/x-exr", "openexr"},
                                           {"image/ktx2", "ktx2"}};
    for (size_t i = 0; t->mime && i < sizeof known / sizeof *known; ++i) {
        if (strcmp(t->mime, known[i][0]) == 0 && strcmp(format, known[i][1]) != 0)
            warn_image(context, img, "is declared as %.80s, and read as %s, which it is", t->mime, format);
    }
}

/* Warns if the file says that its colours are encoded otherwise than they are taken. */
static void check_transfer(fathom_context *context, const cache_image *img) {
    static const char *const names[] = {[IMAGE_TRANSFER_UNKNOWN] = "",
                                        [IMAGE_TRANSFER_LINEAR] = "linear",
                                        [IMAGE_TRANSFER_SRGB] = "sRGB",
                                        [IMAGE_TRANSFER_OTHER] = "neither sRGB nor linear"};
    const image_transfer said = img->info.transfer;
    const image_transfer taken = is_srgb(img) ? IMAGE_TRANSFER_SRGB : IMAGE_TRANSFER_LINEAR;
    if (said == IMAGE_TRANSFER_UNKNOWN || said == taken || img->texture->color_space == FATHOM_COLOR_NAMED)
        return;
    const bool levels = img->info.mipmapped;
    warn_image(
        context, img, "says that its numbers are %s; they are taken as %s%s%s", names[said], names[taken],
        levels ? ", for which its smaller levels are wrong averages: make it with fathom texture --color "
               : "",
        !levels                        ? ""
        : taken == IMAGE_TRANSFER_SRGB ? "srgb"
                                       : "linear");
}

/* Warns of an image of heights in place of one of normals. */
static void check_normals(fathom_context *context, const fathom_scene *scene, fathom_id id,
                          const cache_image *img) {
    for (size_t i = 0; img->info.channels == 1 && i < scene->materials.count; ++i) {
        const fathom_map *maps = scene->materials.items[i].value.maps;
        if (maps[FATHOM_MAP_NORMAL].texture != id && maps[FATHOM_MAP_CLEARCOAT_NORMAL].texture != id)
            continue;
        warn_image(context, img, "expected normals in three channels, found one; heights make a bump map");
        return;
    }
}

/* Warns if the scene's file asks for an alpha that the image lacks. Models may: their alpha is then 1. */
static void check_alpha(fathom_context *context, const fathom_scene *scene, fathom_id id,
                        const cache_image *img) {
    const fathom_place *at = scene_origin_find(scene, SCENE_PART_ALPHA, id);
    if (at && img->info.channels % 2 == 1)
        warn(context, "%s: %s: %s has no alpha, so the channel a is 1", at->file, at->field,
             cache_name(img->texture));
}

static fathom_status fail_image(fathom_context *context, const cache_image *img, fathom_status status,
                                const char *why) {
    fail_file(context, status, cache_name(img->texture), "cannot be read as a texture: %s", why);
    return img->place ? fail_within(context, status, img->place) : status;
}

/* FATHOM_BAD_USAGE is about the color space or its config, not about the image. */
static fathom_status fail_open(fathom_context *context, const fathom_scene *scene, fathom_id id,
                               const cache_image *img, fathom_status status, const char *why) {
    const fathom_place *place = scene_origin_find(scene, SCENE_PART_COLOR_SPACE, id);
    if (status == FATHOM_BAD_USAGE && place) return fail_at(context, FATHOM_BAD_INPUT, place, "%s", why);
    return fail_image(context, img, status, *why ? why : "out of memory");
}

static fathom_status open_image(texture_cache *cache, fathom_context *context, const fathom_scene *scene,
                                fathom_id id, cache_image **out) {
    const fathom_texture *t = &scene->textures.items[id];
    cache_image *img = *out = &cache->images[cache->image_count];
    image_message why = {""};
    img->texture = t, img->place = scene_origin_find(scene, SCENE_PART_TEXTURE, id);
    fathom_status status = cache_open_source(cache, t, &img->source, &img->info, &why);
    if (status != FATHOM_OK) return fail_open(context, scene, id, img, status, why.text);
    cache_close_source(img);
    pthread_mutex_init(&img->lock, NULL);
    ++cache->image_count;
    check_mime(context, img, img->info.format);
    check_transfer(context, img);
    check_normals(context, scene, id, img);
    return plan_image(cache, context, img);
}

/* A part of an image's pyramid. */
typedef struct cache_part {
    cache_image *image;
    unsigned part;
    bool unused; /* no texture filters between levels, and the part is not level 0 */
    uint64_t bytes;
} cache_part;

/* Small parts first, because each level of an image is looked up about as often as the next one. */
static int compare_parts(const void *a, const void *b) {
    const cache_part *x = a, *y = b;
    if (x->unused != y->unused) return x->unused ? 1 : -1;
    if (x->bytes != y->bytes) return x->bytes < y->bytes ? -1 : 1;
    if (x->image != y->image) return x->image < y->image ? -1 : 1;
    return x->part < y->part ? -1 : x->part > y->part;
}

static bool uses_levels(const texture_cache *cache, const cache_image *img) {
    bool found = false;
    for (size_t i = 0; i < cache->count; ++i)
        found |= cache->slots[i].image == img && cache->slots[i].filter >= FATHOM_TEXTURE_TRILINEAR;
    return found;
}

static size_t list_parts(const texture_cache *cache, cache_part *parts) {
    size_t count = 0;
    for (size_t i = 0; i < cache->image_count; ++i) {
        cache_image *img = &cache->images[i];
        const bool levels = uses_levels(cache, img);
        for (unsigned k = 0; k <= img->plan.tail; ++k)
            parts[count++] = (cache_part){img, k, k && !levels, pyramid_part_bytes(&img->plan, k)};
    }
    qsort(parts, count, sizeof *parts, compare_parts);
    return count;
}

/* If all parts fit into the limit, they are in memory. Otherwise the smaller parts, up to three quarters of
 * the limit, are in memory and the others on the disk; the remaining limit is for mapped parts of the disk
 * file. */
static fathom_status place_images(texture_cache *cache, fathom_context *context) {
    const size_t room = cache->image_count * PYRAMID_LEVELS * sizeof(cache_part);
    cache_part *parts = malloc(room + 1);
    uint64_t kept = 0, at = 0;
    if (!parts) return fail_memory(context, room);
    const size_t count = list_parts(cache, parts);
    const uint64_t limit = cache->limit, most = cache->bytes <= limit ? limit : limit / 4 * 3;
    for (size_t i = 0; i < count; ++i) {
        pyramid_place(&parts[i].image->plan, parts[i].part, at);
        at += parts[i].bytes;
        if (at <= most) kept = at;
    }
    free(parts);
    return store_open(context, kept, at - kept, limit - kept, &cache->store);
}

/* One more helper per this many texels; a helper takes a tenth of a second to start. */
#define HELPER_TEXELS ((uint64_t)1 << 24)

/* The additional helpers load their libraries while the scene is prepared. */
static void start_helpers(texture_cache *cache) {
    uint64_t texels = 0;
    for (size_t i = 0; i < cache->image_count; ++i)
        texels += (uint64_t)cache->images[i].info.width * cache->images[i].info.height;
    const uint64_t wanted = 1 + texels / HELPER_TEXELS;
    cache->helpers = wanted < cache->threads ? (unsigned)wanted : cache->threads;
    if (cache->helpers > 1) helper_prefetch(cache->helpers);
}

static fathom_status open_all(texture_cache *cache, fathom_context *context, const fathom_scene *scene) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; status == FATHOM_OK && i < cache->count; ++i) {
        const fathom_texture *t = &scene->textures.items[i];
        cache_image *img = find_image(cache, t);
        if (!img) status = open_image(cache, context, scene, (fathom_id)i, &img);
        if (status == FATHOM_OK) check_alpha(context, scene, (fathom_id)i, img);
        cache->slots[i] = (cache_slot){img, t->wrap_u, t->wrap_v, t->filter};
    }
    return status;
}

static fathom_status open_headers(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                  texture_cache **out) {
    const size_t count = scene->textures.count, bytes = count * (sizeof(cache_slot) + sizeof(cache_image));
    const char *config = getenv("OCIO");
    texture_cache *cache = *out = calloc(1, sizeof *cache);
    if (!cache) return fail_memory(context, sizeof *cache);
    *cache = (texture_cache){.kernels = texture_kernels_best(),
                             .config = config && *config ? config : NULL,
                             .threads = fathom_context_threads(context),
                             .count = count,
                             .limit = limit,
                             .store = {.memory = -1, .disk = -1}};
    pthread_mutex_init(&cache->lock, NULL);
    cache->slots = calloc(count + 1, sizeof *cache->slots);
    cache->images = calloc(count + 1, sizeof *cache->images);
    fathom_status status = cache->slots && cache->images ? FATHOM_OK : fail_memory(context, bytes);
    return status == FATHOM_OK ? open_all(cache, context, scene) : status;
}

fathom_status texture_cache_open(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                 texture_cache **out) {
    fathom_status status = open_headers(context, scene, limit, out);
    if (status == FATHOM_OK) start_helpers(*out);
    if (status == FATHOM_OK) status = place_images(*out, context);
    if (status == FATHOM_OK) return status;
    texture_cache_close(*out);
    *out = NULL;
    return status;
}

fathom_status texture_cache_measure(fathom_context *context, const fathom_scene *scene, uint64_t limit,
                                    uint64_t *bytes) {
    texture_cache *cache;
    const fathom_status status = open_headers(context, scene, limit, &cache);
    *bytes = texture_cache_bytes(cache);
    texture_cache_close(cache);
    return status;
}

uint64_t texture_cache_bytes(const texture_cache *cache) {
    return !cache ? 0 : cache->bytes < cache->limit ? cache->bytes : cache->limit;
}

uint64_t texture_cache_peak(const texture_cache *cache) { return store_peak(&cache->store); }

void texture_cache_close(texture_cache *cache) {
    if (!cache) return;
    for (size_t i = 0; i < cache->image_count; ++i) {
        cache_close_source(&cache->images[i]);
        pthread_mutex_destroy(&cache->images[i].lock);
    }
    store_close(&cache->store);
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
    return fail_image(context, cache->failed, status, cache->why.text);
}

void texture_size(const texture_cache *cache, fathom_id texture, uint32_t *width, uint32_t *height) {
    const image_texture_info *info = &cache->slots[texture].image->info;
    *width = info->width, *height = info->height;
}

fathom_status texture_brightest(texture_cache *cache, fathom_context *context, fathom_id texture,
                                float rgb[3]) {
    const cache_slot *slot = &cache->slots[texture];
    const image_texture_info *info = &slot->image->info;
    const bool integers = info->sent <= IMAGE_TEXEL_U16;
    float rgba[4];
    rgb[0] = rgb[1] = rgb[2] = integers ? 1 : 0;
    for (uint32_t y = 0; y < info->height && !integers; ++y) {
        for (uint32_t x = 0; x < info->width; ++x) {
            if (!cache->kernels->texel(cache, slot, 0, x, y, rgba))
                return texture_cache_check(cache, context);
            for (int c = 0; c < 3; ++c) rgb[c] = fmaxf(rgb[c], rgba[c]);
        }
    }
    return FATHOM_OK;
}

fathom_status texture_is_opaque(texture_cache *cache, fathom_context *context, fathom_id texture, bool *out) {
    cache_image *img = cache->slots[texture].image;
    *out = img->info.channels % 2 == 1;
    if (*out || img->info.mipmapped) return FATHOM_OK;
    if (!__atomic_load_n(&img->decoded, __ATOMIC_ACQUIRE) &&
        !cache_fill(cache, img, img->plan.levels[0].offset >> PYRAMID_CHUNK_SHIFT))
        return texture_cache_check(cache, context);
    *out = img->least_alpha >= 1;
    return FATHOM_OK;
}
