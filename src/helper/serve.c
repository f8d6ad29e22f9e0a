/* The image helper: the process that runs OpenImageIO and OpenColorIO.
 *
 * The library starts the helper when the first image needs it. The helper ends when the library closes the
 * socket. If its libraries exit, abort, crash or hang, the renderer's process continues and reports the
 * failure. */
#include "image/helper/wire.h"

#include <dlfcn.h>
#include <limits.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#define MODULE_FILE "fathom_image.so"
#define PARTS_FILE "fathom_image.parts"

static const image_module *module;
static wire_memory memory = {.descriptor = WIRE_MEMORY};

static void say(wire_reply *reply, fathom_status status, const char *text) {
    reply->status = status;
    snprintf(reply->text, sizeof reply->text, "%s", text);
}

/* ---- loading ---- */

/* Loads the libraries that the module needs one by one, starting with those without dependencies. One
 * dlopen() of the module would search each symbol in all 260 libraries; loading them one by one takes half
 * the time. */
static void load_parts(const char *folder) {
    char path[PATH_MAX + sizeof PARTS_FILE], name[256];
    snprintf(path, sizeof path, "%s/" PARTS_FILE, folder);
    FILE *list = fopen(path, "re");
    while (list && fgets(name, sizeof name, list)) {
        name[strcspn(name, "\n")] = '\0';
        if (*name) dlopen(name, RTLD_NOW | RTLD_LOCAL);
    }
    if (list) fclose(list);
}

static bool own_folder(char folder[PATH_MAX]) {
    ssize_t length = readlink("/proc/self/exe", folder, PATH_MAX - 1);
    if (length <= 0) return false;
    folder[length] = '\0';
    *strrchr(folder, '/') = '\0';
    return true;
}

/* $FATHOM_IMAGE_MODULE replaces the module next to this program. */
static void load(wire_reply *reply) {
    char folder[PATH_MAX], path[PATH_MAX + sizeof MODULE_FILE];
    const char *named = getenv("FATHOM_IMAGE_MODULE");
    if (named && *named) {
        snprintf(path, sizeof path, "%s", named);
    } else if (own_folder(folder)) {
        snprintf(path, sizeof path, "%s/" MODULE_FILE, folder);
        load_parts(folder);
    } else {
        say(reply, FATHOM_OUT_OF_RESOURCES, "the folder of the image helper is not known: is /proc mounted?");
        return;
    }
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    const char *error = library ? NULL : dlerror();
    module = library ? dlsym(library, IMAGE_MODULE_SYMBOL) : NULL;
    if (module && module->version == IMAGE_MODULE_VERSION) {
        say(reply, FATHOM_OK, module->libraries ? module->libraries : "");
        return;
    }
    if (!library)
        say(reply, FATHOM_OUT_OF_RESOURCES, error ? error : "cannot be loaded");
    else
        say(reply, FATHOM_OUT_OF_RESOURCES, "the image module is of another build");
    module = NULL;
}

/* ---- requests ---- */

/* The id of a writer, view or texture is its address, which the library sends back. */
static uint64_t number_of(const void *object) { return (uint64_t)(uintptr_t)object; }
static void *object_of(const wire_request *request) { return (void *)(uintptr_t)request->object; }

static void open_file(const wire_request *request, int descriptor, wire_reply *reply,
                      image_message *message) {
    wire_cursor c = {memory.bytes, memory.bytes + request->size, false};
    image_target target = {.path = wire_take_text(&c), .descriptor = descriptor, .threads = request->threads};
    target.format = (image_format)wire_take_u32(&c);
    target.srgb = wire_take_u32(&c);
    target.mipmapped = wire_take_u32(&c);
    const uint32_t texel = wire_take_u32(&c);
    target.texel = texel <= IMAGE_TEXEL_FLOAT ? (image_texel)texel : IMAGE_TEXEL_U8;
    target.date = wire_take_text(&c);
    wire_image w;
    image_writer *writer = NULL;
    if (!target.path || !wire_take_image(&c, &w)) {
        say(reply, FATHOM_OUT_OF_RESOURCES, "out of memory");
        if (descriptor >= 0) close(descriptor);
        return;
    }
    target.img = &w.img;
    reply->status = module->writer.open(&target, &writer, message);
    reply->object = number_of(writer);
    wire_image_free(&w);
}

static void give_plane(const image_channel *channel, size_t count, unsigned char *to) {
    const char *from = channel->data;
    for (size_t i = 0; i < count; ++i, from += channel->stride, to += sizeof(float))
        memcpy(to, from, sizeof(float));
}

/* Puts the description, then the planes, into the shared memory. */
static bool give_image(const image *img, wire_reply *reply) {
    wire_buffer b = {NULL, 0, 0, false};
    const size_t count = (size_t)img->width * img->height, plane = count * sizeof(float);
    wire_put_image(&b, img);
    size_t at = (b.count + WIRE_ALIGNED - 1) / WIRE_ALIGNED * WIRE_ALIGNED,
           size = at + plane * img->channel_count;
    bool fits = !b.lost && wire_memory_reach(&memory, size, true);
    if (fits) {
        memcpy(memory.bytes, b.items, b.count);
        for (size_t i = 0; i < img->channel_count; ++i)
            give_plane(&img->channels[i], count, memory.bytes + at + i * plane);
        reply->object = b.count, reply->size = size;
    }
    free(b.items);
    return fits;
}

