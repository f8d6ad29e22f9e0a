/* Writes OpenEXR files (openexr.com, "OpenEXR File Layout"): version 2, a single part of scan lines. The
 * format is little-endian, as are all machines that Embree supports. */
#include "image/output.h"

#include "base/file.h"
#include "base/threads.h"
#include "image/pack.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zlib.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are written as they lie in memory");

enum { MAGIC = 20000630, VERSION = 2, LONG_NAMES = 0x400, SHORT_NAME = 31 };
enum { NO_COMPRESSION = 0, ZIP_COMPRESSION = 3, ZIP_ROWS = 16 };
/* The level that OpenEXR takes: higher ones need far more time for files that are hardly smaller. */
#define ZIP_LEVEL 4

/* The format's numbers for its types of pixels. */
typedef enum pixel_type { PIXEL_UINT, PIXEL_HALF, PIXEL_FLOAT } pixel_type;

typedef struct exr_channel {
    const image_channel *from;
    pixel_type type;
} exr_channel;

/* Rows that are compressed together, as the file will hold them. */
typedef struct exr_block {
    unsigned char *bytes;
    size_t size;
} exr_block;

typedef struct exr {
    file_writer *file;
    const image *img;
    const exr_options *options;
    exr_channel *channels; /* sorted by name, as the format requires */
    uint64_t written;
    uint64_t *offsets; /* of each block in the file */

    uint32_t block_rows;
    size_t line_bytes, block_bytes, block_count;
    exr_block *batch; /* blocks that several threads compress at the same time */
    size_t batch_count, batch_first;
    unsigned threads;
    unsigned char *rows, *differences; /* of a block, for each thread; only if the file is compressed */
    atomic_bool lost;                  /* out of memory */
} exr;

/* ---- the header ---- */

static void put(exr *out, const void *bytes, size_t size) {
    file_writer_put(out->file, bytes, size);
    out->written += size;
}

static void put_u32(exr *out, uint32_t value) { put(out, &value, sizeof value); }

static void put_byte(exr *out, unsigned char value) { put(out, &value, 1); }

static void put_float(exr *out, float value) { put(out, &value, sizeof value); }

static void put_name(exr *out, const char *name) { put(out, name, strlen(name) + 1); }

static void begin_attribute(exr *out, const char *name, const char *type, size_t size) {
    put_name(out, name);
    put_name(out, type);
    put_u32(out, (uint32_t)size);
}

static void put_channels(exr *out) {
    size_t size = 1;
    for (size_t i = 0; i < out->img->channel_count; ++i) size += strlen(out->channels[i].from->name) + 1 + 16;
    begin_attribute(out, "channels", "chlist", size);
    for (size_t i = 0; i < out->img->channel_count; ++i) {
        put_name(out, out->channels[i].from->name);
        put_u32(out, out->channels[i].type);
        put_u32(out, 0);                  /* not perceptually linear */
        put_u32(out, 1), put_u32(out, 1); /* sampling: every pixel */
    }
    put_byte(out, 0);
}

static void put_box(exr *out, const char *name, uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
    begin_attribute(out, name, "box2i", 16);
    put_u32(out, x), put_u32(out, y);
    put_u32(out, x + width - 1), put_u32(out, y + height - 1);
}

/* The attributes that every file must have. */
static void put_frame(exr *out) {
    const image *img = out->img;
    begin_attribute(out, "compression", "compression", 1);
    put_byte(out, out->options->compressed ? ZIP_COMPRESSION : NO_COMPRESSION);
    put_box(out, "dataWindow", img->x, img->y, img->width, img->height);
    put_box(out, "displayWindow", 0, 0, img->full_width, img->full_height);
    begin_attribute(out, "lineOrder", "lineOrder", 1);
    put_byte(out, 0);
    begin_attribute(out, "pixelAspectRatio", "float", 4);
    put_float(out, 1);
    begin_attribute(out, "screenWindowCenter", "v2f", 8);
    put_float(out, 0), put_float(out, 0);
    begin_attribute(out, "screenWindowWidth", "float", 4);
    put_float(out, 1);
}

static void put_text(exr *out, const char *name, const char *text) {
    begin_attribute(out, name, "string", strlen(text));
    put(out, text, strlen(text));
}

/* Red, green, blue and white of ITU-R BT.709 as CIE x, y. */
static void put_primaries(exr *out) {
    static const float rec709[8] = {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f};
    begin_attribute(out, "chromaticities", "chromaticities", sizeof rec709);
    put(out, rec709, sizeof rec709);
}

static void put_date(exr *out) {
    char now[32] = "";
    struct tm local;
    const time_t seconds = time(NULL);
    const char *date = out->options->date;
    if (!date && localtime_r(&seconds, &local) && strftime(now, sizeof now, "%Y:%m:%d %H:%M:%S", &local))
        date = now;
    if (date) put_text(out, "capDate", date);
}

