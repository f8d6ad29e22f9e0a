/* Writes textures as mip-mapped files. */
#include "base/file.h"
#include "base/srgb.h"
#include "image/helper/helper.h"
#include "image/output.h"
#include "image/pack.h"
#include "scene/scene.h"
#include "texture/cache.h"

#include <stdlib.h>
#include <string.h>

typedef struct written {
    texture_cache *cache;
    const cache_slot *slot;
    unsigned channels;
    image_texel type;
    bool srgb;
    srgb_codes codes;
    unsigned char *rows;
    image_message why;
} written;

static void put_number(const written *w, float value, bool alpha, unsigned char *out) {
    const bool srgb = w->srgb && !alpha;
    if (w->type == IMAGE_TEXEL_U8) {
        *out = srgb ? srgb_code(&w->codes, value) : byte_from_float(value);
        return;
    }
    const float encoded = srgb ? (float)srgb_encoded((double)value) : value;
    const uint16_t whole = w->type == IMAGE_TEXEL_U16
                               ? (uint16_t)(fmin(fmax((double)encoded, 0), 1) * 65535 + 0.5)
                               : half_from_float(encoded);
    if (w->type == IMAGE_TEXEL_FLOAT)
        memcpy(out, &encoded, sizeof encoded);
    else
        memcpy(out, &whole, sizeof whole);
}

static bool put_row(written *w, unsigned level, uint32_t y, unsigned char *out) {
    const uint32_t width = w->slot->image->plan.levels[level].width;
    for (uint32_t x = 0; x < width; ++x) {
        float rgba[4];
        if (!w->cache->kernels->texel(w->cache, w->slot, level, x, y, rgba)) return false;
        for (unsigned c = 0; c < w->channels; ++c, out += image_texel_size(w->type))
            put_number(w, rgba[c], c == 3, out);
    }
    return true;
}

static fathom_status write_level(written *w, image_writer *writer, unsigned level) {
    const pyramid_level *l = &w->slot->image->plan.levels[level];
    const size_t row = (size_t)l->width * w->channels * image_texel_size(w->type);
    fathom_status status = level ? image_calls.writer_level(writer, l->width, l->height, &w->why) : FATHOM_OK;
    for (uint32_t y = 0; status == FATHOM_OK && y < l->height; y += IMAGE_TILE) {
        const uint32_t count = l->height - y < IMAGE_TILE ? l->height - y : IMAGE_TILE;
        for (uint32_t i = 0; i < count; ++i) {
            if (!put_row(w, level, y + i, w->rows + row * i)) return FATHOM_BAD_INPUT;
        }
        status = image_calls.writer.rows(writer, count, w->rows, &w->why);
    }
    return status;
}

static fathom_status write_levels(written *w, fathom_context *context, const char *path, file_writer *file) {
    static const char *const colors[] = {"R", "G", "B", "A"}, *const grey = "Y";
    const pyramid *p = &w->slot->image->plan;
    image_channel channels[4];
    for (unsigned c = 0; c < w->channels; ++c)
        channels[c] = (image_channel){.name = w->channels == 1 ? grey : colors[c]};
    const uint32_t width = p->levels[0].width, height = p->levels[0].height;
    const image_attribute says = {.name = "ImageDescription",
                                  .text = w->srgb ? IMAGE_SAYS_SRGB : IMAGE_SAYS_LINEAR};
    const image img = {width, height, 0, 0, width, height, channels, w->channels, &says, 1, 0};
    image_date date;
    fathom_status status = date_read(context, &date);
    if (status != FATHOM_OK) return status;
    const image_target target = {.path = path,
                                 .descriptor = file_writer_descriptor(file),
                                 .format = IMAGE_TIFF,
                                 .threads = w->cache->threads,
                                 .srgb = w->srgb && w->channels > 1,
                                 .date = date.text[0] ? date.text : NULL,
                                 .mipmapped = true,
                                 .texel = w->type,
                                 .img = &img};
    image_writer *writer;
    status = image_calls.writer.open(&target, &writer, &w->why);
    if (status != FATHOM_OK) return status;
    for (unsigned i = 0; status == FATHOM_OK && i < p->count; ++i) status = write_level(w, writer, i);
    const fathom_status closed = image_calls.writer.close(writer, status == FATHOM_OK, &w->why);
    return status == FATHOM_OK ? closed : status;
}

static fathom_status write_file(written *w, fathom_context *context, const char *path) {
    const pyramid_level *l = &w->slot->image->plan.levels[0];
    const size_t bytes = (size_t)l->width * IMAGE_TILE * w->channels * image_texel_size(w->type);
    file_writer *file;
    w->rows = malloc(bytes);
    if (!w->rows) return fail_memory(context, bytes);
    fathom_status status = file_writer_open(context, path, &file);
    if (status != FATHOM_OK) return status;
    status = write_levels(w, context, path, file);
    if (status == FATHOM_OK) return file_writer_commit(file);
    file_writer_abort(file);
    if (texture_cache_check(w->cache, context) != FATHOM_OK || !w->why.text[0]) return status;
    return fail_file(context, status, path, "cannot be written: %s", w->why.text);
}

static fathom_status write_texture(texture_cache *cache, fathom_context *context, const char *path) {
    const cache_image *img = cache->images;
    written w = {.cache = cache, .slot = cache->slots, .type = img->info.kept};
    bool opaque;
    fathom_status status = texture_is_opaque(cache, context, 0, &opaque);
    if (status != FATHOM_OK) return status;
    w.channels = img->plan.channels == 1 ? 1 : opaque ? 3 : 4;
    /* Other programs take floats as linear, so those that come from integers of 32 bits are. */
    w.srgb =
        img->decoding.srgb && (w.type <= IMAGE_TEXEL_U16 || img->texture->color_space == FATHOM_COLOR_SRGB);
    srgb_codes_fill(&w.codes);
    status = write_file(&w, context, path);
    free(w.rows);
    return status;
}

/* Maximum bytes of tiles in memory while a file is written. */
#define WRITE_MEMORY 1000000000u

fathom_status fathom_texture_write(fathom_context *context, const fathom_texture *texture, const char *path) {
    if (!path) return fail_null(context, "path");
    if (!file_ends_in(path, "tx|tif|tiff"))
        return fail_file(context, FATHOM_BAD_USAGE, path, "expected a name that ends in .tx, .tif or .tiff");
    fathom_scene *scene;
    texture_cache *cache = NULL;
    fathom_status status = fathom_scene_create(context, &scene);
    if (status != FATHOM_OK) return status;
    status = fathom_scene_add_texture(scene, texture, NULL);
    if (status == FATHOM_OK) status = texture_cache_open(context, scene, WRITE_MEMORY, &cache);
    if (status == FATHOM_OK) status = write_texture(cache, context, path);
    texture_cache_close(cache);
    fathom_scene_destroy(scene);
    return status;
}
