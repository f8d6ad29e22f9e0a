/* In place of the image module: a library that ends the process, or waits for itself, in the way that
 * $FAULT_LOST names, as some of the image module's do when memory is lacking; while it is loaded, or where
 * the name begins with "rows-" or "texture-", when rows are written or texels read. Its views fail, and what
 * it reads is broken. */
#include "image/helper/module.h"

#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

static void lose(const char *way) {
    if (strcmp(way, "exit") == 0) exit(1);
    if (strcmp(way, "abort") == 0) abort();
    if (strcmp(way, "trap") == 0) raise(SIGTRAP);
    if (strcmp(way, "hang") == 0) {
        static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
        pthread_mutex_lock(&lock), pthread_mutex_lock(&lock);
    }
    volatile char *null = NULL;
    if (strcmp(way, "null") == 0) null[8] = 1;
    if (strcmp(way, "fault") == 0) {
        volatile char *page = mmap(NULL, 4096, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        page[0] = 1;
    }
}

static const char *way(void) {
    const char *name = getenv("FAULT_LOST");
    return name ? name : "";
}

static void __attribute__((constructor)) while_loading(void) { lose(way()); }

static void *on_own_thread(void *unused) {
    lose("null");
    return unused;
}

static char own_view;

static fathom_status open_nothing(const image_target *target, image_writer **out, image_message *message) {
    (void)target, (void)message;
    *out = (image_writer *)&own_view;
    return FATHOM_OK;
}

static fathom_status lose_rows(image_writer *writer, uint32_t count, const void *pixels,
                               image_message *message) {
    (void)writer, (void)count, (void)pixels, (void)message;
    pthread_t thread;
    if (strncmp(way(), "rows-", 5) == 0) lose(way() + 5);
    if (strcmp(way(), "rows-thread") == 0 && pthread_create(&thread, NULL, on_own_thread, NULL) == 0)
        pthread_join(thread, NULL);
    return FATHOM_OK;
}

static fathom_status close_nothing(image_writer *writer, bool finish, image_message *message) {
    (void)writer, (void)finish, (void)message;
    return FATHOM_OK;
}

static fathom_status fail_read(const char *path, unsigned threads, const image **out,
                               image_message *message) {
    (void)path, (void)threads, (void)out;
    snprintf(message->text, sizeof message->text, "is broken");
    return FATHOM_BAD_INPUT;
}

static fathom_status open_view(const image_view_request *request, image_view **out, bool *srgb,
                               image_message *message) {
    (void)request, (void)message;
    *out = (image_view *)&own_view, *srgb = false;
    return FATHOM_OK;
}

static fathom_status fail_view(const image_view *view, unsigned threads, float *rgba, size_t count,
                               image_message *message) {
    (void)view, (void)threads, (void)rgba, (void)count;
    if (strcmp(way(), "view") == 0) snprintf(message->text, sizeof message->text, "no such colour");
    return FATHOM_INTERNAL;
}

static void close_view(image_view *view) { (void)view; }

static fathom_status hash_nothing(const image_view_request *request, const char *space, uint64_t *out,
                                  image_message *message) {
    (void)request, (void)space, (void)message;
    *out = 0;
    return FATHOM_OK;
}

static fathom_status open_texture(const image_texture_request *request, image_texture **out,
                                  image_texture_info *info, image_message *message) {
    (void)request, (void)message;
    *out = (image_texture *)&own_view;
    *info = (image_texture_info){.width = 1, .height = 1, .channels = 3, .band = 1};
    return FATHOM_OK;
}

static fathom_status lose_texels(image_texture *texture, const image_region *region, void *texels,
                                 size_t bytes, image_message *message) {
    (void)texture, (void)region, (void)message;
    if (strncmp(way(), "texture-", 8) == 0) lose(way() + 8);
    memset(texels, 0, bytes);
    return FATHOM_OK;
}

static void close_texture(image_texture *texture) { (void)texture; }

__attribute__((visibility("default")))
const image_module fathom_image_module = {.version = IMAGE_MODULE_VERSION,
                                          .writer = {open_nothing, lose_rows, close_nothing},
                                          .read = fail_read,
                                          .view_open = open_view,
                                          .view_apply = fail_view,
                                          .view_close = close_view,
                                          .view_files = hash_nothing,
                                          .texture = {open_texture, lose_texels, close_texture},
                                          .libraries = "none"};