static void put_attribute(exr *out, const image_attribute *attribute) {
    if (attribute->text) {
        put_text(out, attribute->name, attribute->text);
    } else if (attribute->count == 16) {
        begin_attribute(out, attribute->name, "m44f", sizeof(float) * 16);
        for (size_t i = 0; i < 16; ++i) put_float(out, (float)attribute->numbers[i]);
    } else {
        const size_t size = sizeof(double) * attribute->count;
        begin_attribute(out, attribute->name, attribute->count == 3 ? "v3d" : "double", size);
        put(out, attribute->numbers, size);
    }
}

static size_t longest_name(const exr *out) {
    size_t longest = 0;
    for (size_t i = 0; i < out->img->channel_count; ++i) {
        const size_t length = strlen(out->channels[i].from->name);
        longest = length > longest ? length : longest;
    }
    for (size_t i = 0; i < out->img->attribute_count; ++i) {
        const size_t length = strlen(out->img->attributes[i].name);
        longest = length > longest ? length : longest;
    }
    return longest;
}

static void put_header(exr *out) {
    put_u32(out, MAGIC);
    put_u32(out, VERSION | (longest_name(out) > SHORT_NAME ? LONG_NAMES : 0));
    put_channels(out);
    put_frame(out);
    put_primaries(out);
    put_date(out);
    for (size_t i = 0; i < out->img->attribute_count; ++i) put_attribute(out, &out->img->attributes[i]);
    put_byte(out, 0);
}

/* ---- the pixels ---- */

static size_t pixel_size(pixel_type type) { return type == PIXEL_HALF ? 2 : 4; }

/* Row y of a channel. Returns the end of the row in `to`. */
static unsigned char *pack_channel(const exr_channel *channel, uint32_t width, uint32_t y,
                                   unsigned char *to) {
    const size_t size = pixel_size(channel->type), stride = channel->from->stride;
    const char *from = (const char *)channel->from->data + (size_t)y * width * stride;
    for (uint32_t x = 0; x < width; ++x, from += stride, to += size) {
        if (channel->type == PIXEL_HALF) {
            float value;
            memcpy(&value, from, sizeof value);
            const uint16_t half = half_from_float(value);
            memcpy(to, &half, sizeof half);
        } else {
            memcpy(to, from, 4); /* floats and unsigned alike */
        }
    }
    return to;
}

static size_t first_row(const exr *out, size_t block) { return block * out->block_rows; }

static size_t rows_of(const exr *out, size_t block) {
    const size_t left = out->img->height - first_row(out, block);
    return left < out->block_rows ? left : out->block_rows;
}

/* Row after row, and in each row channel after channel. */
static void pack_block(const exr *out, size_t block, unsigned char *to) {
    const size_t begin = first_row(out, block), end = begin + rows_of(out, block);
    for (size_t y = begin; y < end; ++y) {
        for (size_t c = 0; c < out->img->channel_count; ++c)
            to = pack_channel(&out->channels[c], out->img->width, (uint32_t)y, to);
    }
}

/* zlib compresses the bytes with an even index, then the others, each as its difference from the one before
 * it, plus 128. All types have an even number of bytes. */
static void take_differences(const unsigned char *restrict bytes, size_t size, unsigned char *restrict to) {
    const size_t half = size / 2;
    to[0] = bytes[0];
    to[half] = (unsigned char)(bytes[1] - bytes[size - 2] + 128);
    for (size_t i = 1; i < half; ++i) {
        to[i] = (unsigned char)(bytes[2 * i] - bytes[2 * i - 2] + 128);
        to[half + i] = (unsigned char)(bytes[2 * i + 1] - bytes[2 * i - 1] + 128);
    }
}

/* A block that compression would not make smaller is stored uncompressed; readers know it by its size. */
static bool compress_block(const exr *out, unsigned worker, size_t block, exr_block *to) {
    unsigned char *rows = out->rows + worker * out->block_bytes,
                  *differences = out->differences + worker * out->block_bytes;
    const size_t size = rows_of(out, block) * out->line_bytes;
    uLongf packed = size - 1;
    pack_block(out, block, rows);
    take_differences(rows, size, differences);
    const int result = compress2(to->bytes, &packed, differences, size, ZIP_LEVEL);
    if (result == Z_BUF_ERROR) memcpy(to->bytes, rows, size);
    to->size = result == Z_OK ? packed : size;
    return result == Z_OK || result == Z_BUF_ERROR;
}

