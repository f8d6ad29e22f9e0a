/* The calls of module.h, each run in the helper. */
#include "base/file.h"
#include "image/helper/helper.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An object that is open in the helper. */
typedef struct remote {
    uint64_t object, process;
    unsigned threads;
    size_t pixel_bytes; /* of a writer */
    uint32_t width;
} remote;

static fathom_status ask(helper_exchange *e, image_message *message) {
    fathom_status status = helper_ask(e);
    if (status != FATHOM_OK) snprintf(message->text, sizeof message->text, "%s", e->reply.text);
    return status;
}

static fathom_status lacks_memory(image_message *message) {
    snprintf(message->text, sizeof message->text, "out of memory");
    return FATHOM_OUT_OF_RESOURCES;
}

/* Sends the request with the contents of `b`, and releases `b`. */
static fathom_status ask_with(helper_exchange *e, wire_buffer *b, image_message *message) {
    e->bytes = b->items, e->request.size = b->count;
    fathom_status status = b->lost ? lacks_memory(message) : ask(e, message);
    free(b->items);
    return status;
}

/* The same for a request that opens an object. If this process is out of memory, the object stays open until
 * the helper ends. */
static fathom_status open_with(helper_exchange *e, wire_buffer *b, image_message *message, remote **out) {
    fathom_status status = ask_with(e, b, message);
    if (status != FATHOM_OK) return status;
    *out = malloc(sizeof **out);
    if (!*out) return lacks_memory(message);
    **out = (remote){.object = e->reply.object, .process = e->process, .threads = e->request.threads};
    return FATHOM_OK;
}

static helper_exchange about(const remote *r, wire_op op) {
    return (helper_exchange){.request = {.op = op, .threads = r->threads, .object = r->object},
                             .descriptor = -1,
                             .process = r->process};
}

/* ---- writing ---- */

static fathom_status open_writer(const image_target *target, image_writer **out, image_message *message) {
    wire_buffer b = {NULL, 0, 0, false};
    helper_exchange e = {.request = {.op = WIRE_OPEN, .threads = target->threads},
                         .descriptor = target->descriptor};
    wire_put_text(&b, target->path);
    wire_put_u32(&b, target->format);
    wire_put_u32(&b, target->srgb);
    wire_put_u32(&b, target->mipmapped);
    wire_put_u32(&b, target->texel);
    wire_put_text(&b, target->date);
    wire_put_image(&b, target->img);
    remote *r;
    fathom_status status = open_with(&e, &b, message, &r);
    if (status != FATHOM_OK) return status;
    r->width = target->img->width;
    r->pixel_bytes = target->img->channel_count * image_texel_size(target->texel);
    *out = (image_writer *)(void *)r;
    return FATHOM_OK;
}

static fathom_status write_rows(image_writer *writer, uint32_t count, const void *pixels,
                                image_message *message) {
    const remote *r = (const remote *)(const void *)writer;
    helper_exchange e = about(r, WIRE_ROWS);
    e.bytes = pixels, e.request.count = count, e.request.size = r->pixel_bytes * r->width * count;
    return ask(&e, message);
}

static fathom_status next_level(image_writer *writer, uint32_t width, uint32_t height,
                                image_message *message) {
    remote *r = (remote *)(void *)writer;
    helper_exchange e = about(r, WIRE_LEVEL);
    e.request.count = (uint64_t)width << 32 | height;
    r->width = width;
    return ask(&e, message);
}

static fathom_status close_writer(image_writer *writer, bool finish, image_message *message) {
    remote *r = (remote *)(void *)writer;
    helper_exchange e = about(r, WIRE_CLOSE);
    e.request.count = finish;
    fathom_status status = ask(&e, message);
    free(r);
    return status;
}

/* ---- reading ---- */

/* An image that was read. All its pointers point into `bytes`. */
typedef struct read_image_memory {
    image img;
    wire_image parts;
    unsigned char *bytes;
} read_image_memory;

