/* Buffer views that KHR_meshopt_compression or EXT_meshopt_compression compress: two names of one format.
 * meshoptimizer decodes indices, version 0 of attributes and three filters; gltf_attributes.c the rest. */
#include "read/gltf/gltf_data.h"

#ifdef FATHOM_MESHOPT
#include <meshoptimizer.h>
#endif
#include <stdio.h>
#include <string.h>

static const char *const names[] = {"KHR_meshopt_compression", "EXT_meshopt_compression"};

/* Sets *at to the extension of the view, whose name is at->at.key. A view must not have both. */
static void find_packed(gltf *g, const gltf_value *view, gltf_value *holder, gltf_value *at) {
    gltf_extension(g, view, names[0], holder, at);
    if (!at->json) gltf_extension(g, view, names[1], holder, at);
}

#ifdef FATHOM_MESHOPT

typedef struct packed {
    gltf_view from;
    uint64_t count, stride;
    enum { ATTRIBUTES, TRIANGLES, INDICES } mode;
    enum { NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL, COLOR } filter;
} packed;

/* The valid combinations by the extension; the decoders rely on them. */
static void check_stride(gltf *g, const gltf_value *at, const packed *p) {
    const uint64_t s = p->stride;
    const bool fine = p->mode != ATTRIBUTES                           ? s == 2 || s == 4
                      : p->filter == OCTAHEDRAL || p->filter == COLOR ? s == 4 || s == 8
                      : p->filter == QUATERNION                       ? s == 8
                                                                      : s % 4 == 0 && s <= 256;
    if (!s || !fine)
        gltf_fail(g, at, "byteStride", "is %llu, which does not go with the mode and the filter",
                  (unsigned long long)s);
    if (!p->count || (p->mode == TRIANGLES && p->count % 3))
        gltf_fail(g, at, "count", "is %llu; expected %s", (unsigned long long)p->count,
                  p->mode == TRIANGLES ? "a positive multiple of 3" : "a positive number");
    if (p->filter != NONE && p->mode != ATTRIBUTES)
        gltf_fail(g, at, "filter", "is given for indices; expected none");
}

static packed read_packed(gltf *g, const gltf_value *at) {
    char expected[64];
    snprintf(expected, sizeof expected, "one that %s has", at->at.key);
    packed out = {.count = 0};
    gltf_view_part(g, at, &out.from);
    gltf_integer(g, at, "byteStride", 1, 256, &out.stride);
    gltf_integer(g, at, "count", 1, UINT32_MAX, &out.count);
    out.mode = (unsigned)gltf_word(g, at, "mode", "ATTRIBUTES|TRIANGLES|INDICES", expected, -1);
    out.filter =
        (unsigned)gltf_word(g, at, "filter", "NONE|OCTAHEDRAL|QUATERNION|EXPONENTIAL|COLOR", expected, NONE);
    check_stride(g, at, &out);
    return out;
}

/* Like the functions of gltf_attributes.c, these return what is wrong with the data, or NULL. */

static const char *reason(int failed) { return failed ? "the data is broken" : NULL; }

/* The first byte decides, not the library: later versions of it decode version 1 too, and version 0.22
 * decodes a draft of it. */
static const char *decode_attributes(const packed *p, void *to) {
    const size_t count = (size_t)p->count, stride = (size_t)p->stride, size = (size_t)p->from.length;
    const unsigned char *bytes = p->from.bytes;
    if (bytes[0] == GLTF_ATTRIBUTES_1) return gltf_attributes_decode(bytes, size, count, stride, to);
    if (bytes[0] == GLTF_ATTRIBUTES_0)
        return reason(meshopt_decodeVertexBuffer(to, count, stride, bytes, size));
    return "the data begins with neither 0xa0 nor 0xa1, which are versions 0 and 1 of ATTRIBUTES";
}

static const char *apply_filter(const packed *p, void *to) {
    const size_t count = (size_t)p->count, stride = (size_t)p->stride;
    switch (p->filter) {
    case NONE: break;
    case OCTAHEDRAL: meshopt_decodeFilterOct(to, count, stride); break;
    case QUATERNION: meshopt_decodeFilterQuat(to, count, stride); break;
    case EXPONENTIAL: meshopt_decodeFilterExp(to, count, stride); break;
    case COLOR: return gltf_colors_decode(to, count, stride);
    }
    return NULL;
}

static const char *decode(const packed *p, void *to) {
    const size_t count = (size_t)p->count, stride = (size_t)p->stride, size = (size_t)p->from.length;
    const char *wrong = NULL;
    switch (p->mode) {
    case TRIANGLES: return reason(meshopt_decodeIndexBuffer(to, count, stride, p->from.bytes, size));
    case INDICES: return reason(meshopt_decodeIndexSequence(to, count, stride, p->from.bytes, size));
    case ATTRIBUTES: wrong = decode_attributes(p, to); break;
    }
    return wrong ? wrong : apply_filter(p, to);
}

static void unpack(gltf *g, const gltf_value *at, gltf_buffer *out) {
    const packed p = read_packed(g, at);
    void *memory;
    if (gltf_allocate(g, at, NULL, p.count * p.stride, &memory) != FATHOM_OK) return;
    const char *wrong = decode(&p, memory);
    if (wrong)
        gltf_fail(g, at, NULL, "cannot be unpacked: %s", wrong);
    else
        *out = (gltf_buffer){.bytes = memory, .size = p.count * p.stride};
}

static void open_packed(gltf *g, const gltf_value *view, uint32_t index, const gltf_value *at,
                        gltf_view *out) {
    gltf_buffer *kept = &g->view_table[index];
    if (!kept->bytes) unpack(g, at, kept);
    gltf_integer(g, view, "byteLength", 1, INT64_MAX, &out->length);
    if (out->length > kept->size)
        gltf_fail(g, view, "byteLength", "is %llu; what it unpacks to has %llu bytes",
                  (unsigned long long)out->length, (unsigned long long)kept->size);
    out->bytes = kept->bytes, out->buffer = kept;
}

#else

/* Without the library: uses the uncompressed fallback buffer, which not every file has. */
static void open_packed(gltf *g, const gltf_value *view, uint32_t index, const gltf_value *at,
                        gltf_view *out) {
    (void)index;
    if (gltf_requires(g, at->at.key))
        gltf_fail(g, at, NULL,
                  "needs meshoptimizer, but this Fathom was built without it; build it with "
                  "libmeshoptimizer-dev (Debian), or export the model without the extension");
    gltf_view_part(g, view, out);
}

#endif

bool gltf_packed_open(gltf *g, const gltf_value *view, uint32_t index, gltf_view *out) {
    gltf_value holder, at;
    find_packed(g, view, &holder, &at);
    if (at.json) open_packed(g, view, index, &at, out);
    return at.json != NULL;
}
