#include "image/output.h"

#include "base/file.h"

#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <zlib.h>

struct image_writer {
    png_structp png;
    png_infop info;
    image_message message;
    /* Arguments of the calls below. */
    const image_target *target;
    const unsigned char *rows;
    uint32_t row_count;
    size_t row_bytes;
};

/* ---- libpng's callbacks: errors return by longjmp() to guarded() ---- */

static _Noreturn void on_error(png_structp png, png_const_charp text) {
    image_writer *writer = png_get_error_ptr(png);
    snprintf(writer->message.text, sizeof writer->message.text, "libpng: %s", text);
    png_longjmp(png, 1);
}

static void on_warning(png_structp png, png_const_charp text) { (void)png, (void)text; }

/* file_writer stores errors until the file is complete. */
static void put(png_structp png, png_bytep bytes, size_t size) {
    file_writer_put(png_get_io_ptr(png), bytes, size);
}

static void flush(png_structp png) { (void)png; }

static fathom_status guarded(image_writer *writer, void (*body)(image_writer *), image_message *message) {
    if (setjmp(png_jmpbuf(writer->png)) == 0) {
        body(writer);
        return FATHOM_OK;
    }
    *message = writer->message;
    return FATHOM_OUT_OF_RESOURCES;
}

/* ---- the header ---- */

static bool is_ascii(const char *text) {
    while (*text && !(*text & 0x80)) ++text;
    return !*text;
}

/* By the standard, plain texts are Latin-1 and international texts are UTF-8. libpng copies both. */
static void add_text(image_writer *writer, const char *name, const char *text) {
    png_text entry = {.compression = is_ascii(text) ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE,
                      .key = (char *)(uintptr_t)name,
                      .text = (char *)(uintptr_t)text};
    png_set_text(writer->png, writer->info, &entry, 1);
}

static void write_header(image_writer *writer) {
    const image *img = writer->target->img;
    png_structp png = writer->png;
    png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
    png_set_IHDR(png, writer->info, img->width, img->height, 8,
                 img->channel_count > 3 ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_BASE, PNG_FILTER_TYPE_BASE);
    if (writer->target->srgb) png_set_sRGB_gAMA_and_cHRM(png, writer->info, PNG_sRGB_INTENT_ABSOLUTE);
    for (size_t i = 0; i < img->attribute_count; ++i) {
        if (img->attributes[i].text) add_text(writer, img->attributes[i].name, img->attributes[i].text);
    }
    /* Differences to the left neighbour, with run-length matches only: for rendered images, this takes half
     * the time of zlib's level 4, for 3 to 8 % more bytes. */
    png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
    png_set_compression_strategy(png, Z_RLE);
    png_set_compression_buffer_size(png, 1u << 16);
    png_write_info(png, writer->info);
}

static void write_rows(image_writer *writer) {
    for (uint32_t y = 0; y < writer->row_count; ++y)
        png_write_row(writer->png, writer->rows + y * writer->row_bytes);
}

static void write_end(image_writer *writer) { png_write_end(writer->png, NULL); }

/* ---- the calls ---- */

static void destroy(image_writer *writer) {
    png_destroy_write_struct(&writer->png, &writer->info);
    free(writer);
}

static fathom_status open_png(const image_target *target, image_writer **out, image_message *message) {
    image_writer *writer = calloc(1, sizeof *writer);
    if (writer) writer->png = png_create_write_struct(PNG_LIBPNG_VER_STRING, writer, on_error, on_warning);
    if (writer && writer->png) writer->info = png_create_info_struct(writer->png);
    if (!writer || !writer->info) {
        if (writer) destroy(writer);
        snprintf(message->text, sizeof message->text, "out of memory");
        return FATHOM_OUT_OF_RESOURCES;
    }
    png_set_write_fn(writer->png, target->file, put, flush);
    writer->target = target;
    writer->row_bytes = (size_t)target->img->width * target->img->channel_count;
    fathom_status status = guarded(writer, write_header, message);
    writer->target = NULL;
    if (status == FATHOM_OK)
        *out = writer;
    else
        destroy(writer);
    return status;
}

static fathom_status rows_png(image_writer *writer, uint32_t count, const void *pixels,
                              image_message *message) {
    writer->rows = pixels, writer->row_count = count;
    return guarded(writer, write_rows, message);
}

static fathom_status close_png(image_writer *writer, bool finish, image_message *message) {
    fathom_status status = finish ? guarded(writer, write_end, message) : FATHOM_OK;
    destroy(writer);
    return status;
}

const image_writer_calls write_png_calls = {open_png, rows_png, close_png};