/* Sets the channels' planes, after checking the helper's sizes. */
static bool place_planes(read_image_memory *m, uint64_t described, uint64_t size) {
    const image *img = &m->parts.img;
    uint64_t at = (described + WIRE_ALIGNED - 1) / WIRE_ALIGNED * WIRE_ALIGNED;
    uint64_t plane = (uint64_t)img->width * img->height * sizeof(float);
    if (!img->width || !img->height || at > size || img->channel_count > (size - at) / plane) return false;
    for (size_t i = 0; i < img->channel_count; ++i) {
        m->parts.channels[i].data = m->bytes + at + i * plane;
        m->parts.channels[i].stride = sizeof(float);
    }
    m->img = *img;
    return true;
}

static void release_image(const image *img) {
    read_image_memory *m = (read_image_memory *)(uintptr_t)img;
    if (!m) return;
    wire_image_free(&m->parts);
    free(m->bytes);
    free(m);
}

static fathom_status take_image(void *user, const unsigned char *bytes, const wire_reply *reply) {
    read_image_memory *m = calloc(1, sizeof *m);
    if (!m) return FATHOM_OUT_OF_RESOURCES;
    m->bytes = malloc(reply->size ? reply->size : 1);
    fathom_status status = FATHOM_OUT_OF_RESOURCES;
    if (m->bytes && reply->object <= reply->size) {
        memcpy(m->bytes, bytes, reply->size);
        wire_cursor c = {m->bytes, m->bytes + reply->object, false};
        if (wire_take_image(&c, &m->parts) && place_planes(m, reply->object, reply->size)) status = FATHOM_OK;
    }
    if (status == FATHOM_OK)
        *(const image **)user = &m->img;
    else
        release_image(&m->img);
    return status;
}

/* The helper may have another working directory, so it gets an absolute path. */
static const char *whole_path(const char *path, char whole[PATH_MAX]) {
    return path && realpath(path, whole) ? whole : path;
}

static fathom_status read_image(const char *path, unsigned threads, const image **out,
                                image_message *message) {
    char whole[PATH_MAX];
    wire_buffer b = {NULL, 0, 0, false};
    helper_exchange e = {
        .request = {.op = WIRE_READ, .threads = threads}, .descriptor = -1, .take = take_image, .user = out};
    *out = NULL;
    wire_put_text(&b, whole_path(path, whole));
    fathom_status status = ask_with(&e, &b, message);
    return status != FATHOM_OK && !message->text[0] ? lacks_memory(message) : status;
}

/* ---- views ---- */

static fathom_status open_view(const image_view_request *request, image_view **out, bool *srgb,
                               image_message *message) {
    char whole[PATH_MAX];
    wire_buffer b = {NULL, 0, 0, false};
    helper_exchange e = {.request = {.op = WIRE_VIEW, .threads = 1}, .descriptor = -1};
    wire_put_text(&b, whole_path(request->config, whole));
    wire_put_text(&b, request->display);
    wire_put_text(&b, request->view);
    remote *r;
    fathom_status status = open_with(&e, &b, message, &r);
    if (status != FATHOM_OK) return status;
    *srgb = e.reply.flag != 0;
    *out = (image_view *)(void *)r;
    return FATHOM_OK;
}

/* Where the pixels of a reply go. */
typedef struct wanted_pixels {
    void *pixels;
    size_t bytes;
} wanted_pixels;

static fathom_status take_pixels(void *user, const unsigned char *bytes, const wire_reply *reply) {
    const wanted_pixels *to = user;
    if (reply->size != to->bytes) return FATHOM_INTERNAL;
    memcpy(to->pixels, bytes, to->bytes);
    return FATHOM_OK;
}

