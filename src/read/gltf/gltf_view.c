/* Buffer views: a part of a buffer, or what EXT_meshopt_compression unpacks to. */
#include "read/gltf/gltf.h"

#ifdef FATHOM_MESHOPT
#include <meshoptimizer.h>
#endif
#include <string.h>

/* The bytes in the buffer that the member `byteOffset` and its like of `at` describe. */
static fathom_status open_part(gltf *g, const gltf_value *at, gltf_view *out) {
    uint32_t buffer = GLTF_ABSENT;
    uint64_t offset = 0;
    fathom_status status = gltf_index(g, at, "buffer", &g->buffers, &buffer);
    if (status == FATHOM_OK && buffer == GLTF_ABSENT)
        return gltf_fail(g, at, "buffer", "is missing; expected an index into buffers");
    if (status == FATHOM_OK) status = gltf_integer(g, at, "byteOffset", 0, INT64_MAX, &offset);
    if (status == FATHOM_OK) status = gltf_integer(g, at, "byteLength", 1, INT64_MAX, &out->length);
    if (status == FATHOM_OK && !out->length)
        return gltf_fail(g, at, "byteLength", "is missing; expected the number of bytes");
    if (status == FATHOM_OK) status = gltf_buffer_load(g, buffer, &out->buffer);
    if (status != FATHOM_OK) return status;
    const uint64_t size = out->buffer->size;
    if (offset > size || out->length > size - offset) {
        return gltf_fail(g, at, NULL, "spans bytes %llu to %llu + %llu of buffers[%u], which has %llu bytes",
                         (unsigned long long)offset, (unsigned long long)offset,
                         (unsigned long long)out->length, buffer, (unsigned long long)size);
    }
    out->bytes = out->buffer->bytes + offset;
    return FATHOM_OK;
}

/* ---- EXT_meshopt_compression ---- */

static const char meshopt[] = "EXT_meshopt_compression";

#ifdef FATHOM_MESHOPT

typedef struct packed {
    gltf_view from;
    uint64_t count, stride;
    enum { ATTRIBUTES, TRIANGLES, INDICES } mode;
    enum { NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL } filter;
} packed;

static fathom_status read_word(gltf *g, const gltf_value *at, const char *key, const char *const *words,
                               int count, const char *missing, int *out) {
    const char *word = missing;
    fathom_status status = gltf_text(g, at, key, &word);
    for (*out = 0; status == FATHOM_OK && *out < count; ++*out) {
        if (strcmp(word, words[*out]) == 0) return FATHOM_OK;
    }
    return status == FATHOM_OK
               ? gltf_fail(g, at, key, "is \"%.40s\"; expected one that %s has", word, meshopt)
               : status;
}

/* The extension's table of what goes together; the decoder relies on it. */
static fathom_status check_stride(gltf *g, const gltf_value *at, const packed *p) {
    const uint64_t s = p->stride;
    const bool fine = p->mode != ATTRIBUTES     ? s == 2 || s == 4
                      : p->filter == OCTAHEDRAL ? s == 4 || s == 8
                      : p->filter == QUATERNION ? s == 8
                                                : s % 4 == 0 && s <= 256;
    if (!s || !fine)
        return gltf_fail(g, at, "byteStride", "is %llu, which does not go with the mode and the filter",
                         (unsigned long long)s);
    if (!p->count || (p->mode == TRIANGLES && p->count % 3))
        return gltf_fail(g, at, "count", "is %llu; expected %s", (unsigned long long)p->count,
                         p->mode == TRIANGLES ? "a positive multiple of 3" : "a positive number");
    if (p->filter != NONE && p->mode != ATTRIBUTES)
        return gltf_fail(g, at, "filter", "is given for indices; expected none");
    return FATHOM_OK;
}

