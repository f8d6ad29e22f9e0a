#include "base/file.h"
#include "base/pool.h"
#include "base/threads.h"
#include "image/helper/helper.h"
#include "image/output.h"
#include "image/pack.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rows are written in chunks of about this size: large enough for all compression threads, but much smaller
 * than a second copy of a large image. */
#define CHUNK_BYTES ((size_t)16 << 20)
#define CHUNK_ROWS 64u

static const image_channel *find_channel(const image *img, const char *name) {
    for (size_t i = 0; i < img->channel_count; ++i) {
        const image_channel *channel = &img->channels[i];
        if (channel->type == IMAGE_FLOAT && strcmp(channel->name, name) == 0) return channel;
    }
    return NULL;
}

/* A file that is being written. */
typedef struct writing {
    fathom_context *context;
    const char *path;
    const image_writer_calls *calls;
    image_format format;
    image_date date;
    image shown; /* the part of the image that the file will hold */
    image_channel *channels;
    image_storage *storage;
    image_packing packing;
    image_view *view; /* NULL: srgb_codes */
    srgb_codes srgb_codes;
    bool srgb, rehearsal;
    unsigned char **bytes; /* NULL: writes to a file */
    size_t *size;
    unsigned threads;

    size_t chunk;           /* rows per call of the writer */
    unsigned char *rows[2]; /* chunks of packed rows; the second only if one is packed ahead */
    size_t first;           /* first row to pack */
    unsigned into;          /* index in rows[] of the chunk to fill */
    float *shown_rows;      /* rows of a chunk for the view, 4 · width floats each; NULL without a view */
    fathom_status viewed;   /* the view's status for the last chunk */
    image_message message;  /* its reason */
} writing;

static bool is_of_mattes(const image_attribute *a) {
    return strncmp(a->name, IMAGE_MATTE_ENTRY, strlen(IMAGE_MATTE_ENTRY)) == 0;
}

static fathom_status choose_channels(writing *w, const image *img, const fathom_write_options *options) {
    w->shown = *img;
    w->shown.channels = w->channels;
    w->shown.channel_count = 0;
    size_t *count = &w->shown.channel_count;
    if (w->format == IMAGE_EXR) {
        for (size_t i = 0; i < img->channel_count; ++i) {
            const image_channel *channel = &img->channels[i];
            bool half = channel->color && !options->float_color;
            w->storage[*count] = channel->type == IMAGE_UINT ? IMAGE_STORE_UINT
                                 : half                      ? IMAGE_STORE_HALF
                                                             : IMAGE_STORE_FLOAT;
            w->channels[(*count)++] = *channel;
        }
        return FATHOM_OK;
    }
    while (w->shown.attribute_count && is_of_mattes(&img->attributes[w->shown.attribute_count - 1]))
        --w->shown.attribute_count;
    static const char *const names[] = {"R", "G", "B", "A"};
    for (size_t i = 0; i < (w->format == IMAGE_JPEG ? 3 : 4); ++i) {
        const image_channel *channel = find_channel(img, names[i]);
        if (!channel && i == 3) break;
        if (!channel)
            return fail_file(w->context, FATHOM_INTERNAL, w->path, "the image has no channel %s", names[i]);
        w->storage[*count] = IMAGE_STORE_U8;
        w->channels[(*count)++] = *channel;
    }
    /* These formats cannot describe a crop for all readers, so the file is the crop. */
    w->shown.x = w->shown.y = 0;
    w->shown.full_width = img->width, w->shown.full_height = img->height;
    return FATHOM_OK;
}

/* These formats compress on one thread, so other threads can pack the next rows. */
static bool packs_ahead(const writing *w) {
    return w->threads > 1 && (w->format == IMAGE_PNG || w->format == IMAGE_JPEG);
}

static float *row_for_view(const writing *w, size_t y) { return w->shown_rows + 4 * w->shown.width * y; }