static void make_blocks(void *user, size_t begin, size_t end, unsigned worker) {
    exr *out = user;
    for (size_t i = begin; i < end; ++i) {
        const size_t block = out->batch_first + i;
        if (out->options->compressed) {
            if (!compress_block(out, worker, block, &out->batch[i])) out->lost = true;
        } else {
            out->batch[i].size = rows_of(out, block) * out->line_bytes;
            pack_block(out, block, out->batch[i].bytes);
        }
    }
}

static void put_block(exr *out, size_t block, const exr_block *made) {
    out->offsets[block] = out->written;
    put_u32(out, out->img->y + (uint32_t)first_row(out, block));
    put_u32(out, (uint32_t)made->size);
    put(out, made->bytes, made->size);
}

/* The table of offsets comes before the blocks, but is known only when all blocks are written. */
static void put_blocks(exr *out) {
    const uint64_t table = out->written;
    put(out, out->offsets, out->block_count * sizeof *out->offsets);
    for (out->batch_first = 0; out->batch_first < out->block_count; out->batch_first += out->batch_count) {
        const size_t left = out->block_count - out->batch_first,
                     count = left < out->batch_count ? left : out->batch_count;
        loop_workers(out->threads, count, 1, make_blocks, out);
        if (out->lost) return;
        for (size_t i = 0; i < count; ++i) put_block(out, out->batch_first + i, &out->batch[i]);
    }
    file_writer_put_at(out->file, table, out->offsets, out->block_count * sizeof *out->offsets);
}

/* ---- memory ---- */

static int by_name(const void *a, const void *b) {
    return strcmp(((const exr_channel *)a)->from->name, ((const exr_channel *)b)->from->name);
}

static void sort_channels(exr *out) {
    const image *img = out->img;
    for (size_t i = 0; i < img->channel_count; ++i) {
        const image_channel *from = &img->channels[i];
        const bool half = from->color && !out->options->float_color;
        out->channels[i].from = from;
        out->channels[i].type = from->type == IMAGE_UINT ? PIXEL_UINT : half ? PIXEL_HALF : PIXEL_FLOAT;
        out->line_bytes += img->width * pixel_size(out->channels[i].type);
    }
    qsort(out->channels, img->channel_count, sizeof *out->channels, by_name);
}

/* Enough for all threads, and about this many bytes. */
#define BATCH_BYTES ((size_t)16 << 20)

static bool allocate_blocks(exr *out) {
    const bool compressed = out->options->compressed;
    out->block_rows = compressed ? ZIP_ROWS : 1;
    out->block_bytes = out->block_rows * out->line_bytes;
    out->block_count = (out->img->height + out->block_rows - 1) / out->block_rows;
    out->batch_count = compressed ? BATCH_BYTES / out->block_bytes : 1;
    if (compressed && out->batch_count < out->options->threads) out->batch_count = out->options->threads;
    if (out->batch_count > out->block_count) out->batch_count = out->block_count;
    out->threads = out->options->threads;
    if (out->threads > out->batch_count) out->threads = (unsigned)out->batch_count;
    out->offsets = calloc(out->block_count, sizeof *out->offsets);
    out->batch = calloc(out->batch_count, sizeof *out->batch);
    out->rows = compressed ? malloc(out->threads * out->block_bytes) : NULL;
    out->differences = compressed ? malloc(out->threads * out->block_bytes) : NULL;
    bool all = out->offsets && out->batch && (!compressed || (out->rows && out->differences));
    for (size_t i = 0; all && i < out->batch_count; ++i)
        all = (out->batch[i].bytes = malloc(out->block_bytes)) != NULL;
    return all;
}

static void free_all(exr *out) {
    for (size_t i = 0; out->batch && i < out->batch_count; ++i) free(out->batch[i].bytes);
    free(out->batch), free(out->rows), free(out->differences);
    free(out->offsets), free(out->channels);
}

/* ---- the calls ---- */

fathom_status exr_put(fathom_context *context, file_writer *file, const image *img,
                      const exr_options *options) {
    exr out = {.file = file, .img = img, .options = options};
    out.channels = malloc(img->channel_count * sizeof *out.channels);
    if (!out.channels) return fail_memory(context, img->channel_count * sizeof *out.channels);
    sort_channels(&out);
    out.lost = !allocate_blocks(&out);
    if (!out.lost) {
        put_header(&out);
        put_blocks(&out);
    }
    const fathom_status status =
        out.lost ? fail_memory(context, out.batch_count * out.block_bytes) : FATHOM_OK;
    free_all(&out);
    return status;
}

fathom_status exr_write_plain(fathom_context *context, const image *img, const char *path) {
    static const exr_options plain = {.float_color = true, .threads = 1};
    file_writer *file;
    fathom_status status = file_writer_open(context, path, &file);
    if (status != FATHOM_OK) return status;
    status = exr_put(context, file, img, &plain);
    if (status == FATHOM_OK) return file_writer_commit(file);
    file_writer_abort(file);
    return status;
}
