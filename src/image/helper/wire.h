/* What the library and its image helper say to each other.
 *
 * Requests and replies are structs of a fixed size over a socket; everything of variable size lies in memory
 * that both have mapped. One request is under way at a time. The helper sends one reply unasked: once it has
 * loaded its libraries. The library trusts no reply: it checks every size and text that it reads from the
 * shared memory. */
#ifndef IMAGE_HELPER_WIRE_H
#define IMAGE_HELPER_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Descriptors of the helper. */
#define WIRE_SOCKET 3
#define WIRE_MEMORY 4

/* Grows with every change of what is said. */
#define WIRE_VERSION 1u

typedef enum wire_op {
    WIRE_OPEN,  /* begins a file; the request carries its descriptor; the memory holds a wire image */
    WIRE_ROWS,  /* `count` rows of `object`; the memory holds their `size` bytes */
    WIRE_CLOSE, /* ends `object`; count 0: the file is abandoned */
    WIRE_READ,  /* the memory holds a path; in the end it holds a wire image and its planes */
    WIRE_VIEW,  /* the memory holds config, display and view */
    WIRE_APPLY, /* the view `object`, on `count` pixels of four floats in the memory */
    WIRE_END_VIEW
} wire_op;

typedef struct wire_request {
    uint32_t op, threads;
    uint64_t object, count, size;
} wire_request;

typedef struct wire_reply {
    uint32_t version, status; /* fathom_status */
    uint64_t object, size;
    uint32_t flag; /* of a view: it ends in sRGB */
    char text[1024];
} wire_reply;

/* ---- the shared memory ---- */

typedef struct wire_memory {
    int descriptor;
    unsigned char *bytes;
    size_t size; /* of the mapping */
} wire_memory;

/* Maps at least `size` bytes. grow: makes the file larger where it is smaller; else that fails. False when
 * there is no memory. */
bool wire_memory_reach(wire_memory *m, size_t size, bool grow);
void wire_memory_release(wire_memory *m);

/* ---- what is put into it ---- */

typedef struct wire_buffer {
    unsigned char *items; /* release with free() */
    size_t count, capacity;
    bool lost; /* out of memory */
} wire_buffer;

void wire_put(wire_buffer *b, const void *bytes, size_t size);
void wire_put_u32(wire_buffer *b, uint32_t value);
/* NULL stays NULL. */
void wire_put_text(wire_buffer *b, const char *text);

typedef struct wire_cursor {
    const unsigned char *at, *end;
    bool bad; /* something that was asked for is not there: everything read since is 0, NULL or "" */
} wire_cursor;

/* NULL when there are not so many bytes. */
const void *wire_take(wire_cursor *c, size_t size);
uint32_t wire_take_u32(wire_cursor *c);
/* Lies in the memory; NULL where NULL was put. */
const char *wire_take_text(wire_cursor *c);

/* ---- a message ---- */

/* Whole messages; descriptor: sent along, -1 for none. False when the other side is gone. */
bool wire_send(int socket, const void *message, size_t size, int descriptor);
/* Waits for up to `milliseconds`, -1: without end. *descriptor, where it is not NULL, becomes what was sent
 * along, or -1. */
typedef enum wire_result { WIRE_CAME, WIRE_GONE, WIRE_LATE } wire_result;
wire_result wire_receive(int socket, void *message, size_t size, int milliseconds, int *descriptor);

#endif