static void read_file(const wire_request *request, wire_reply *reply, image_message *message) {
    wire_cursor c = {memory.bytes, memory.bytes + request->size, false};
    const char *path = wire_take_text(&c);
    const image *img = NULL;
    reply->status = path ? module->read(path, request->threads, &img, message) : FATHOM_INTERNAL;
    if (reply->status != FATHOM_OK) return;
    if (!give_image(img, reply)) say(reply, FATHOM_OUT_OF_RESOURCES, "out of memory");
    module->release(img);
}

static image_view_request take_view(wire_cursor *c) {
    image_view_request wanted;
    wanted.config = wire_take_text(c), wanted.display = wire_take_text(c), wanted.view = wire_take_text(c);
    return wanted;
}

static void open_view(const wire_request *request, wire_reply *reply, image_message *message) {
    wire_cursor c = {memory.bytes, memory.bytes + request->size, false};
    const image_view_request wanted = take_view(&c);
    image_view *view = NULL;
    bool srgb = false;
    reply->status = c.bad ? FATHOM_INTERNAL : module->view_open(&wanted, &view, &srgb, message);
    reply->object = number_of(view);
    reply->flag = srgb;
}

static void hash_files(const wire_request *request, wire_reply *reply, image_message *message) {
    wire_cursor c = {memory.bytes, memory.bytes + request->size, false};
    const image_view_request wanted = take_view(&c);
    const char *space = wire_take_text(&c);
    reply->status = c.bad ? FATHOM_INTERNAL : module->view_files(&wanted, space, &reply->object, message);
}

static void open_texture(const wire_request *request, int descriptor, wire_reply *reply,
                         image_message *message) {
    wire_cursor c = {memory.bytes, memory.bytes + request->size, false};
    wire_buffer b = {NULL, 0, 0, false};
    image_texture_request wanted = {.descriptor = descriptor, .threads = request->threads};
    wanted.path = wire_take_text(&c), wanted.config = wire_take_text(&c), wanted.space = wire_take_text(&c);
    wanted.most_side = wire_take_u32(&c), wanted.most_texels = request->count;
    image_texture *texture = NULL;
    image_texture_info info;
    reply->status = c.bad ? FATHOM_INTERNAL : module->texture.open(&wanted, &texture, &info, message);
    if (reply->status != FATHOM_OK) return;
    wire_put_texture(&b, &info);
    reply->object = number_of(texture), reply->size = b.count;
    if (!b.lost && wire_memory_reach(&memory, b.count, true)) {
        memcpy(memory.bytes, b.items, b.count);
    } else {
        module->texture.close(texture);
        say(reply, FATHOM_OUT_OF_RESOURCES, "out of memory");
    }
    free(b.items);
}

static void read_region(const wire_request *request, wire_reply *reply, image_message *message) {
    image_region region;
    memcpy(&region, memory.bytes, sizeof region);
    if (!wire_memory_reach(&memory, request->count, true)) {
        say(reply, FATHOM_OUT_OF_RESOURCES, "out of memory");
        return;
    }
    reply->status = module->texture.read(object_of(request), &region, memory.bytes, request->count, message);
    reply->size = request->count;
}

/* ---- the loop ---- */

static void serve(const wire_request *request, int descriptor, wire_reply *reply) {
    image_message message = {""};
    if (!wire_memory_reach(&memory, request->size ? request->size : 1, true)) {
        say(reply, FATHOM_OUT_OF_RESOURCES, "out of memory");
        return;
    }
    switch ((wire_op)request->op) {
    case WIRE_OPEN: open_file(request, descriptor, reply, &message); break;
    case WIRE_ROWS:
        reply->status =
            module->writer.rows(object_of(request), (uint32_t)request->count, memory.bytes, &message);
        break;
    case WIRE_LEVEL:
        reply->status = module->writer_level(object_of(request), (uint32_t)(request->count >> 32),
                                             (uint32_t)request->count, &message);
        break;
    case WIRE_CLOSE:
        reply->status = module->writer.close(object_of(request), request->count != 0, &message);
        break;
    case WIRE_READ: read_file(request, reply, &message); break;
    case WIRE_VIEW: open_view(request, reply, &message); break;
    case WIRE_APPLY:
        reply->status = module->view_apply(object_of(request), request->threads,
                                           (float *)(void *)memory.bytes, request->count, &message);
        reply->size = request->size;
        break;
    case WIRE_END_VIEW: module->view_close(object_of(request)); break;
    case WIRE_TEXTURE: open_texture(request, descriptor, reply, &message); break;
    case WIRE_REGION: read_region(request, reply, &message); break;
    case WIRE_END_TEXTURE: module->texture.close(object_of(request)); break;
    case WIRE_FILES: hash_files(request, reply, &message); break;
    }
    if (message.text[0]) snprintf(reply->text, sizeof reply->text, "%s", message.text);
}

/* Ignores signals that end the processes of a terminal or job, because the renderer may still need to write
 * images. Disables core dumps, which are of no use to users. */
static void settle(void) {
    static const int ignored[] = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGXCPU, SIGPIPE, SIGXFSZ};
    for (size_t i = 0; i < sizeof ignored / sizeof *ignored; ++i) signal(ignored[i], SIG_IGN);
    setrlimit(RLIMIT_CORE, &(struct rlimit){0, 0});
}

int main(void) {
    wire_request request;
    wire_reply reply = {.version = WIRE_VERSION};
    int descriptor = -1;
    settle();
    load(&reply);
    while (wire_send(WIRE_SOCKET, &reply, sizeof reply, -1) && module &&
           wire_receive(WIRE_SOCKET, &request, sizeof request, -1, &descriptor) == WIRE_CAME) {
        reply = (wire_reply){.version = WIRE_VERSION};
        serve(&request, descriptor, &reply);
    }
    /* Skips the destructors of 260 libraries. */
    _exit(0);
}
