/* The layout of OpenEXR files, version 2: single part, scan lines, no compression (openexr.com, "OpenEXR File
 * Layout"). Little-endian throughout. */
#include "image/exr.h"

#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAGIC = 20000630, VERSION = 2, PIXEL_UINT = 0, PIXEL_FLOAT = 2, LINE_HEADER = 8 };

typedef struct exr {
    file_writer *file;
    const image *img;
    const image_channel **channels; /* by name, as the format asks */
    unsigned char *row;             /* of one channel */
    uint64_t written;
} exr;

static void put(exr *out, const void *bytes, size_t size) {
    file_writer_put(out->file, bytes, size);
    out->written += size;
}

static void to_little(unsigned char *at, uint64_t value, size_t size) {
    for (size_t i = 0; i < size; ++i) at[i] = (unsigned char)(value >> 8 * i);
}

static void put_number(exr *out, uint64_t value, size_t size) {
    unsigned char bytes[8];
    to_little(bytes, value, size);
    put(out, bytes, size);
}

static void put_float(exr *out, float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_number(out, bits, sizeof bits);
}

static void put_double(exr *out, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    put_number(out, bits, sizeof bits);
}

static void put_name(exr *out, const char *name) { put(out, name, strlen(name) + 1); }

static void begin_attribute(exr *out, const char *name, const char *type, size_t size) {
    put_name(out, name);
    put_name(out, type);
    put_number(out, size, 4);
}

static void put_channels(exr *out) {
    size_t size = 1;
    for (size_t i = 0; i < out->img->channel_count; ++i) size += strlen(out->channels[i]->name) + 1 + 16;
    begin_attribute(out, "channels", "chlist", size);
    for (size_t i = 0; i < out->img->channel_count; ++i) {
        put_name(out, out->channels[i]->name);
        put_number(out, out->channels[i]->type == IMAGE_UINT ? PIXEL_UINT : PIXEL_FLOAT, 4);
        put_number(out, 0, 4);                        /* not perceptually linear */
        put_number(out, 1, 4), put_number(out, 1, 4); /* a sample in every pixel */
    }
    put_number(out, 0, 1);
}

static void put_box(exr *out, const char *name, uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
    begin_attribute(out, name, "box2i", 16);
    put_number(out, x, 4), put_number(out, y, 4);
    put_number(out, x + width - 1, 4), put_number(out, y + height - 1, 4);
}

/* What an image of any program needs to have. */
static void put_frame(exr *out) {
    const image *img = out->img;
    begin_attribute(out, "compression", "compression", 1);
    put_number(out, 0, 1);
    put_box(out, "dataWindow", img->x, img->y, img->width, img->height);
    put_box(out, "displayWindow", 0, 0, img->full_width, img->full_height);
    begin_attribute(out, "lineOrder", "lineOrder", 1);
    put_number(out, 0, 1);
    begin_attribute(out, "pixelAspectRatio", "float", 4);
    put_float(out, 1);
    begin_attribute(out, "screenWindowCenter", "v2f", 8);
    put_float(out, 0), put_float(out, 0);
    begin_attribute(out, "screenWindowWidth", "float", 4);
    put_float(out, 1);
}

/* The format's word for so many doubles, NULL when it has none. */
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

static void put_m44f(exr *out, const image_attribute *attribute) {
    begin_attribute(out, attribute->name, "m44f", sizeof(float) * 16);
    for (size_t i = 0; i < 16; ++i) put_float(out, (float)attribute->numbers[i]);
}

static void put_attribute(exr *out, const image_attribute *attribute) {
    if (attribute->text) {
        begin_attribute(out, attribute->name, "string", strlen(attribute->text));
        put(out, attribute->text, strlen(attribute->text));
        return;
    }
    const char *type = type_of(attribute->count);
    if (image_attribute_is_m44f(attribute)) {
        put_m44f(out, attribute);
        return;
    }
    if (!type) {
        put_numbers_as_text(out, attribute);
        return;
    }
    begin_attribute(out, attribute->name, type, sizeof(double) * attribute->count);
    for (size_t i = 0; i < attribute->count; ++i) put_double(out, attribute->numbers[i]);
}

static void put_header(exr *out) {
    put_number(out, MAGIC, 4), put_number(out, VERSION, 4);
    put_channels(out);
    put_frame(out);
    for (size_t i = 0; i < out->img->attribute_count; ++i) put_attribute(out, &out->img->attributes[i]);
    put_number(out, 0, 1);
}

static size_t line_bytes(const exr *out) { return sizeof(float) * out->img->width * out->img->channel_count; }

static void put_offsets(exr *out) {
    const uint64_t first = out->written + sizeof(uint64_t) * out->img->height;
    for (uint32_t y = 0; y < out->img->height; ++y)
        put_number(out, first + y * (LINE_HEADER + line_bytes(out)), 8);
}

static void put_line(exr *out, uint32_t y) {
    put_number(out, out->img->y + y, 4), put_number(out, line_bytes(out), 4);
    for (size_t i = 0; i < out->img->channel_count; ++i) {
        const image_channel *channel = out->channels[i];
        const char *from = (const char *)channel->data + (size_t)y * out->img->width * channel->stride;
        for (uint32_t x = 0; x < out->img->width; ++x) {
            uint32_t bits;
            memcpy(&bits, from + x * channel->stride, sizeof bits);
            to_little(out->row + (size_t)4 * x, bits, 4);
        }
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
