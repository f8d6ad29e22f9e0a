/* The protocol between the library and its image helper.
 *
 * Requests and replies are structs of fixed size, sent over a socket. Data of variable size lies in shared
 * memory. There is one request at a time. The helper sends one reply without a request, when it has loaded
 * its libraries. The library checks every size and text that it reads from the shared memory. */
#pragma once

#include "image/helper/module.h"

/* Descriptors of the helper. */
#define WIRE_SOCKET 3
#define WIRE_MEMORY 4

/* Increases with every change of the protocol. */
#define WIRE_VERSION 9u

typedef enum wire_op {
    WIRE_OPEN,  /* opens a file; its descriptor comes with the request; the memory holds a wire image */
    WIRE_ROWS,  /* `count` rows of `object`; the memory holds their `size` bytes */
    WIRE_LEVEL, /* the next level of `object`; `count` is its width times 2^32 plus its height */
    WIRE_CLOSE, /* ends `object`; count 0: the file is abandoned */
    WIRE_READ,  /* the memory holds a path, and afterwards a wire image and its planes */
    WIRE_VIEW,  /* the memory holds config, display and view */
    WIRE_APPLY, /* the view `object`, on `count` pixels of four floats in the memory */
    WIRE_END_VIEW,
    WIRE_TEXTURE, /* opens a texture; the memory holds the request, and afterwards its info */
    WIRE_REGION,  /* the memory holds a region of `object`, and afterwards its `count` bytes of texels */
    WIRE_END_TEXTURE,
    WIRE_FILES /* the memory holds config, display, view and color space; the reply's `object` is the hash */
} wire_op;

typedef struct wire_request {
    uint32_t op, threads;
    uint64_t object, count, size;
} wire_request;

typedef struct wire_reply {
    uint32_t version, status; /* fathom_status */
    uint64_t object, size;
    uint32_t flag; /* of a view: its result is sRGB */
    char text[1024];
} wire_reply;

/* ---- the shared memory ---- */

typedef struct wire_memory {
    int descriptor;
    unsigned char *bytes;
    size_t size; /* of the mapping */
} wire_memory;

/* Maps at least `size` bytes; `grow` enlarges the file if needed. False on failure. */
bool wire_memory_reach(wire_memory *m, size_t size, bool grow);
void wire_memory_release(wire_memory *m);

/* ---- its contents ---- */

typedef struct wire_buffer {
    unsigned char *items; /* release with free() */
    size_t count, capacity;
    bool lost; /* out of memory */
} wire_buffer;

void wire_put_u32(wire_buffer *b, uint32_t value);
/* NULL stays NULL. */
void wire_put_text(wire_buffer *b, const char *text);

typedef struct wire_cursor {
    const unsigned char *at, *end;
    bool bad; /* the bytes ended too early; all later reads return 0 or NULL */
} wire_cursor;

uint32_t wire_take_u32(wire_cursor *c);
/* The text stays in the shared memory; NULL if NULL was put. */
const char *wire_take_text(wire_cursor *c);

/* ---- an image's description: everything except its pixels, and numbers of its header ---- */

void wire_put_image(wire_buffer *b, const image *img);

/* Release the image's arrays with wire_image_free(); texts stay in the shared memory, pixels are NULL. */
typedef struct wire_image {
    image img;
    image_channel *channels;
    image_attribute *attributes;
} wire_image;

/* False when the description is incomplete or memory runs out. */
bool wire_take_image(wire_cursor *c, wire_image *out);
void wire_image_free(wire_image *w);

void wire_put_texture(wire_buffer *b, const image_texture_info *info);
/* False when a number is out of range. */
bool wire_take_texture(wire_cursor *c, image_texture_info *out);

/* Alignment of the planes that follow the description of a read image: width × height values of four bytes
 * each. */
#define WIRE_ALIGNED 64

/* ---- a message ---- */

/* Sends a message, with a descriptor unless it is -1. False if the other process has closed the socket. */
bool wire_send(int socket, const void *message, size_t size, int descriptor);
/* Waits for up to `milliseconds`; -1: no limit. *descriptor, unless NULL, receives the descriptor or -1. */
typedef enum wire_result { WIRE_CAME, WIRE_GONE, WIRE_LATE } wire_result;
wire_result wire_receive(int socket, void *message, size_t size, int milliseconds, int *descriptor);
