/* Typed arrays in buffers, checked against their views and buffers in 64-bit arithmetic. Meshes use them in
 * place if the format fits; otherwise each array is converted once. */
#include "base/text.h"
#include "base/threads.h"
#include "read/gltf/gltf_data.h"
#include "read/mesh/scalar.h"

#include <math.h>
#include <string.h>

typedef enum component {
    GLTF_BYTE = 5120,
    GLTF_UBYTE = 5121,
    GLTF_SHORT = 5122,
    GLTF_USHORT = 5123,
    GLTF_UINT = 5125,
    GLTF_FLOAT = 5126
} component;

/* The first element of an array; NULL bytes: all zeros. */
typedef struct span {
    const unsigned char *bytes;
    uint32_t stride;
    gltf_buffer *buffer;
} span;

typedef struct accessor {
    component type;
    unsigned components; /* per element: 1 to 4, or 16 */
    bool normalized;
    uint32_t count; /* elements */
    span elements;
    uint32_t sparse_count; /* number of replaced elements */
    component sparse_type;
    span sparse_indices, sparse_values;
} accessor;

/* ---- conversion ---- */

typedef struct conversion {
    const unsigned char *from;
    size_t stride;
    scalar_type type;
    unsigned components;
    float divisor, lowest; /* float: value = max(from / divisor, lowest) */
    float *floats;
    uint32_t *integers; /* if there are no floats */
} conversion;

static void convert_some(void *user, size_t begin, size_t end) {
    const conversion *c = user;
    for (size_t i = begin; i < end; ++i) {
        for (size_t k = 0; k < c->components; ++k) {
            const double from =
                scalar_load(c->from + i * c->stride + k * scalar_size(c->type), c->type, false);
            const float value = (float)from / c->divisor;
            if (c->floats)
                c->floats[i * c->components + k] = value < c->lowest ? c->lowest : value;
            else
                c->integers[i * c->components + k] = (uint32_t)from;
        }
    }
}

/* Indexed by type - GLTF_BYTE. Normalized integers are divided by `divisor`. Without a name: not accepted. */
static const struct {
    const char *name;
    scalar_type scalar;
    unsigned takes;
    float divisor;
} types[] = {{"byte", SCALAR_INT8, GLTF_TAKES_SIGNED, 127},
             {"unsigned byte", SCALAR_UINT8, GLTF_TAKES_UNSIGNED, 255},
             {"short", SCALAR_INT16, GLTF_TAKES_SIGNED, 32767},
             {"unsigned short", SCALAR_UINT16, GLTF_TAKES_UNSIGNED, 65535},
             {NULL, SCALAR_INT32, 0, 1},
             {"unsigned int", SCALAR_UINT32, GLTF_TAKES_UINT, 1},
             {"float", SCALAR_FLOAT32, GLTF_TAKES_FLOAT, 1}};

static unsigned component_size(component type) {
    return (unsigned)scalar_size(types[type - GLTF_BYTE].scalar);
}
static unsigned takes_bit(component type) { return types[type - GLTF_BYTE].takes; }
static const char *type_name(component type) { return types[type - GLTF_BYTE].name; }

/* ---- accessors ---- */

static void read_component_type(gltf *g, const gltf_value *at, component *out) {
    uint64_t type = 0;
    *out = GLTF_FLOAT;
    gltf_integer(g, at, "componentType", 0, UINT32_MAX, &type);
    if (type < GLTF_BYTE || type > GLTF_FLOAT || !types[type - GLTF_BYTE].name)
        gltf_fail(g, at, "componentType",
                  "is %llu; expected 5120 (byte), 5121 (unsigned byte), 5122 (short), 5123 (unsigned "
                  "short), 5125 (unsigned int) or 5126 (float)",
                  (unsigned long long)type);
    else
        *out = (component)type;
}

/* Finds the part of a buffer that `user` (an accessor or a part of a sparse one) uses: `count` elements of
 * `element` bytes at its byteOffset. `strided`: the view's byteStride applies. */
static void open_span(gltf *g, const gltf_value *user, uint64_t count, unsigned element, bool strided,
                      span *out) {
    uint32_t index = GLTF_ABSENT;
    gltf_value view;
    gltf_view from;
    uint64_t offset = 0, stride = element, need;
    gltf_index(g, user, "bufferView", &g->views, &index);
    gltf_integer(g, user, "byteOffset", 0, INT64_MAX, &offset);
    if (!gltf_fine(g) || index == GLTF_ABSENT) return;
    gltf_view_open(g, index, &view, &from);
    if (strided) gltf_view_stride(g, &view, &stride);
    if (stride < element)
        gltf_fail(g, &view, "byteStride", "is %llu; the elements of %s[%zu] have %u bytes",
                  (unsigned long long)stride, user->at.parent->key, user->at.index, element);
    const bool beyond =
        __builtin_mul_overflow(stride, count - 1, &need) || __builtin_add_overflow(need, element, &need);
    if (beyond || offset > from.length || need > from.length - offset)
        gltf_fail(g, user, NULL, "needs %llu bytes from byte %llu of bufferViews[%u], which has %llu bytes",
                  (unsigned long long)need, (unsigned long long)offset, index,
                  (unsigned long long)from.length);
    if (gltf_fine(g))
        *out = (span){.bytes = from.bytes + offset, .stride = (uint32_t)stride, .buffer = from.buffer};
}

