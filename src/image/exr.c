/* Writes OpenEXR files without the OpenEXR library. Version 2: single part, scan lines, no compression
 * (openexr.com, "OpenEXR File Layout"). The format is little-endian, as are all machines that Embree
 * supports. */
#include "base/file.h"
#include "image/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "numbers are written as they lie in memory");

enum { MAGIC = 20000630, VERSION = 2, PIXEL_UINT = 0, PIXEL_FLOAT = 2, LINE_HEADER = 8 };

typedef struct exr {
    file_writer *file;
    const image *img;
    const image_channel **channels; /* sorted by name, as the format requires */
    unsigned char *row;             /* of one channel */
    uint64_t written;
} exr;

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
    for (size_t i = 0; i < out->img->channel_count; ++i) size += strlen(out->channels[i]->name) + 1 + 16;
    begin_attribute(out, "channels", "chlist", size);
    for (size_t i = 0; i < out->img->channel_count; ++i) {
        put_name(out, out->channels[i]->name);
        put_u32(out, out->channels[i]->type == IMAGE_UINT ? PIXEL_UINT : PIXEL_FLOAT);
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
    put_byte(out, 0);
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

/* The format's type for `count` doubles; NULL: the format has none. */
static const char *type_of(size_t count) {
    switch (count) {
    case 1: return "double";
    case 2: return "v2d";
    case 3: return "v3d";
    case 9: return "m33d";
    case 16: return "m44d";
    default: return NULL;
    }
}

static size_t number_text(char text[32], const image_attribute *attribute, size_t i) {
    return (size_t)snprintf(text, 32, "%s%.17g", i ? " " : "", attribute->numbers[i]);
}

static void put_numbers_as_text(exr *out, const image_attribute *attribute) {
    char text[32];
    size_t size = 0;
    for (size_t i = 0; i < attribute->count; ++i) size += number_text(text, attribute, i);
    begin_attribute(out, attribute->name, "string", size);
    for (size_t i = 0; i < attribute->count; ++i) put(out, text, number_text(text, attribute, i));
}

static void put_attribute(exr *out, const image_attribute *attribute) {
    if (attribute->text) {
        begin_attribute(out, attribute->name, "string", strlen(attribute->text));
        put(out, attribute->text, strlen(attribute->text));
        return;
    }
    const char *type = type_of(attribute->count);
    if (image_attribute_is_m44f(attribute)) {
        begin_attribute(out, attribute->name, "m44f", sizeof(float) * 16);
        for (size_t i = 0; i < 16; ++i) put_float(out, (float)attribute->numbers[i]);
    } else if (type) {
        begin_attribute(out, attribute->name, type, sizeof(double) * attribute->count);
        put(out, attribute->numbers, sizeof(double) * attribute->count);
    } else {
        put_numbers_as_text(out, attribute);
    }
}

static void put_header(exr *out) {
    put_u32(out, MAGIC), put_u32(out, VERSION);
    put_channels(out);
    put_frame(out);
    for (size_t i = 0; i < out->img->attribute_count; ++i) put_attribute(out, &out->img->attributes[i]);
    put_byte(out, 0);
}

static size_t line_bytes(const exr *out) { return sizeof(float) * out->img->width * out->img->channel_count; }

static void put_offsets(exr *out) {
    const uint64_t first = out->written + sizeof(uint64_t) * out->img->height;
    for (uint32_t y = 0; y < out->img->height; ++y) {
        const uint64_t offset = first + y * (LINE_HEADER + line_bytes(out));
        put(out, &offset, sizeof offset);
    }
}

static void put_line(exr *out, uint32_t y) {
    put_u32(out, out->img->y + y), put_u32(out, (uint32_t)line_bytes(out));
    for (size_t i = 0; i < out->img->channel_count; ++i) {
        const image_channel *channel = out->channels[i];
        const char *from = (const char *)channel->data + (size_t)y * out->img->width * channel->stride;
        for (uint32_t x = 0; x < out->img->width; ++x)
            memcpy(out->row + (size_t)4 * x, from + x * channel->stride, 4);
        put(out, out->row, (size_t)4 * out->img->width);
    }
}

static int by_name(const void *a, const void *b) {
    return strcmp((*(const image_channel *const *)a)->name, (*(const image_channel *const *)b)->name);
}

fathom_status exr_write_plain(fathom_context *context, const image *img, const char *path) {
    exr out = {.img = img,
               .channels = malloc(img->channel_count * sizeof *out.channels),
               .row = malloc((size_t)4 * img->width)};
    fathom_status status = FATHOM_OK;
    if (!out.channels || !out.row) status = fail_memory(context, (size_t)4 * img->width);
    if (status == FATHOM_OK) status = file_writer_open(context, path, &out.file);
    if (status == FATHOM_OK) {
        for (size_t i = 0; i < img->channel_count; ++i) out.channels[i] = &img->channels[i];
        qsort(out.channels, img->channel_count, sizeof *out.channels, by_name);
        put_header(&out);
        put_offsets(&out);
        for (uint32_t y = 0; y < img->height; ++y) put_line(&out, y);
        status = file_writer_commit(out.file);
    }
    free(out.channels), free(out.row);
    return status;
}
