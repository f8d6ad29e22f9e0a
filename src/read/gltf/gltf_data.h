/* Arrays of numbers: buffers, buffer views, accessors. */
#pragma once

#include <stddef.h>

#include "base/file.h"
#include "read/gltf/gltf.h"

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "glTF buffers are little-endian and used in place");

/* The bytes of one file; the scene owns them once it uses pointers into them. */
struct gltf_source {
    file_map map;
    bool shared;
};

struct gltf_buffer {
    const unsigned char *bytes; /* NULL: not loaded yet */
    uint64_t size;
    gltf_source *source; /* NULL: the scene owns the bytes */
    bool owns_source;    /* false if `source` is the main file */
};

/* ---- gltf_buffer.c ---- */

/* Opens the file, finds its chunks and parses its JSON into g->root. */
void gltf_open(gltf *g);
fathom_status gltf_buffer_load(gltf *g, uint32_t index, gltf_buffer **out);
/* Transfers ownership of the buffer's bytes to the scene. Call it before the scene gets pointers into
 * them. */
void gltf_buffer_share(gltf *g, gltf_buffer *buffer);
/* gltf_is_data(): true if `uri` is a data URI. gltf_data_uri(): its bytes, owned by the scene;
 * if it is broken, an error, or a note for an image, which then has none. */
bool gltf_is_data(const char *uri);
void gltf_data_uri(gltf *g, const gltf_value *at, const char *uri, bool image, gltf_buffer *out);
/* The path of the image that a uri names; release it with free(). NULL: there is no such file, which adds a
 * note. */
char *gltf_image_path(gltf *g, const gltf_value *at, const char *uri);

/* ---- gltf_view.c ---- */

/* The bytes of a buffer view, decompressed if necessary, and the buffer that holds them. */
typedef struct gltf_view {
    const unsigned char *bytes;
    uint64_t length;
    gltf_buffer *buffer;
} gltf_view;

/* The bytes that the members `buffer`, `byteOffset` and `byteLength` of `at` describe. */
void gltf_view_part(gltf *g, const gltf_value *at, gltf_view *out);
/* *at receives the view, for messages. */
fathom_status gltf_view_open(gltf *g, uint32_t index, gltf_value *at, gltf_view *out);
/* *stride: that of elements side by side, if the view has none; 0 means none to programs that write it. */
void gltf_view_stride(gltf *g, const gltf_value *view, uint64_t *stride);

/* ---- gltf_packed.c ---- */

/* Decompresses view `index` once and opens the result. False: the view is not compressed. */
bool gltf_packed_open(gltf *g, const gltf_value *view, uint32_t index, gltf_view *out);

/* ---- gltf_accessor.c ---- */

/* An accessor's elements as an array that a mesh can use: finite floats, or 32-bit indices. */
typedef struct gltf_elements {
    const void *values; /* NULL: not made yet */
    size_t stride;      /* bytes */
    uint32_t count;
    mesh_facts facts;     /* the extremes, for floats with three components */
    uint32_t unpacked_of; /* 1 + the view that Draco unpacked them from; 0: the accessor's own elements */
} gltf_elements;

static inline const float *gltf_element(const gltf_elements *e, size_t i) {
    return mesh_row(e->values, e->stride, i);
}

/* The elements of an accessor, as floats [0] and as indices [1]. Draco's are apart: a compressed primitive
 * and another one may name the same accessor. */
struct gltf_arrays {
    gltf_elements own[2], unpacked[2];
};

/* Component types that are accepted, as bits. */
enum {
    GLTF_TAKES_FLOAT = 1u << 0,
    GLTF_TAKES_SIGNED = 1u << 1,   /* byte and short */
    GLTF_TAKES_UNSIGNED = 1u << 2, /* ubyte and ushort */
    GLTF_TAKES_UINT = 1u << 3,
    GLTF_TAKES_QUANTIZED = GLTF_TAKES_FLOAT | GLTF_TAKES_SIGNED | GLTF_TAKES_UNSIGNED
};

/* The accessor that member `key` of `user` names, as an array with this number of components. `takes` has the
 * accepted component types: with GLTF_TAKES_UINT the elements are indices, whose range is not checked,
 * otherwise floats. False, with *out empty, if there is no such member or reading has failed. */
bool gltf_array_read(gltf *g, const gltf_value *user, const char *key, unsigned components, unsigned takes,
                     gltf_elements *out);

/* The components of the accessor that member `key` of `user` names, 1 to 4; 0: there is no such member. */
unsigned gltf_components(gltf *g, const gltf_value *user, const char *key);

/* Elements for an accessor, unpacked from a view. */
typedef struct gltf_given {
    uint32_t view, count;
    unsigned components;
    bool integers, normalized; /* normalized: already divided by the maximum of the accessor's type */
    const void *values;
} gltf_given;

/* Stores a copy of `given` as the unpacked elements of the accessor that member `key` of `user` names, until
 * elements of another view are given: primitives may share an accessor of compressed elements, since it only
 * has their type and count. Count and components must be those of the accessor. */
void gltf_array_give(gltf *g, const gltf_value *user, const char *key, const gltf_given *given);

/* ---- gltf_draco.c ---- */

/* Sets g->unpacked. Decompresses the primitive if it is compressed, and stores the result as elements of its
 * accessors. */
void gltf_draco_read(gltf *g, const gltf_value *primitive);
void gltf_draco_close(gltf *g);

/* ---- gltf_attributes.c ----
 * Decodes what KHR_meshopt_compression adds to EXT_meshopt_compression, which meshoptimizer 0.22 and older do
 * not have: version 1 of the attribute codec, and the filter COLOR. Written from the extension's
 * specification, appendices A and B. Both functions return NULL, or what is wrong with the data as the end of
 * a sentence. */

/* The first byte of a stream of version 0 and of version 1. */
enum { GLTF_ATTRIBUTES_0 = 0xa0, GLTF_ATTRIBUTES_1 = 0xa1 };

/* Decodes a stream of version 1 into `count` elements of `stride` bytes at `to`. stride: a multiple of 4, 4
 * to 256. Reads no byte outside of the stream; after an error, `to` has any values. */
const char *gltf_attributes_decode(const unsigned char *bytes, size_t size, size_t count, size_t stride,
                                   unsigned char *to);

/* Converts `count` elements of `stride` bytes in place from YCoCg and alpha to red, green, blue and alpha.
 * stride: 4 for components of 8 bits, 8 for 16 bits. */
const char *gltf_colors_decode(unsigned char *elements, size_t count, size_t stride);
