/* Typed arrays in buffers, checked in 64 bits against their views and buffers. */
#include "read/gltf/gltf.h"

#include <string.h>

/* Elements without bytes in the file still take memory: a few lines must not ask for gigabytes. */
#define ZEROS_MAX (1 << 20)

/* By type - GLTF_BYTE. */
static const struct {
    const char *name;
    unsigned size, takes;
} types[] = {{"byte", 1, GLTF_TAKES_SIGNED},
             {"unsigned byte", 1, GLTF_TAKES_UNSIGNED},
             {"short", 2, GLTF_TAKES_SIGNED},
             {"unsigned short", 2, GLTF_TAKES_UNSIGNED},
             {"", 0, 0},
             {"unsigned int", 4, GLTF_TAKES_UINT},
             {"float", 4, GLTF_TAKES_FLOAT}};

static unsigned component_size(gltf_type type) { return types[type - GLTF_BYTE].size; }
static unsigned takes_bit(gltf_type type) { return types[type - GLTF_BYTE].takes; }
static const char *type_name(gltf_type type) { return types[type - GLTF_BYTE].name; }

static fathom_status read_component_type(gltf *g, const gltf_value *at, gltf_type *out) {
    uint64_t type = 0;
    fathom_status status = gltf_integer(g, at, "componentType", 0, UINT32_MAX, &type);
    if (status != FATHOM_OK) return status;
    if (type < GLTF_BYTE || type > GLTF_FLOAT || !types[type - GLTF_BYTE].size) {
        return gltf_fail(g, at, "componentType",
                         "is %llu; expected 5120 (byte), 5121 (unsigned byte), 5122 (short), 5123 (unsigned "
                         "short), 5125 (unsigned int) or 5126 (float)",
                         (unsigned long long)type);
    }
    *out = (gltf_type)type;
    return FATHOM_OK;
}

/* The part of a buffer that `user` (an accessor or a part of a sparse one) uses: `count` elements of
 * `element` bytes at its byteOffset. `strided`: the view's byteStride applies. */
static fathom_status open_span(gltf *g, const gltf_value *user, uint64_t count, unsigned element,
                               bool strided, gltf_span *out) {
    uint32_t index = GLTF_ABSENT, buffer = GLTF_ABSENT;
    gltf_value view;
    uint64_t offset = 0, view_offset = 0, view_length = 0, stride = element;
    fathom_status status = gltf_index(g, user, "bufferView", &g->views, &index);
    if (status == FATHOM_OK) status = gltf_integer(g, user, "byteOffset", 0, INT64_MAX, &offset);
    if (status != FATHOM_OK || index == GLTF_ABSENT) return status;
    status = gltf_item(g, &g->views, index, &view);
    if (status == FATHOM_OK) status = gltf_index(g, &view, "buffer", &g->buffers, &buffer);
    if (status == FATHOM_OK && buffer == GLTF_ABSENT)
        return gltf_fail(g, &view, "buffer", "is missing; expected an index into buffers");
    if (status == FATHOM_OK) status = gltf_integer(g, &view, "byteOffset", 0, INT64_MAX, &view_offset);
    if (status == FATHOM_OK) status = gltf_integer(g, &view, "byteLength", 1, INT64_MAX, &view_length);
    if (status == FATHOM_OK && !view_length)
        return gltf_fail(g, &view, "byteLength", "is missing; expected the number of bytes");
    if (status == FATHOM_OK && strided) status = gltf_integer(g, &view, "byteStride", 1, 252, &stride);
    if (status == FATHOM_OK) status = gltf_buffer_load(g, buffer, &out->buffer);
    if (status != FATHOM_OK) return status;
    uint64_t size = out->buffer->size;
    if (view_offset > size || view_length > size - view_offset) {
        return gltf_fail(g, &view, NULL,
                         "spans bytes %llu to %llu + %llu of buffers[%u], which has %llu bytes",
                         (unsigned long long)view_offset, (unsigned long long)view_offset,
                         (unsigned long long)view_length, buffer, (unsigned long long)size);
    }
    if (stride < element) {
        return gltf_fail(g, &view, "byteStride", "is %llu; the elements of %s[%zu] have %u bytes",
                         (unsigned long long)stride, user->parent->key ? user->parent->key : "sparse",
                         user->index, element);
    }
    uint64_t need;
    bool beyond =
        __builtin_mul_overflow(stride, count - 1, &need) || __builtin_add_overflow(need, element, &need);
    if (beyond || offset > view_length || need > view_length - offset) {
        return gltf_fail(
            g, user, NULL, "needs %llu bytes from byte %llu of bufferViews[%u], which has %llu bytes",
            (unsigned long long)need, (unsigned long long)offset, index, (unsigned long long)view_length);
    }
    out->bytes = out->buffer->bytes + view_offset + offset;
    out->stride = (uint32_t)stride;
    return FATHOM_OK;
}

uint32_t gltf_accessor_sparse_index(const gltf_accessor *a, uint32_t i) {
    uint32_t index = 0;
    unsigned size = component_size(a->sparse_type);
    memcpy(&index, a->sparse_indices.bytes + (size_t)i * size, size);
    return index;
}