static uint32_t sparse_index(const accessor *a, uint32_t i) {
    uint32_t index = 0;
    unsigned size = component_size(a->sparse_type);
    memcpy(&index, a->sparse_indices.bytes + (size_t)i * size, size);
    return index;
}

static void check_sparse_indices(gltf *g, const gltf_value *at, const accessor *a) {
    uint64_t lowest = 0;
    for (uint32_t i = 0; i < a->sparse_count; ++i) {
        const uint32_t index = sparse_index(a, i);
        if (index < lowest || index >= a->count)
            gltf_fail(g, at, "indices", "entry %u is %u; expected them to rise and stay below %u", i, index,
                      a->count);
        lowest = (uint64_t)index + 1;
    }
}

static void open_sparse(gltf *g, const gltf_value *at, accessor *out) {
    gltf_value sparse, indices, values;
    uint64_t count = 0;
    gltf_object(g, at, "sparse", &sparse);
    if (!sparse.json) return;
    gltf_integer(g, &sparse, "count", 1, out->count, &count);
    gltf_object(g, &sparse, "indices", &indices);
    gltf_object(g, &sparse, "values", &values);
    if (!count || !indices.json || !values.json)
        gltf_fail(g, &sparse, NULL, "is incomplete; expected count, indices and values");
    read_component_type(g, &indices, &out->sparse_type);
    if (!(takes_bit(out->sparse_type) & (GLTF_TAKES_UNSIGNED | GLTF_TAKES_UINT)))
        gltf_fail(g, &indices, "componentType", "is %s; expected an unsigned type",
                  type_name(out->sparse_type));
    if (!gltf_fine(g)) return;
    open_span(g, &indices, count, component_size(out->sparse_type), false, &out->sparse_indices);
    open_span(g, &values, count, component_size(out->type) * out->components, false, &out->sparse_values);
    if (!out->sparse_indices.bytes || !out->sparse_values.bytes)
        gltf_fail(g, &sparse, NULL, "lacks a bufferView; expected one in indices and in values");
    out->sparse_count = gltf_fine(g) ? (uint32_t)count : 0;
    check_sparse_indices(g, &sparse, out);
}

/* 0 for other matrices and anything else. */
static unsigned components_of(const char *type) {
    static const unsigned counts[] = {0, 1, 2, 3, 4, 16};
    return counts[words_find("SCALAR|VEC2|VEC3|VEC4|MAT4", type, strlen(type)) + 1];
}

/* Reads all members except the position of the elements. A count of 0 is invalid in glTF, but some exporters
 * write it. */
static void open_head(gltf *g, const gltf_value *at, accessor *out) {
    const char *type = "";
    uint64_t count = UINT64_MAX;
    read_component_type(g, at, &out->type);
    gltf_text(g, at, "type", &type);
    /* Vertex indices have 32 bits, and the last one is reserved. */
    gltf_integer(g, at, "count", 0, UINT32_MAX - 1, &count);
    gltf_flag(g, at, "normalized", &out->normalized);
    if (count == UINT64_MAX) gltf_fail(g, at, "count", "is missing; expected the number of elements");
    if (!count) gltf_note(g, at, "count", "an accessor without elements, which is against the format");
    out->count = (uint32_t)count;
    out->components = components_of(type);
    if (!out->components)
        gltf_fail(g, at, "type", "is \"%.40s\"; expected SCALAR, VEC2, VEC3, VEC4 or MAT4", type);
}

static void open_elements(gltf *g, const gltf_value *at, accessor *out) {
    open_span(g, at, out->count, component_size(out->type) * out->components, true, &out->elements);
    if (gltf_fine(g)) open_sparse(g, at, out);
}

/* Finds the accessor that member `key` of `user` names, and reads all but its elements. False: there is no
 * such member, or reading has failed. */
static bool find_accessor(gltf *g, const gltf_value *user, const char *key, uint32_t *index, gltf_value *at,
                          accessor *out) {
    *index = GLTF_ABSENT;
    *out = (accessor){.count = 0};
    gltf_index(g, user, key, &g->accessors, index);
    if (!gltf_fine(g) || *index == GLTF_ABSENT) return false;
    gltf_item(g, &g->accessors, *index, at);
    open_head(g, at, out);
    return gltf_fine(g);
}