static void pack_rows(void *user, size_t begin, size_t end, unsigned worker) {
    writing *w = user;
    (void)worker;
    size_t row_bytes = w->packing.pixel_bytes * w->shown.width;
    for (size_t y = begin; y < end; ++y) {
        unsigned char *out = w->rows[w->into] + y * row_bytes;
        if (w->format == IMAGE_EXR) {
            pack_row(&w->packing, (uint32_t)(w->first + y), out);
            continue;
        }
        if (w->view)
            pack_row_from_view(&w->packing, (uint32_t)(w->first + y), row_for_view(w, y), out);
        else
            pack_row_srgb(&w->packing, (uint32_t)(w->first + y), out);
    }
}

static void gather_rows(void *user, size_t begin, size_t end, unsigned worker) {
    writing *w = user;
    (void)worker;
    for (size_t y = begin; y < end; ++y)
        pack_row_for_view(&w->packing, (uint32_t)(w->first + y), row_for_view(w, y));
}

static fathom_status pack_failure(const writing *w) {
    if (!w->message.text[0]) return fail_file(w->context, w->viewed, w->path, "OpenColorIO failed");
    return fail_file(w->context, w->viewed, w->path, "OpenColorIO: %s", w->message.text);
}

static size_t rows_from(const writing *w, size_t first) {
    size_t left = w->shown.height - first;
    return left < w->chunk ? left : w->chunk;
}

static void pack_chunk(void *user) {
    writing *w = user;
    size_t rows = rows_from(w, w->first);
    if (w->view) {
        loop_parallel(w->threads, rows, 4, gather_rows, w);
        w->viewed =
            image_calls.view_apply(w->view, w->threads, w->shown_rows, rows * w->shown.width, &w->message);
        if (w->viewed != FATHOM_OK) return;
    }
    loop_parallel(w->threads, rows, 4, pack_rows, w);
}

/* Writes the rows from `first` on. If it is useful, packs the next chunk at the same time. */
static fathom_status write_chunk(writing *w, image_writer *writer, size_t first, image_message *message) {
    const unsigned char *rows = w->rows[w->into];
    pool_task ahead = {.run = pack_chunk, .user = w};
    size_t count = rows_from(w, first);
    w->first = first + count;
    bool more = w->first < w->shown.height;
    if (w->rows[1]) w->into ^= 1;
    bool runs = more && w->rows[1] && pool_run(&ahead);
    fathom_status status = w->calls->rows(writer, (uint32_t)count, rows, message);
    if (runs)
        pool_wait(&ahead, -1);
    else if (more && status == FATHOM_OK)
        pack_chunk(w);
    return status;
}

static fathom_status write_rows(writing *w, image_writer *writer, image_message *message) {
    w->first = 0;
    pack_chunk(w);
    for (size_t first = 0; first < w->shown.height; first += w->chunk) {
        if (w->viewed != FATHOM_OK) return pack_failure(w);
        fathom_status status = write_chunk(w, writer, first, message);
        if (status != FATHOM_OK)
            return fail_file(w->context, status, w->path, "cannot be written: %s", message->text);
    }
    return FATHOM_OK;
}

static fathom_status write_to(writing *w, file_writer *file) {
    image_message message = {""};
    image_target target = {.path = w->path,
                           .file = file,
                           .descriptor = file_writer_descriptor(file),
                           .format = w->format,
                           .threads = w->threads,
                           .srgb = w->srgb,
                           .date = w->date.text[0] ? w->date.text : NULL,
                           .img = &w->shown,
                           .storage = w->storage};
    image_writer *writer;
    fathom_status status = w->calls->open(&target, &writer, &message);
    if (status != FATHOM_OK)
        return fail_file(w->context, status, w->path, "cannot be written: %s", message.text);
    status = write_rows(w, writer, &message);
    fathom_status closed = w->calls->close(writer, status == FATHOM_OK, &message);
    if (status == FATHOM_OK && closed != FATHOM_OK) {
        status = fail_file(w->context, closed, w->path, "cannot be written: %s", message.text);
    }
    return status;
}

