/* Accessors as arrays that meshes can use: in place where they are that already, else converted, each once.
 */
#include "base/threads.h"
#include "read/gltf/gltf.h"

#include <math.h>
#include <string.h>

/* ---- memory ---- */

/* A few bytes of glTF can ask for any amount of memory: by zero elements, or by one array used in many ways.
 * Bytes take at most 4 times their size as floats, 12 times as a strip, about 20 times as instances. */
#define FACTOR 128u
#define FREE 65536u

fathom_status gltf_charge(gltf *g, const gltf_value *at, const char *key, uint64_t bytes) {
    /* Sums of sizes that are in memory: no overflow, as `bytes` is below 2^40. */
    uint64_t most = FREE + FACTOR * g->file_bytes;
    g->charged += bytes;
    if (g->charged <= most) return FATHOM_OK;
    return gltf_fail(
        g, at, key,
        "brings what the file asks for to %llu bytes of memory; expected at most %u times the %llu "
        "bytes of its files",
        (unsigned long long)g->charged, FACTOR, (unsigned long long)g->file_bytes);
}

fathom_status gltf_allocate(gltf *g, const gltf_value *at, const char *key, uint64_t bytes, void **out) {
    fathom_status status = gltf_charge(g, at, key, bytes);
    return status == FATHOM_OK ? scene_allocate(g->scene, (size_t)bytes, out) : status;
}

/* ---- conversion ---- */

typedef struct conversion {
    const unsigned char *from;
    size_t stride;
    unsigned components;
    float divisor, lowest; /* float: value = max(from / divisor, lowest) */
    float *floats;
    uint32_t *integers;
} conversion;

/* Loop bodies for each component type; the elements may lie at any address. */
#define CONVERT_FLOATS(name, T)                                                                              \
    static void name(void *user, size_t begin, size_t end, unsigned worker) {                                \
        (void)worker;                                                                                        \
        const conversion *c = user;                                                                          \
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
    static void name(void *user, size_t begin, size_t end, unsigned worker) {                                \
        (void)worker;                                                                                        \
        const conversion *c = user;                                                                          \
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

static void copy_floats(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const conversion *c = user;
    size_t size = c->components * sizeof(float);
    for (size_t i = begin; i < end; ++i) memcpy(c->floats + i * c->components, c->from + i * c->stride, size);
}

/* By type - GLTF_BYTE. Normalized integers are divided by `divisor`. NULL: not accepted. */
static const struct {
    float divisor;
    loop_body floats, integers;
} conversions[] = {{127, floats_from_byte, NULL},
                   {255, floats_from_ubyte, integers_from_ubyte},
                   {32767, floats_from_short, NULL},
                   {65535, floats_from_ushort, integers_from_ushort},
                   {1, NULL, NULL},
                   {1, NULL, integers_from_uint},
                   {1, copy_floats, NULL}};

static bool is_aligned(const gltf_span *span) {
    return span->bytes && span->stride % 4 == 0 && (uintptr_t)span->bytes % 4 == 0;
}

/* Converts the base elements (zeros if there are none), then the sparse ones over them. */
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

/* The elements as floats: in place where the file holds aligned floats, else converted into memory of the
 * scene that is charged to member `key` of `user`. stride in bytes. */
static fathom_status accessor_floats(gltf *g, const gltf_value *user, const char *key, const gltf_accessor *a,
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
                    .divisor = a->normalized ? conversions[a->type - GLTF_BYTE].divisor : 1,
                    .lowest = a->normalized ? -1 : -INFINITY,
                    .floats = floats};
    convert(g, a, &c, conversions[a->type - GLTF_BYTE].floats);
    *out = floats;
    *stride = a->components * sizeof(float);
    return FATHOM_OK;
}

/* The same for indices, tightly packed. */
static fathom_status accessor_indices(gltf *g, const gltf_value *user, const char *key,
                                      const gltf_accessor *a, const uint32_t **out) {
    if (a->type == GLTF_UINT && !a->sparse_count && a->elements.stride == 4 && is_aligned(&a->elements)) {
        *out = (const uint32_t *)(const void *)a->elements.bytes;
        return gltf_buffer_share(g, a->elements.buffer);
    }
    void *integers;
    fathom_status status = gltf_allocate(g, user, key, (uint64_t)a->count * sizeof(uint32_t), &integers);
    if (status != FATHOM_OK) return status;
    conversion c = {.components = 1, .integers = integers};
    convert(g, a, &c, conversions[a->type - GLTF_BYTE].integers);
    *out = integers;
    return FATHOM_OK;
}

/* ---- arrays ---- */

static fathom_status look_at_floats(gltf *g, unsigned components, gltf_floats *floats) {
    if (components == 3)
        return mesh_look_at_vertices(g->context, "entry", floats->values, floats->stride, floats->count,
                                     &floats->facts);
    return mesh_check_finite(g->context, "entry", floats->values, floats->stride, components, floats->count);
}

fathom_status gltf_array_floats(gltf *g, const gltf_value *user, const char *key, unsigned components,
                                unsigned takes, bool *present, gltf_floats *out) {
    gltf_accessor accessor;
    uint32_t index = GLTF_ABSENT;
    fathom_status status = gltf_accessor_open(g, user, key, components, takes, &index, &accessor);
    *present = index != GLTF_ABSENT;
    if (status != FATHOM_OK || !*present) return status;
    gltf_floats *kept = &g->array_table[index].floats;
    if (!kept->values) {
        gltf_floats made = {.count = accessor.count};
        status = accessor_floats(g, user, key, &accessor, &made.values, &made.stride);
        if (status != FATHOM_OK) return status;
        status = look_at_floats(g, components, &made);
        if (status != FATHOM_OK) return gltf_within(g, user, key, status);
        *kept = made;
    }
    *out = *kept;
    return FATHOM_OK;
}

fathom_status gltf_array_indices(gltf *g, const gltf_value *user, const char *key, bool *present,
                                 const uint32_t **out, uint32_t *count) {
    gltf_accessor accessor;
    uint32_t index = GLTF_ABSENT;
    fathom_status status =
        gltf_accessor_open(g, user, key, 1, GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT, &index, &accessor);
    *present = index != GLTF_ABSENT;
    if (status != FATHOM_OK || !*present) return status;
    const uint32_t **kept = &g->array_table[index].indices;
    if (!*kept) status = accessor_indices(g, user, key, &accessor, kept);
    if (status != FATHOM_OK) return status;
    *out = *kept;
    *count = accessor.count;
    return FATHOM_OK;
}
