/* Buffer views: a part of a buffer, or decompressed data. */
#include "read/gltf/gltf_data.h"

void gltf_view_part(gltf *g, const gltf_value *at, gltf_view *out) {
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

fathom_status gltf_view_open(gltf *g, uint32_t index, gltf_value *view, gltf_view *out) {
    *out = (gltf_view){.length = 0};
    gltf_item(g, &g->views, index, view);
    if (!gltf_fine(g)) return g->status;
    if (!gltf_packed_open(g, view, index, out)) gltf_view_part(g, view, out);
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