/* A view's floats take more memory than the packed rows. */
static size_t chunk_rows(const writing *w, size_t row_bytes) {
    if (w->view) row_bytes = 4 * sizeof(float) * w->shown.width;
    size_t rows = packs_ahead(w) ? CHUNK_ROWS : CHUNK_BYTES / row_bytes / CHUNK_ROWS * CHUNK_ROWS;
    if (rows < CHUNK_ROWS) rows = CHUNK_ROWS;
    return rows < w->shown.height ? rows : w->shown.height;
}

static fathom_status allocate_rows(writing *w) {
    size_t row_bytes = w->packing.pixel_bytes * w->shown.width;
    w->chunk = chunk_rows(w, row_bytes);
    size_t view_bytes = w->view ? sizeof(float) * 4 * w->shown.width * w->chunk : 1;
    w->rows[0] = malloc(w->chunk * row_bytes);
    w->rows[1] = packs_ahead(w) ? malloc(w->chunk * row_bytes) : NULL;
    w->shown_rows = malloc(view_bytes);
    if (w->rows[0] && (w->rows[1] || !packs_ahead(w)) && w->shown_rows) return FATHOM_OK;
    return fail_memory(w->context, w->chunk * row_bytes + view_bytes);
}

static fathom_status open_file(const writing *w, file_writer **out) {
    return w->bytes ? file_writer_open_memory(w->context, w->path, out)
                    : file_writer_open(w->context, w->path, out);
}

/* Ends the file after a write that returned `status`. */
static fathom_status close_file(const writing *w, file_writer *file, fathom_status status) {
    if (w->rehearsal) file_writer_sync(file); /* its time is part of writing */
    if (status == FATHOM_OK && w->bytes) return file_writer_take(file, w->bytes, w->size);
    if (status == FATHOM_OK && !w->rehearsal) return file_writer_commit(file);
    file_writer_abort(file);
    return status;
}

static fathom_status write_file(writing *w) {
    w->packing.img = &w->shown, w->packing.storage = w->storage;
    w->packing.srgb = &w->srgb_codes;
    for (size_t i = 0; i < w->shown.channel_count; ++i) {
        w->packing.pixel_bytes += pack_storage_size(w->storage[i]);
    }
    file_writer *file = NULL;
    fathom_status status = allocate_rows(w);
    if (status == FATHOM_OK) status = open_file(w, &file);
    if (status == FATHOM_OK) status = close_file(w, file, write_to(w, file));
    free(w->rows[0]), free(w->rows[1]), free(w->shown_rows);
    return status;
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

/* The caller must set the context, `path`, `bytes` and `size`. */
static fathom_status write_image(writing *w, const image *img, const fathom_write_options *options) {
    fathom_context *context = w->context;
    w->threads = fathom_context_threads(context);
    fathom_status status = output_format(context, w->path, &w->format);
    if (status == FATHOM_OK) status = output_check_exposure(context, options);
    if (status == FATHOM_OK) status = date_read(context, &w->date);
    if (status == FATHOM_OK) status = check_image(context, img, w->path, w->format);
    if (status != FATHOM_OK) return status;
    w->calls = w->format == IMAGE_PNG ? &write_png_calls : &image_calls.writer;
    w->packing.gain = exp2f(options->exposure);
    w->channels = calloc(img->channel_count, sizeof *w->channels);
    w->storage = calloc(img->channel_count, sizeof *w->storage);
    if (!w->channels || !w->storage) status = fail_memory(context, img->channel_count * sizeof *w->channels);
    if (status == FATHOM_OK) status = choose_channels(w, img, options);
    if (status == FATHOM_OK && w->format != IMAGE_EXR) status = choose_view(w, options);
    if (status == FATHOM_OK) status = write_file(w);
    if (w->view) image_calls.view_close(w->view);
    free(w->channels), free(w->storage);
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

fathom_status image_encode_png(fathom_context *context, const image *img, const fathom_write_options *options,
                               unsigned char **bytes, size_t *size) {
    writing w = {.context = context, .path = "image.png", .bytes = bytes, .size = size};
    *bytes = NULL, *size = 0;
    return write_image(&w, img, options);
}
