/* The elements of an accessor as plain arrays: in place where they are that already, else converted. */
#include "base/threads.h"
#include "read/gltf/gltf.h"

#include <math.h>
#include <string.h>

typedef struct conversion {
    const unsigned char *from;
    size_t stride;
    unsigned components;
    float divisor, lowest; /* float: value = max(from / divisor, lowest) */
    gltf_type type;
    float *floats;
    uint32_t *integers;
} conversion;

/* Loops stamped for each component type; the elements may lie at any address. */
#define CONVERT_FLOATS(name, T)                                                                              \
    static void name(const conversion *c, size_t begin, size_t end) {                                        \
        for (size_t i = begin; i < end; ++i) {                                                               \
            T element[4];                                                                                    \
            memcpy(element, c->from + i * c->stride, c->components * sizeof(T));                             \
            for (unsigned k = 0; k < c->components; ++k) {                                                   \
                float value = (float)element[k] / c->divisor;                                                \
                c->floats[i * c->components + k] = value < c->lowest ? c->lowest : value;                    \
            }                                                                                                \
        }                                                                                                    \
    }
#define CONVERT_INTEGERS(name, T)                                                                            \
    static void name(const conversion *c, size_t begin, size_t end) {                                        \
        for (size_t i = begin; i < end; ++i) {                                                               \
            T element;                                                                                       \
            memcpy(&element, c->from + i * c->stride, sizeof element);                                       \
            c->integers[i] = element;                                                                        \
        }                                                                                                    \
    }
CONVERT_FLOATS(floats_from_byte, int8_t)
CONVERT_FLOATS(floats_from_ubyte, uint8_t)
CONVERT_FLOATS(floats_from_short, int16_t)
CONVERT_FLOATS(floats_from_ushort, uint16_t)
CONVERT_INTEGERS(integers_from_ubyte, uint8_t)
CONVERT_INTEGERS(integers_from_ushort, uint16_t)
CONVERT_INTEGERS(integers_from_uint, uint32_t)

static void copy_floats(const conversion *c, size_t begin, size_t end) {
    size_t size = c->components * sizeof(float);
    for (size_t i = begin; i < end; ++i) memcpy(c->floats + i * c->components, c->from + i * c->stride, size);
}

static void convert_floats(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const conversion *c = user;
    switch (c->type) {
    case GLTF_BYTE: floats_from_byte(c, begin, end); break;
    case GLTF_UBYTE: floats_from_ubyte(c, begin, end); break;
    case GLTF_SHORT: floats_from_short(c, begin, end); break;
    case GLTF_USHORT: floats_from_ushort(c, begin, end); break;
    case GLTF_UINT: break; /* accepted for indices alone */
    case GLTF_FLOAT: copy_floats(c, begin, end); break;
    }
}

static void convert_integers(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const conversion *c = user;
    switch (c->type) {
    case GLTF_UBYTE: integers_from_ubyte(c, begin, end); break;
    case GLTF_USHORT: integers_from_ushort(c, begin, end); break;
    case GLTF_UINT: integers_from_uint(c, begin, end); break;
    case GLTF_BYTE:
    case GLTF_SHORT:
    case GLTF_FLOAT: break; /* not accepted for indices */
    }
}

/* What a normalized integer is divided by; 1 for those that are taken as they are. */
static float divisor_of(const gltf_accessor *a) {
    if (!a->normalized) return 1;
    switch (a->type) {
    case GLTF_BYTE: return 127;
    case GLTF_UBYTE: return 255;
    case GLTF_SHORT: return 32767;
    case GLTF_USHORT: return 65535;
    case GLTF_UINT:
    case GLTF_FLOAT: break;
    }
    return 1;
}

static bool is_aligned(const gltf_span *span) {
    return span->bytes && span->stride % 4 == 0 && (uintptr_t)span->bytes % 4 == 0;
}

/* Base elements (zeros where there are none), then the replaced ones over them. */
static void convert(gltf *g, const gltf_accessor *a, conversion *c, loop_body body) {
    if (a->elements.bytes) {
        c->from = a->elements.bytes;
        c->stride = a->elements.stride;
        loop_parallel(fathom_context_threads(g->context), a->count, 1u << 16, body, c);
    } else {
        memset(c->floats ? (void *)c->floats : (void *)c->integers, 0, (size_t)a->count * a->components * 4);
    }
    conversion one = *c;
    for (uint32_t i = 0; i < a->sparse_count; ++i) {
        uint32_t at = gltf_accessor_sparse_index(a, i);
        one.from = a->sparse_values.bytes + (size_t)i * a->sparse_values.stride;
        if (c->floats) one.floats = c->floats + (size_t)at * a->components;
        if (c->integers) one.integers = c->integers + at;
        body(&one, 0, 1, 0);
    }
}

fathom_status gltf_accessor_floats(gltf *g, const gltf_value *user, const char *key, const gltf_accessor *a,
                                   const float **out, size_t *stride) {
    if (a->type == GLTF_FLOAT && !a->sparse_count && is_aligned(&a->elements)) {
        *out = (const float *)(const void *)a->elements.bytes;
        *stride = a->elements.stride;
        return gltf_buffer_share(g, a->elements.buffer);
    }
    void *floats;
    fathom_status status =
        gltf_allocate(g, user, key, (uint64_t)a->count * a->components * sizeof(float), &floats);
    if (status != FATHOM_OK) return status;
    conversion c = {.components = a->components,
                    .divisor = divisor_of(a),
                    .lowest = a->normalized ? -1 : -INFINITY,
                    .type = a->type,
                    .floats = floats};
    convert(g, a, &c, convert_floats);
    *out = floats;
    *stride = a->components * sizeof(float);
    return FATHOM_OK;
}

fathom_status gltf_accessor_indices(gltf *g, const gltf_value *user, const char *key, const gltf_accessor *a,
                                    const uint32_t **out) {
    if (a->type == GLTF_UINT && !a->sparse_count && a->elements.stride == 4 && is_aligned(&a->elements)) {
        *out = (const uint32_t *)(const void *)a->elements.bytes;
        return gltf_buffer_share(g, a->elements.buffer);
    }
    void *integers;
    fathom_status status = gltf_allocate(g, user, key, (uint64_t)a->count * sizeof(uint32_t), &integers);
    if (status != FATHOM_OK) return status;
    conversion c = {.components = 1, .type = a->type, .integers = integers};
    convert(g, a, &c, convert_integers);
    *out = integers;
    return FATHOM_OK;
}
