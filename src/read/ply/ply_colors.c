/* Converts colours, which are stored as the file has them until all are known: some programs store bytes as
 * floats or as wider integers. Integers are sRGB in the range of their type, floats are linear. */
#include "base/srgb.h"
#include "read/ply/ply.h"

#include <string.h>

/* Rows of three numbers, or of four with an opacity. */
typedef struct color_rows {
    float *values;
    size_t stride, count;
    unsigned channels;
    double whole, whole_alpha; /* the numbers that mean 1; 0: they are linear */
    bool splats;
} color_rows;

static float *row_of(const color_rows *c, size_t i) {
    return (float *)(void *)((char *)c->values + c->stride * i);
}

/* The first spherical harmonic is sqrt(1 / (4 pi)). Splats store its factor, from the middle of sRGB, and a
 * logit (3DGS, Kerbl et al. 2023). */
static void decode_splat(float *row, unsigned channels) {
    for (int k = 0; k < 3; ++k)
        row[k] = (float)srgb_decoded(fmin(fmax(0.5 + 0.28209479177387814 * (double)row[k], 0), 1));
    if (channels > 3) row[3] = (float)(1 / (1 + exp(-(double)row[3])));
}

static void decode_rows(void *user, size_t begin, size_t end) {
    const color_rows *c = user;
    for (size_t i = begin; i < end; ++i) {
        float *row = row_of(c, i);
        if (c->splats) decode_splat(row, c->channels);
        for (int k = 0; k < 3 && c->whole > 0; ++k) row[k] = (float)srgb_decoded((double)row[k] / c->whole);
        if (c->channels > 3 && c->whole_alpha > 0) row[3] = (float)((double)row[3] / c->whole_alpha);
    }
}

/* True if these components of all rows are whole numbers from 0 to 255, and one is above 2. Linear colours
 * may be above 1, too. Bytes that are all so small would be black. */
static bool are_bytes(const color_rows *c, unsigned begin, unsigned end) {
    float largest = 0;
    for (size_t i = 0; i < c->count; ++i) {
        const float *row = row_of(c, i);
        for (unsigned k = begin; k < end; ++k) {
            if (!(row[k] >= 0 && row[k] <= 255) || row[k] != floorf(row[k])) return false;
            largest = fmaxf(largest, row[k]);
        }
    }
    return largest > 2;
}

/* By the type of a property; 0 for floats, and if there is none. */
static double whole_of(const ply_reader *r, size_t element, int property) {
    if (property < 0) return 0;
    const scalar_type type = r->header.elements.items[element].properties.items[property].type;
    return type < SCALAR_FLOAT32 ? (double)(UINT64_MAX >> (64 - 8 * scalar_size(type))) : 0;
}

/* Sets what the numbers mean. Fathom's own floats are always linear. color, alpha: properties of the
 * element. False: the rows are linear as they are. */
static bool find_whole(ply_reader *r, size_t element, int color, int alpha, color_rows *c) {
    if (c->splats) return true;
    c->whole = whole_of(r, element, color), c->whole_alpha = whole_of(r, element, alpha);
    const bool bytes = c->whole != 255 && !r->by_fathom && are_bytes(c, 0, 3);
    notes_add(&r->notes, bytes ? (size_t)r->header.elements.items[element].count : 0, "",
              "%s colours are %s, but whole numbers up to 255; they are read as sRGB bytes",
              element == r->vertex_element ? "vertex" : "face", c->whole > 0 ? "wide integers" : "floats");
    if (bytes) c->whole = 255;
    if (c->channels > 3 && c->whole_alpha != 255 && (bytes || c->whole_alpha > 0) && are_bytes(c, 3, 4))
        c->whole_alpha = 255;
    return c->whole > 0 || c->whole_alpha > 0;
}

static void decode_faces(ply_reader *r) {
    if (r->face_color < 0 || !r->looks) return;
    color_rows c = {.values = r->looks->color,
                    .stride = sizeof *r->looks,
                    .count = r->triangle_count,
                    .channels = r->face_alpha < 0 ? 3 : 4};
    if (find_whole(r, r->face_element, r->face_color, r->face_alpha, &c))
        loop_parallel(r->threads, c.count, 1u << 14, decode_rows, &c);
}

fathom_status ply_decode_colors(ply_reader *r) {
    ply_array *colors = &r->arrays[PLY_COLORS];
    const ply_array from = *colors;
    decode_faces(r);
    if (!from.present) return FATHOM_OK;
    color_rows c = {.values = (float *)(uintptr_t)from.values,
                    .stride = from.stride,
                    .count = r->vertex_count,
                    .channels = (unsigned)from.components,
                    .splats = r->splats};
    if (!find_whole(r, r->vertex_element, r->role[PLY_R], r->role[PLY_A], &c)) return FATHOM_OK;
    if (!from.own) { /* the file's own bytes */
        colors->values = NULL;
        const fathom_status status = ply_allocate_arrays(r);
        if (status != FATHOM_OK) return status;
        c.values = colors->own, c.stride = colors->stride;
        for (size_t i = 0; i < c.count; ++i)
            memcpy(row_of(&c, i), mesh_row(from.values, from.stride, i), colors->stride);
    }
    loop_parallel(r->threads, c.count, 1u << 14, decode_rows, &c);
    return FATHOM_OK;
}

unsigned ply_color_channels(ply_reader *r, const float *colors, size_t stride, size_t count,
                            const char *places) {
    bool clear = true, whole = true;
    for (size_t i = 0; i < count && (clear || whole); ++i) {
        const float alpha = mesh_row(colors, stride, i)[3];
        clear &= !(alpha > 0), whole &= alpha >= 1;
    }
    if (!clear) return whole ? 3 : 4;
    notes_add(&r->notes, count, "", "alpha is 0 at all %s, and left out", places);
    return 3;
}