static fathom_status read_packed(gltf *g, const gltf_value *at, packed *out) {
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"}, *const filters[] = {
                                                                                   "NONE", "OCTAHEDRAL",
                                                                                   "QUATERNION",
                                                                                   "EXPONENTIAL"};
    int mode = 0, filter = 0;
    fathom_status status = open_part(g, at, &out->from);
    if (status == FATHOM_OK) status = gltf_integer(g, at, "byteStride", 1, 256, &out->stride);
    if (status == FATHOM_OK) status = gltf_integer(g, at, "count", 1, UINT32_MAX, &out->count);
    if (status == FATHOM_OK) status = read_word(g, at, "mode", modes, 3, "", &mode);
    if (status == FATHOM_OK) status = read_word(g, at, "filter", filters, 4, filters[0], &filter);
    if (status != FATHOM_OK) return status;
    out->mode = (unsigned)mode, out->filter = (unsigned)filter;
    return check_stride(g, at, out);
}

static int decode(const packed *p, void *to) {
    const size_t count = (size_t)p->count, stride = (size_t)p->stride, size = (size_t)p->from.length;
    switch (p->mode) {
    case TRIANGLES: return meshopt_decodeIndexBuffer(to, count, stride, p->from.bytes, size);
    case INDICES: return meshopt_decodeIndexSequence(to, count, stride, p->from.bytes, size);
    case ATTRIBUTES: break;
    }
    const int failed = meshopt_decodeVertexBuffer(to, count, stride, p->from.bytes, size);
    if (failed) return failed;
    switch (p->filter) {
    case NONE: break;
    case OCTAHEDRAL: meshopt_decodeFilterOct(to, count, stride); break;
    case QUATERNION: meshopt_decodeFilterQuat(to, count, stride); break;
    case EXPONENTIAL: meshopt_decodeFilterExp(to, count, stride); break;
    }
    return 0;
}

static fathom_status unpack(gltf *g, const gltf_value *at, gltf_buffer *out) {
    packed p = {.count = 0};
    void *memory;
    fathom_status status = read_packed(g, at, &p);
    if (status == FATHOM_OK) status = gltf_allocate(g, at, NULL, p.count * p.stride, &memory);
    if (status != FATHOM_OK) return status;
    if (decode(&p, memory)) return gltf_fail(g, at, NULL, "cannot be unpacked: the data is broken");
    *out = (gltf_buffer){.bytes = memory, .size = p.count * p.stride};
    return FATHOM_OK;
}

static fathom_status open_packed(gltf *g, const gltf_value *view, uint32_t index, const gltf_value *at,
                                 gltf_view *out) {
    gltf_buffer *kept = &g->view_table[index];
    out->length = 0;
    fathom_status status = kept->bytes ? FATHOM_OK : unpack(g, at, kept);
    if (status == FATHOM_OK) status = gltf_integer(g, view, "byteLength", 1, INT64_MAX, &out->length);
    if (status == FATHOM_OK && out->length > kept->size)
        return gltf_fail(g, view, "byteLength", "is %llu; what it unpacks to has %llu bytes",
                         (unsigned long long)out->length, (unsigned long long)kept->size);
    out->bytes = kept->bytes, out->buffer = kept;
    return status;
}

#else

/* Without the library the buffer that stands in, which a file need not have. */
static fathom_status open_packed(gltf *g, const gltf_value *view, uint32_t index, const gltf_value *at,
                                 gltf_view *out) {
    (void)index;
    if (gltf_requires(g, meshopt))
        return gltf_fail(g, at, NULL,
                         "needs meshoptimizer, without which this Fathom was built (Debian: "
                         "libmeshoptimizer-dev); build it with, or export the model without the extension");
    return open_part(g, view, out);
}

#endif

fathom_status gltf_view_open(gltf *g, uint32_t index, gltf_value *view, gltf_view *out) {
    gltf_value holder, at;
    *out = (gltf_view){.length = 0};
    fathom_status status = gltf_item(g, &g->views, index, view);
    if (status == FATHOM_OK) status = gltf_extension(g, view, meshopt, &holder, &at);
    if (status != FATHOM_OK) return status;
    return at.json ? open_packed(g, view, index, &at, out) : open_part(g, view, out);
}
