#include "image/helper/wire.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the shared memory ---- */

/* posix_fallocate() fails when out of memory or above ulimit -f. Without it, writing to unallocated pages
 * would cause SIGBUS. */
static bool grow_file(int descriptor, size_t size) {
    errno = posix_fallocate(descriptor, 0, (off_t)size);
    return errno == 0;
}

bool wire_memory_reach(wire_memory *m, size_t size, bool grow) {
    struct stat info;
    if (size <= m->size) return true;
    if (fstat(m->descriptor, &info) != 0) return false;
    size_t there = (size_t)info.st_size;
    if (there < size && (!grow || !grow_file(m->descriptor, size))) return false;
    if (there < size) there = size;
    void *bytes = mmap(NULL, there, PROT_READ | PROT_WRITE, MAP_SHARED, m->descriptor, 0);
    if (bytes == MAP_FAILED) return false;
    if (m->bytes) munmap(m->bytes, m->size);
    m->bytes = bytes, m->size = there;
    return true;
}

void wire_memory_release(wire_memory *m) {
    if (m->bytes) munmap(m->bytes, m->size);
    if (m->descriptor >= 0) close(m->descriptor);
    *m = (wire_memory){.descriptor = -1};
}

/* ---- its contents ---- */

static void wire_put(wire_buffer *b, const void *bytes, size_t size) {
    if (!b->lost && b->capacity - b->count < size) {
        size_t room = 2 * b->capacity + size;
        unsigned char *grown = realloc(b->items, room);
        b->lost = !grown;
        if (grown) b->items = grown, b->capacity = room;
    }
    if (b->lost) return;
    if (size) memcpy(b->items + b->count, bytes, size);
    b->count += size;
}

void wire_put_u32(wire_buffer *b, uint32_t value) { wire_put(b, &value, sizeof value); }

void wire_put_text(wire_buffer *b, const char *text) {
    wire_put_u32(b, text ? (uint32_t)strlen(text) + 1 : 0);
    if (text) wire_put(b, text, strlen(text) + 1);
}

/* NULL if fewer bytes remain. */
static const void *wire_take(wire_cursor *c, size_t size) {
    if (c->bad || (size_t)(c->end - c->at) < size) {
        c->bad = true;
        return NULL;
    }
    c->at += size;
    return c->at - size;
}

uint32_t wire_take_u32(wire_cursor *c) {
    uint32_t value = 0;
    const void *from = wire_take(c, sizeof value);
    if (from) memcpy(&value, from, sizeof value);
    return value;
}

const char *wire_take_text(wire_cursor *c) {
    uint32_t size = wire_take_u32(c);
    const char *text = size ? wire_take(c, size) : NULL;
    if (!text || text[size - 1] == '\0') return text;
    c->bad = true;
    return NULL;
}

/* ---- an image's description ---- */

static void put_channel(wire_buffer *b, const image_channel *channel) {
    wire_put_text(b, channel->name);
    wire_put_u32(b, channel->type);
    wire_put_u32(b, channel->color);
}

void wire_put_image(wire_buffer *b, const image *img) {
    const uint32_t sizes[7] = {img->width,      img->height,      img->x,   img->y,
                               img->full_width, img->full_height, img->bits};
    for (int i = 0; i < 7; ++i) wire_put_u32(b, sizes[i]);
    wire_put_u32(b, (uint32_t)img->channel_count);
    wire_put_u32(b, (uint32_t)img->attribute_count);
    for (size_t i = 0; i < img->channel_count; ++i) put_channel(b, &img->channels[i]);
    for (size_t i = 0; i < img->attribute_count; ++i) {
        wire_put_text(b, img->attributes[i].name);
        wire_put_text(b, img->attributes[i].text);
    }
}

static bool take_channels(wire_cursor *c, wire_image *out) {
    for (size_t i = 0; i < out->img.channel_count; ++i) {
        image_channel *channel = &out->channels[i];
        channel->name = wire_take_text(c);
        channel->type = wire_take_u32(c) == IMAGE_UINT ? IMAGE_UINT : IMAGE_FLOAT;
        channel->color = wire_take_u32(c) != 0;
        if (c->bad || !channel->name) return false;
    }
    return true;
}

static bool take_attributes(wire_cursor *c, const wire_image *out) {
    for (size_t i = 0; i < out->img.attribute_count; ++i) {
        out->attributes[i].name = wire_take_text(c);
        out->attributes[i].text = wire_take_text(c);
        if (c->bad || !out->attributes[i].name) return false;
    }
    return true;
}