static fathom_status check_sparse_indices(gltf *g, const gltf_value *at, const gltf_accessor *a) {
    uint64_t lowest = 0;
    for (uint32_t i = 0; i < a->sparse_count; ++i) {
        uint32_t index = gltf_accessor_sparse_index(a, i);
        if (index < lowest || index >= a->count) {
            return gltf_fail(g, at, "indices", "entry %u is %u; expected them to rise and stay below %u", i,
                             index, a->count);
        }
        lowest = (uint64_t)index + 1;
    }
    return FATHOM_OK;
}

static fathom_status open_sparse(gltf *g, const gltf_value *at, gltf_accessor *out) {
    gltf_value sparse, indices, values;
    fathom_status status = gltf_object(g, at, "sparse", &sparse);
    if (status != FATHOM_OK || !sparse.json) return status;
    uint64_t count = 0;
    status = gltf_integer(g, &sparse, "count", 1, out->count, &count);
    if (status == FATHOM_OK) status = gltf_object(g, &sparse, "indices", &indices);
    if (status == FATHOM_OK) status = gltf_object(g, &sparse, "values", &values);
    if (status != FATHOM_OK) return status;
    if (!count || !indices.json || !values.json)
        return gltf_fail(g, &sparse, NULL, "is not whole; expected count, indices and values");
    status = read_component_type(g, &indices, &out->sparse_type);
    if (status == FATHOM_OK && !(takes_bit(out->sparse_type) & (GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT)))
        return gltf_fail(g, &indices, "componentType", "is %s; expected an unsigned type",
                         type_name(out->sparse_type));
    unsigned element = component_size(out->type) * out->components;
    if (status == FATHOM_OK)
        status = open_span(g, &indices, count, component_size(out->sparse_type), false, &out->sparse_indices);
    if (status == FATHOM_OK) status = open_span(g, &values, count, element, false, &out->sparse_values);
    if (status != FATHOM_OK) return status;
    if (!out->sparse_indices.bytes || !out->sparse_values.bytes)
        return gltf_fail(g, &sparse, NULL, "lacks a bufferView; expected one in indices and in values");
    out->sparse_count = (uint32_t)count;
    return check_sparse_indices(g, &sparse, out);
}

/* "SCALAR" 1, "VEC2" 2…; 0 for matrices and anything else. */
static unsigned components_of(const char *type) {
    if (strcmp(type, "SCALAR") == 0) return 1;
    return strncmp(type, "VEC", 3) == 0 && type[3] >= '2' && type[3] <= '4' && !type[4]
               ? (unsigned)(type[3] - '0')
               : 0;
}

static fathom_status open_at(gltf *g, const gltf_value *at, gltf_accessor *out) {
    const char *type = "";
    uint64_t count = 0;
    fathom_status status = read_component_type(g, at, &out->type);
    if (status == FATHOM_OK) status = gltf_text(g, at, "type", &type);
    /* Vertex ids have 32 bits, and the last one means none. */
    if (status == FATHOM_OK) status = gltf_integer(g, at, "count", 1, UINT32_MAX - 1, &count);
    if (status == FATHOM_OK) status = gltf_flag(g, at, "normalized", &out->normalized);
    if (status != FATHOM_OK) return status;
    if (!count) return gltf_fail(g, at, "count", "is missing; expected the number of elements");
    out->count = (uint32_t)count;
    out->components = components_of(type);
    if (!out->components)
        return gltf_fail(g, at, "type", "is \"%.40s\"; expected SCALAR, VEC2, VEC3 or VEC4", type);
    status = open_span(g, at, count, component_size(out->type) * out->components, true, &out->elements);
    if (status == FATHOM_OK && !out->elements.bytes && count > ZEROS_MAX)
        return gltf_fail(
            g, at, "count",
            "is %llu, and there is no bufferView; expected at most %d elements of nothing but zeros",
            (unsigned long long)count, ZEROS_MAX);
    return status == FATHOM_OK ? open_sparse(g, at, out) : status;
}

fathom_status gltf_accessor_open(gltf *g, const gltf_value *user, const char *key, unsigned components,
                                 unsigned takes, uint32_t *index, gltf_accessor *out) {
    *index = GLTF_ABSENT;
    fathom_status status = gltf_index(g, user, key, &g->accessors, index);
    if (status != FATHOM_OK || *index == GLTF_ABSENT) return status;
    gltf_value at;
    *out = (gltf_accessor){.count = 0};
    status = gltf_item(g, &g->accessors, *index, &at);
    if (status == FATHOM_OK) status = open_at(g, &at, out);
    if (status != FATHOM_OK) return status;
    if (out->components == components && takes & takes_bit(out->type)) return FATHOM_OK;
    return gltf_fail(g, user, key, "is accessors[%u] of %u × %s; expected %u × %s%s%s", *index,
                     out->components, type_name(out->type), components,
                     takes & GLTF_TAKES_FLOAT ? "float" : "unsigned int",
                     takes & GLTF_TAKES_SIGNED ? ", byte, short" : "",
                     takes & GLTF_TAKES_UNSIGNED ? ", unsigned byte, unsigned short" : "");
}