/* Assimp writes the third number of texture coordinates that its source has. */
static bool has_third(const char *key, unsigned components, const accessor *a) {
    return components == 2 && a->components == 3 && strncmp(key, "TEXCOORD_", 9) == 0;
}

static void check_kind(gltf *g, const gltf_value *user, const char *key, uint32_t index, unsigned components,
                       unsigned takes, const accessor *a) {
    const bool third = has_third(key, components, a);
    if ((a->components == components || third) && takes & takes_bit(a->type)) {
        if (third)
            gltf_note(g, user, key,
                      "texture coordinates of three numbers, which are against the format, lose the third");
        return;
    }
    gltf_fail(g, user, key, "is accessors[%u] of %u × %s; expected %u × %s%s%s", index, a->components,
              type_name(a->type), components, takes & GLTF_TAKES_FLOAT ? "float" : "unsigned int",
              takes & GLTF_TAKES_SIGNED ? ", byte, short" : "",
              takes & GLTF_TAKES_UNSIGNED ? ", unsigned byte, unsigned short" : "");
}

unsigned gltf_components(gltf *g, const gltf_value *user, const char *key) {
    uint32_t index = GLTF_ABSENT;
    gltf_value at;
    const char *type = "";
    gltf_index(g, user, key, &g->accessors, &index);
    if (!gltf_fine(g) || index == GLTF_ABSENT) return 0;
    gltf_item(g, &g->accessors, index, &at);
    gltf_text(g, &at, "type", &type);
    return components_of(type) ? components_of(type) : 1;
}

/* ---- as arrays ---- */

static bool is_aligned(const span *s) {
    return s->bytes && s->stride % 4 == 0 && (uintptr_t)s->bytes % 4 == 0;
}

/* Converts the base elements (zeros if there are none), then replaces some by the sparse ones. */
static void convert(gltf *g, const accessor *a, conversion *c) {
    if (a->elements.bytes) {
        c->from = a->elements.bytes;
        c->stride = a->elements.stride;
        loop_parallel(fathom_context_threads(g->context), a->count, 1u << 16, convert_some, c);
    } else {
        memset(c->floats ? (void *)c->floats : (void *)c->integers, 0, (size_t)a->count * a->components * 4);
    }
    conversion one = *c;
    for (uint32_t i = 0; i < a->sparse_count; ++i) {
        uint32_t at = sparse_index(a, i);
        one.from = a->sparse_values.bytes + (size_t)i * a->sparse_values.stride;
        if (c->floats) one.floats = c->floats + (size_t)at * a->components;
        if (c->integers) one.integers = c->integers + at;
        convert_some(&one, 0, 1);
    }
}

/* Makes the elements an array of floats or integers: in place if the file has them aligned, otherwise in
 * memory of the scene, charged to member `key` of `user`. Integers are tightly packed. */
static void make_array(gltf *g, const gltf_value *user, const char *key, const accessor *a, bool integers,
                       gltf_elements *out) {
    const size_t packed = (size_t)a->components * 4;
    *out = (gltf_elements){.values = a->elements.bytes, .stride = a->elements.stride, .count = a->count};
    bool plain = a->type == (integers ? GLTF_UINT : GLTF_FLOAT) && !a->sparse_count;
    if (plain && is_aligned(&a->elements) && (!integers || out->stride == packed)) {
        gltf_buffer_share(g, a->elements.buffer);
        return;
    }
    void *memory;
    if (gltf_allocate(g, user, key, (uint64_t)a->count * packed, &memory) != FATHOM_OK) return;
    conversion c = {.type = types[a->type - GLTF_BYTE].scalar,
                    .components = a->components,
                    .divisor = a->normalized ? types[a->type - GLTF_BYTE].divisor : 1,
                    .lowest = a->normalized ? -1 : -INFINITY,
                    .floats = integers ? NULL : memory,
                    .integers = integers ? memory : NULL};
    convert(g, a, &c);
    out->values = memory, out->stride = packed;
}

/* True for attributes that only affect shading: without them there is still a surface. */
static bool is_look(const char *key) {
    return strncmp(key, "NORMAL", 6) == 0 || strncmp(key, "TANGENT", 7) == 0 ||
           strncmp(key, "TEXCOORD_", 9) == 0 || strncmp(key, "COLOR_", 6) == 0;
}