static fathom_status apply_view(const image_view *view, unsigned threads, float *rgba, size_t count,
                                image_message *message) {
    helper_exchange e = about((const remote *)(const void *)view, WIRE_APPLY);
    wanted_pixels to = {rgba, count * 4 * sizeof *rgba};
    e.request.threads = threads, e.request.count = count, e.request.size = to.bytes;
    e.bytes = rgba, e.take = take_pixels, e.user = &to;
    return ask(&e, message);
}

static void close_view(image_view *view) {
    helper_exchange e = about((const remote *)(const void *)view, WIRE_END_VIEW);
    helper_ask(&e);
    free(view);
}

static fathom_status hash_files(const image_view_request *request, const char *space, uint64_t *out,
                                image_message *message) {
    char whole[PATH_MAX];
    wire_buffer b = {NULL, 0, 0, false};
    helper_exchange e = {.request = {.op = WIRE_FILES, .threads = 1}, .descriptor = -1};
    wire_put_text(&b, whole_path(request->config, whole));
    wire_put_text(&b, request->display);
    wire_put_text(&b, request->view);
    wire_put_text(&b, space);
    const fathom_status status = ask_with(&e, &b, message);
    *out = status == FATHOM_OK ? e.reply.object : 0;
    return status;
}

/* ---- textures ---- */

static fathom_status take_info(void *user, const unsigned char *bytes, const wire_reply *reply) {
    wire_cursor c = {bytes, bytes + reply->size, false};
    return wire_take_texture(&c, user) ? FATHOM_OK : FATHOM_INTERNAL;
}

static fathom_status open_texture(const image_texture_request *request, image_texture **out,
                                  image_texture_info *info, image_message *message) {
    char file[PATH_MAX], config[PATH_MAX];
    wire_buffer b = {NULL, 0, 0, false};
    helper_exchange e = {
        .request = {.op = WIRE_TEXTURE, .threads = request->threads, .count = request->most_texels},
        .descriptor = request->descriptor,
        .helpers = request->helpers,
        .take = take_info,
        .user = info};
    wire_put_text(&b, whole_path(request->path, file));
    wire_put_text(&b, whole_path(request->config, config));
    wire_put_text(&b, request->space);
    wire_put_u32(&b, (uint32_t)request->most_side);
    remote *r;
    fathom_status status = open_with(&e, &b, message, &r);
    if (status == FATHOM_OK) *out = (image_texture *)(void *)r;
    if (status != FATHOM_OK && !message->text[0])
        snprintf(message->text, sizeof message->text, "the image helper gave a wrong description");
    return status;
}

static fathom_status read_region(image_texture *texture, const image_region *region, void *texels,
                                 size_t bytes, image_message *message) {
    wanted_pixels to = {texels, bytes};
    helper_exchange e = about((const remote *)(const void *)texture, WIRE_REGION);
    e.bytes = region, e.request.size = sizeof *region, e.request.count = bytes;
    e.take = take_pixels, e.user = &to;
    return ask(&e, message);
}

static void close_texture(image_texture *texture) {
    helper_exchange e = about((const remote *)(const void *)texture, WIRE_END_TEXTURE);
    helper_ask(&e);
    free(texture);
}

const image_module image_calls = {IMAGE_MODULE_VERSION,
                                  {open_writer, write_rows, close_writer},
                                  read_image,
                                  release_image,
                                  open_view,
                                  apply_view,
                                  close_view,
                                  hash_files,
                                  {open_texture, read_region, close_texture},
                                  next_level,
                                  NULL};

/* ---- reading ---- */

fathom_status image_read(fathom_context *context, const char *path, const image **out) {
    *out = NULL;
    /* Reports missing files, folders and empty files like all other readers. */
    file_map map;
    fathom_status status = file_open(context, path, &map);
    if (status != FATHOM_OK) return status;
    file_close(&map);
    image_message message = {""};
    status = image_calls.read(path, fathom_context_threads(context), out, &message);
    if (status == FATHOM_OK) return status;
    return fail_file(context, status, path, "cannot be read as an image: %s", message.text);
}

void image_release(const image *img) { image_calls.release(img); }
