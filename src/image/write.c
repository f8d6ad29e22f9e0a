#include "base/file.h"
#include "base/threads.h"
#include "image/helper/helper.h"
#include "image/output.h"
#include "image/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* TIFF is written in chunks of about this size: large enough for all compression threads, but much smaller
 * than a second copy of a large image. The other formats compress on one thread. */
#define CHUNK_BYTES ((size_t)16 << 20)
#define CHUNK_ROWS 64u

/* A file that is being written. */
typedef struct writing {
    fathom_context *context;
    const char *path;
    const image_writer_calls *calls;
    image_format format;
    image_date date;
    image shown;               /* the part of the image that the file will hold */
    image_channel channels[4]; /* of `shown`, but not in EXR */
    image_packing packing;
    image_view *view; /* NULL: srgb_codes */
    srgb_codes srgb_codes;
    bool srgb, float_color, rehearsal;
    unsigned threads;

    size_t chunk;        /* rows per call of the writer */
    unsigned char *rows; /* a chunk of packed rows */
    size_t first;        /* first row of the chunk */
    float *shown_rows;   /* rows of a chunk for the view, 4 · width floats each; NULL without a view */
} writing;

static bool is_of_mattes(const image_attribute *a) {
    return strncmp(a->name, IMAGE_MATTE_ENTRY, strlen(IMAGE_MATTE_ENTRY)) == 0;
}

static fathom_status choose_channels(writing *w, const image *img) {
    static const char *const names[] = {"R", "G", "B", "A"};
    w->shown.channels = w->channels;
    w->shown.channel_count = 0;
    while (w->shown.attribute_count && is_of_mattes(&img->attributes[w->shown.attribute_count - 1]))
        --w->shown.attribute_count;
    for (size_t i = 0; i < (w->format == IMAGE_JPEG ? 3 : 4); ++i) {
        const image_channel *channel = image_find_channel(img, names[i]);
        if (!channel && i == 3) break;
        if (!channel)
            return fail_file(w->context, FATHOM_INTERNAL, w->path, "the image has no channel %s", names[i]);
        w->channels[w->shown.channel_count++] = *channel;
    }
    /* These formats cannot describe a crop for all readers, so the file is the crop. */
    w->shown.x = w->shown.y = 0;
    w->shown.full_width = img->width, w->shown.full_height = img->height;
    return FATHOM_OK;
}

static size_t row_bytes(const writing *w) { return w->shown.channel_count * w->shown.width; }

static float *row_for_view(const writing *w, size_t y) { return w->shown_rows + 4 * w->shown.width * y; }

static void pack_rows(void *user, size_t begin, size_t end) {
    writing *w = user;
    for (size_t y = begin; y < end; ++y) {
        unsigned char *out = w->rows + y * row_bytes(w);
        if (w->view)
            pack_row_from_view(&w->packing, (uint32_t)(w->first + y), row_for_view(w, y), out);
        else
            pack_row_srgb(&w->packing, (uint32_t)(w->first + y), out);
    }
}

static void gather_rows(void *user, size_t begin, size_t end) {
    writing *w = user;
    for (size_t y = begin; y < end; ++y)
        pack_row_for_view(&w->packing, (uint32_t)(w->first + y), row_for_view(w, y));
}

static size_t rows_from(const writing *w, size_t first) {
    size_t left = w->shown.height - first;
    return left < w->chunk ? left : w->chunk;
}

static fathom_status apply_view(writing *w, size_t rows) {
    image_message message = {""};
    loop_parallel(w->threads, rows, 4, gather_rows, w);
    const fathom_status status =
        image_calls.view_apply(w->view, w->threads, w->shown_rows, rows * w->shown.width, &message);
    if (status == FATHOM_OK) return status;
    return fail_file(w->context, status, w->path, "OpenColorIO%s%s", message.text[0] ? ": " : " failed",
                     message.text);
}

static fathom_status write_chunks(writing *w, image_writer *writer, image_message *message) {
    for (w->first = 0; w->first < w->shown.height; w->first += w->chunk) {
        const size_t rows = rows_from(w, w->first);
        fathom_status status = w->view ? apply_view(w, rows) : FATHOM_OK;
        if (status != FATHOM_OK) return status;
        loop_parallel(w->threads, rows, 4, pack_rows, w);
        status = w->calls->rows(writer, (uint32_t)rows, w->rows, message);
        if (status != FATHOM_OK)
            return fail_file(w->context, status, w->path, "cannot be written: %s", message->text);
    }
    return FATHOM_OK;
}

static fathom_status write_exr(const writing *w, file_writer *file) {
    const exr_options options = {.float_color = w->float_color,
                                 .compressed = true,
                                 .threads = w->threads,
                                 .date = w->date.text[0] ? w->date.text : NULL};
    return exr_put(w->context, file, &w->shown, &options);
}

