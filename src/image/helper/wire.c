#include "image/helper/wire.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

/* ---- the shared memory ---- */

/* posix_fallocate() fails where there is no memory, or where ulimit -f forbids it; writing to what was not
 * allocated would be a SIGBUS. */
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

/* ---- what is put into it ---- */

void wire_put(wire_buffer *b, const void *bytes, size_t size) {
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

const void *wire_take(wire_cursor *c, size_t size) {
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
