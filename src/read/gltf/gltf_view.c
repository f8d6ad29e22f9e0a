/* Buffer views: a part of a buffer, or the decompressed data of EXT_meshopt_compression. */
#include "read/gltf/gltf.h"

#ifdef FATHOM_MESHOPT
#include <meshoptimizer.h>
#endif
#include <string.h>

/* The bytes that the members `buffer`, `byteOffset` and `byteLength` of `at` describe. */
static void open_part(gltf *g, const gltf_value *at, gltf_view *out) {
    uint32_t buffer = GLTF_ABSENT;
    uint64_t offset = 0;
    gltf_index(g, at, "buffer", &g->buffers, &buffer);
    if (buffer == GLTF_ABSENT) gltf_fail(g, at, "buffer", "is missing; expected an index into buffers");
    gltf_integer(g, at, "byteOffset", 0, INT64_MAX, &offset);
    gltf_integer(g, at, "byteLength", 1, INT64_MAX, &out->length);
    if (!out->length) gltf_fail(g, at, "byteLength", "is missing; expected the number of bytes");
    if (!gltf_fine(g) || gltf_buffer_load(g, buffer, &out->buffer) != FATHOM_OK) return;
    const uint64_t size = out->buffer->size;
    if (offset > size || out->length > size - offset)
        gltf_fail(g, at, NULL, "spans bytes %llu to %llu + %llu of buffers[%u], which has %llu bytes",
                  (unsigned long long)offset, (unsigned long long)offset, (unsigned long long)out->length,
                  buffer, (unsigned long long)size);
    else
        out->bytes = out->buffer->bytes + offset;
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

static int read_word(gltf *g, const gltf_value *at, const char *key, const char *const *words, int count,
                     const char *missing) {
    const char *word = missing;
    gltf_text(g, at, key, &word);
    for (int i = 0; i < count; ++i) {
        if (strcmp(word, words[i]) == 0) return i;
    }
    gltf_fail(g, at, key, "is \"%.40s\"; expected one that %s has", word, meshopt);
    return 0;
}

/* The valid combinations by the extension; the decoder relies on them. */
static void check_stride(gltf *g, const gltf_value *at, const packed *p) {
    const uint64_t s = p->stride;
    const bool fine = p->mode != ATTRIBUTES     ? s == 2 || s == 4
                      : p->filter == OCTAHEDRAL ? s == 4 || s == 8
                      : p->filter == QUATERNION ? s == 8
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
    static const char *const modes[] = {"ATTRIBUTES", "TRIANGLES", "INDICES"};
    static const char *const filters[] = {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"};
    packed out = {.count = 0};
    open_part(g, at, &out.from);
    gltf_integer(g, at, "byteStride", 1, 256, &out.stride);
    gltf_integer(g, at, "count", 1, UINT32_MAX, &out.count);
    out.mode = (unsigned)read_word(g, at, "mode", modes, 3, "");
    out.filter = (unsigned)read_word(g, at, "filter", filters, 4, filters[0]);
    check_stride(g, at, &out);
    return out;
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

static void unpack(gltf *g, const gltf_value *at, gltf_buffer *out) {
    const packed p = read_packed(g, at);
    void *memory;
    if (gltf_allocate(g, at, NULL, p.count * p.stride, &memory) != FATHOM_OK) return;
    if (decode(&p, memory))
        gltf_fail(g, at, NULL, "cannot be unpacked: the data is broken");
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
    if (gltf_requires(g, meshopt))
        gltf_fail(g, at, NULL,
                  "needs meshoptimizer, without which this Fathom was built (Debian: "
                  "libmeshoptimizer-dev); build it with, or export the model without the extension");
    open_part(g, view, out);
}

#endif

fathom_status gltf_view_open(gltf *g, uint32_t index, gltf_value *view, gltf_view *out) {
    gltf_value holder, at;
    *out = (gltf_view){.length = 0};
    gltf_item(g, &g->views, index, view);
    gltf_extension(g, view, meshopt, &holder, &at);
    if (!gltf_fine(g)) return g->status;
    if (at.json)
        open_packed(g, view, index, &at, out);
    else
        open_part(g, view, out);
    return g->status;
}

void gltf_view_stride(gltf *g, const gltf_value *view, uint64_t *stride) {
    uint64_t given = *stride;
    gltf_integer(g, view, "byteStride", 0, 252, &given);
    if (given)
        *stride = given;
    else
        gltf_note(g, view, "byteStride", "a stride of 0, which is against the format, is taken as none");
}