static fathom_status write_bytes(writing *w, file_writer *file) {
    image_message message = {""};
    image_target target = {.path = w->path,
                           .file = file,
                           .descriptor = file_writer_descriptor(file),
                           .format = w->format,
                           .threads = w->threads,
                           .srgb = w->srgb,
                           .date = w->date.text[0] ? w->date.text : NULL,
                           .img = &w->shown};
    image_writer *writer;
    fathom_status status = w->calls->open(&target, &writer, &message);
    if (status != FATHOM_OK)
        return fail_file(w->context, status, w->path, "cannot be written: %s", message.text);
    status = write_chunks(w, writer, &message);
    fathom_status closed = w->calls->close(writer, status == FATHOM_OK, &message);
    if (status == FATHOM_OK && closed != FATHOM_OK) {
        status = fail_file(w->context, closed, w->path, "cannot be written: %s", message.text);
    }
    return status;
}

/* A view's floats take more memory than the packed rows. */
static size_t chunk_rows(const writing *w) {
    const size_t bytes = w->view ? 4 * sizeof(float) * w->shown.width : row_bytes(w);
    size_t rows = w->format == IMAGE_TIFF ? CHUNK_BYTES / bytes / CHUNK_ROWS * CHUNK_ROWS : CHUNK_ROWS;
    if (rows < CHUNK_ROWS) rows = CHUNK_ROWS;
    return rows < w->shown.height ? rows : w->shown.height;
}

static fathom_status allocate_rows(writing *w) {
    w->chunk = chunk_rows(w);
    size_t view_bytes = w->view ? sizeof(float) * 4 * w->shown.width * w->chunk : 1;
    w->rows = malloc(w->chunk * row_bytes(w));
    w->shown_rows = malloc(view_bytes);
    if (w->rows && w->shown_rows) return FATHOM_OK;
    return fail_memory(w->context, w->chunk * row_bytes(w) + view_bytes);
}

static fathom_status write_rows(writing *w, file_writer *file) {
    fathom_status status = allocate_rows(w);
    if (status == FATHOM_OK) status = write_bytes(w, file);
    free(w->rows), free(w->shown_rows);
    return status;
}

/* Ends the file after a write that returned `status`. */
static fathom_status close_file(const writing *w, file_writer *file, fathom_status status) {
    if (w->rehearsal) file_writer_sync(file); /* its time is part of writing */
    if (status == FATHOM_OK && !w->rehearsal) return file_writer_commit(file);
    file_writer_abort(file);
    return status;
}

static fathom_status write_file(writing *w) {
    file_writer *file;
    fathom_status status = file_writer_open(w->context, w->path, &file);
    if (status != FATHOM_OK) return status;
    return close_file(w, file, w->format == IMAGE_EXR ? write_exr(w, file) : write_rows(w, file));
}

static fathom_status check_image(fathom_context *context, const image *img, const char *path,
                                 image_format format) {
    if (!img->width || !img->height || !img->channel_count) {
        return fail_file(context, FATHOM_INTERNAL, path, "the image is empty");
    }
    return output_check_size(context, path, format, img->width, img->height);
}

static fathom_status choose_view(writing *w, const fathom_write_options *options) {
    w->srgb = image_view_is_srgb(options);
    if (!w->srgb) return output_open_view(w->context, options, &w->view, &w->srgb);
    srgb_codes_fill(&w->srgb_codes);
    return FATHOM_OK;
}

/* The caller must set the context and `path`. */
static fathom_status write_image(writing *w, const image *img, const fathom_write_options *options) {
    fathom_context *context = w->context;
    w->threads = fathom_context_threads(context);
    fathom_status status = output_format(context, w->path, &w->format);
    if (status == FATHOM_OK) status = output_check_exposure(context, options);
    if (status == FATHOM_OK) status = date_read(context, &w->date);
    if (status == FATHOM_OK) status = check_image(context, img, w->path, w->format);
    if (status != FATHOM_OK) return status;
    w->calls = w->format == IMAGE_PNG ? &write_png_calls : &image_calls.writer;
    w->shown = *img;
    w->float_color = options->float_color;
    if (w->format == IMAGE_EXR) return write_file(w);
    status = choose_channels(w, img);
    if (status == FATHOM_OK) status = choose_view(w, options);
    w->packing = (image_packing){&w->shown, exp2f(options->exposure), &w->srgb_codes};
    if (status == FATHOM_OK) status = write_file(w);
    if (w->view) image_calls.view_close(w->view);
    return status;
}

fathom_status image_write(fathom_context *context, const image *img, const char *path,
                          const fathom_write_options *options) {
    writing w = {.context = context, .path = path};
    return write_image(&w, img, options);
}

fathom_status image_rehearse(fathom_context *context, const image *img, const char *path,
                             const fathom_write_options *options) {
    writing w = {.context = context, .path = path, .rehearsal = true};
    return write_image(&w, img, options);
}