/* Replaces numbers that are not finite by 0: exporters write them when they normalise a zero vector. */
static void mend_look(gltf *g, const gltf_value *user, const char *key, unsigned components,
                      gltf_elements *made) {
    const size_t row = components * sizeof(float);
    void *memory;
    if (gltf_allocate(g, user, key, made->count * (uint64_t)row, &memory) != FATHOM_OK) return;
    float *to = memory;
    for (uint32_t i = 0; i < made->count; ++i) {
        const float *from = mesh_row(made->values, made->stride, i);
        for (unsigned c = 0; c < components; ++c)
            to[i * (size_t)components + c] = isfinite(from[c]) ? from[c] : 0;
    }
    made->values = memory, made->stride = row;
    gltf_note(g, user, key, "a NaN or an infinity in %s, which is against the format, is taken as 0", key);
}

static fathom_status look_at_floats(gltf *g, unsigned components, gltf_elements *made) {
    if (components == 3)
        return mesh_look_at_vertices(g->context, "entry", made->values, made->stride, made->count,
                                     &made->facts);
    return mesh_check_finite(g->context, "entry", made->values, made->stride, components, made->count);
}

/* Stores the array for the accessor; floats are checked first. */
static void keep_array(gltf *g, const gltf_value *user, const char *key, bool integers, unsigned components,
                       gltf_elements *made, gltf_elements *kept) {
    fathom_status status = gltf_fine(g) && !integers ? look_at_floats(g, components, made) : g->status;
    if (status == FATHOM_BAD_INPUT && gltf_fine(g) && is_look(key)) {
        mend_look(g, user, key, components, made);
        status = gltf_fine(g) ? look_at_floats(g, components, made) : g->status;
    }
    gltf_within(g, user, key, status);
    if (gltf_fine(g)) *kept = *made;
}

/* Colours in whole numbers are divided by their maximum, even if the accessor does not say so. */
static bool is_whole_color(const char *key, const accessor *a) {
    return strncmp(key, "COLOR_", 6) == 0 && a->type != GLTF_FLOAT && !a->normalized;
}

/* The elements that Draco unpacked for the present primitive, if there are any, else the accessor's own. */
static gltf_elements *elements_for(gltf *g, uint32_t index, bool integers) {
    gltf_elements *own = &g->array_table[index].own[integers],
                  *unpacked = &g->array_table[index].unpacked[integers];
    return g->unpacked && unpacked->unpacked_of == g->unpacked ? unpacked : own;
}

bool gltf_array_read(gltf *g, const gltf_value *user, const char *key, unsigned components, unsigned takes,
                     gltf_elements *out) {
    const bool integers = takes & GLTF_TAKES_UINT;
    accessor from;
    gltf_value at;
    uint32_t index;
    *out = (gltf_elements){.values = NULL};
    if (!find_accessor(g, user, key, &index, &at, &from)) return false;
    gltf_elements *kept = elements_for(g, index, integers);
    check_kind(g, user, key, index, components, takes, &from);
    if (!from.count) return gltf_fine(g);
    if (is_whole_color(key, &from)) {
        gltf_note(g, &at, NULL, "colours in whole numbers have to be normalized, and are taken so");
        from.normalized = true;
    }
    if (!kept->values) open_elements(g, &at, &from);
    if (gltf_fine(g) && !kept->values) {
        make_array(g, user, key, &from, integers, out);
        keep_array(g, user, key, integers, components, out, kept);
    }
    if (gltf_fine(g)) *out = *kept;
    return gltf_fine(g);
}

void gltf_array_give(gltf *g, const gltf_value *user, const char *key, const gltf_given *given) {
    const size_t total = (size_t)given->count * given->components;
    uint32_t index;
    gltf_value at;
    accessor a;
    void *memory;
    if (!find_accessor(g, user, key, &index, &at, &a)) return;
    if (a.count != given->count || a.components != given->components)
        gltf_fail(g, user, key, "is accessors[%u] of %u × %u numbers; the compressed data has %u × %u", index,
                  a.count, a.components, given->count, given->components);
    gltf_elements *kept = &g->array_table[index].unpacked[given->integers];
    if (!gltf_fine(g) || kept->unpacked_of == given->view + 1 ||
        gltf_allocate(g, user, key, total * 4, &memory) != FATHOM_OK)
        return;
    memcpy(memory, given->values, total * 4);
    const bool divides = (a.normalized || is_whole_color(key, &a)) && !given->normalized && !given->integers;
    const float divisor = divides ? types[a.type - GLTF_BYTE].divisor : 1;
    float *floats = memory;
    for (size_t i = 0; divisor != 1 && i < total; ++i) floats[i] = fmaxf(floats[i] / divisor, -1);
    gltf_elements made = {.values = memory,
                          .stride = (size_t)given->components * 4,
                          .count = given->count,
                          .unpacked_of = given->view + 1};
    keep_array(g, user, key, given->integers, given->components, &made, kept);
}