/* A channel takes at least 12 bytes and an attribute at least 8, which limits their counts. */
bool wire_take_image(wire_cursor *c, wire_image *out) {
    *out = (wire_image){.channels = NULL};
    image *img = &out->img;
    uint32_t *sizes[7] = {&img->width,      &img->height,      &img->x,   &img->y,
                          &img->full_width, &img->full_height, &img->bits};
    for (int i = 0; i < 7; ++i) *sizes[i] = wire_take_u32(c);
    img->channel_count = wire_take_u32(c);
    img->attribute_count = wire_take_u32(c);
    size_t left = (size_t)(c->end - c->at);
    if (c->bad || img->channel_count > left / 12 || img->attribute_count > left / 8) return false;
    out->channels = calloc(img->channel_count + 1, sizeof *out->channels);
    out->attributes = calloc(img->attribute_count + 1, sizeof *out->attributes);
    img->channels = out->channels, img->attributes = out->attributes;
    bool there = out->channels && out->attributes;
    if (there && take_channels(c, out) && take_attributes(c, out)) return true;
    wire_image_free(out);
    return false;
}

void wire_image_free(wire_image *w) {
    free(w->channels), free(w->attributes);
    *w = (wire_image){.channels = NULL};
}

/* ---- a texture's description ---- */

void wire_put_texture(wire_buffer *b, const image_texture_info *info) {
    const uint32_t numbers[] = {info->width,          info->height, info->channels,  (uint32_t)info->sent,
                                (uint32_t)info->kept, info->band,   info->mipmapped, info->integers};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; ++i) wire_put_u32(b, numbers[i]);
    wire_put_text(b, info->format);
    wire_put_u32(b, (uint32_t)info->transfer);
}

bool wire_take_texture(wire_cursor *c, image_texture_info *out) {
    *out = (image_texture_info){.width = wire_take_u32(c)};
    out->height = wire_take_u32(c), out->channels = wire_take_u32(c);
    const uint32_t sent = wire_take_u32(c), kept = wire_take_u32(c);
    out->band = wire_take_u32(c);
    out->mipmapped = wire_take_u32(c) != 0;
    out->integers = wire_take_u32(c) != 0;
    const char *format = wire_take_text(c);
    const uint32_t transfer = wire_take_u32(c);
    if (c->bad || !format || !out->width || !out->height || !out->band || out->channels - 1 > 3 ||
        sent > IMAGE_TEXEL_FLOAT || kept > IMAGE_TEXEL_FLOAT || transfer > IMAGE_TRANSFER_OTHER)
        return false;
    out->sent = (image_texel)sent, out->kept = (image_texel)kept;
    out->transfer = (image_transfer)transfer;
    snprintf(out->format, sizeof out->format, "%.31s", format);
    return true;
}

/* ---- a message ---- */

bool wire_send(int socket, const void *message, size_t size, int descriptor) {
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control = {.room = {0}};
    struct iovec part = {.iov_base = (void *)(uintptr_t)message, .iov_len = size};
    struct msghdr m = {.msg_iov = &part, .msg_iovlen = 1};
    if (descriptor >= 0) {
        m.msg_control = &control, m.msg_controllen = sizeof control.room;
        control.head = (struct cmsghdr){
            .cmsg_len = CMSG_LEN(sizeof(int)), .cmsg_level = SOL_SOCKET, .cmsg_type = SCM_RIGHTS};
        memcpy(CMSG_DATA(&control.head), &descriptor, sizeof descriptor);
    }
    ssize_t sent;
    do sent = sendmsg(socket, &m, MSG_NOSIGNAL);
    while (sent < 0 && errno == EINTR);
    return sent == (ssize_t)size;
}

static wire_result wait_for(int socket, int milliseconds) {
    struct pollfd wanted = {.fd = socket, .events = POLLIN};
    int found;
    do found = poll(&wanted, 1, milliseconds);
    while (found < 0 && errno == EINTR);
    return found > 0 ? WIRE_CAME : found == 0 ? WIRE_LATE : WIRE_GONE;
}

wire_result wire_receive(int socket, void *message, size_t size, int milliseconds, int *descriptor) {
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(sizeof(int))];
    } control = {.room = {0}};
    struct iovec part = {.iov_base = message, .iov_len = size};
    struct msghdr m = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control.room};
    wire_result waited = wait_for(socket, milliseconds);
    if (waited != WIRE_CAME) return waited;
    ssize_t got;
    do got = recvmsg(socket, &m, MSG_CMSG_CLOEXEC);
    while (got < 0 && errno == EINTR);
    int came = -1;
    if (got >= 0 && m.msg_controllen >= sizeof(struct cmsghdr) && control.head.cmsg_type == SCM_RIGHTS)
        memcpy(&came, CMSG_DATA(&control.head), sizeof came);
    if (descriptor)
        *descriptor = came;
    else if (came >= 0)
        close(came);
    return got == (ssize_t)size ? WIRE_CAME : WIRE_GONE;
}
