/* For the tests of PLY: the same rows in all three formats. */
#pragma once

#include "mesh_file.h"

typedef enum ply_flavour { ASCII, LITTLE, BIG, FLAVOURS } ply_flavour;

/* A file being made. */
typedef struct ply_maker {
    ply_flavour flavour;
    unsigned char bytes[8192];
    size_t size;
    int begun; /* files, by ply_each() */
} ply_maker;

static inline void ply_bytes(ply_maker *m, const void *bytes, size_t size) {
    assert_true(m->size + size <= sizeof m->bytes);
    memcpy(m->bytes + m->size, bytes, size);
    m->size += size;
}

static inline void ply_text(ply_maker *m, const char *text) { ply_bytes(m, text, strlen(text)); }

/* The header's lines between format and end_header; padded so that the rows start at a multiple of 4 plus
 * `shift` bytes. */
static inline void ply_header(ply_maker *m, ply_flavour flavour, const char *lines, size_t shift) {
    static const char *const names[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    m->flavour = flavour, m->size = 0;
    ply_text(m, "ply\nformat ");
    ply_text(m, names[flavour]);
    ply_text(m, " 1.0\n");
    ply_text(m, lines);
    const char *end = "\nend_header\n";
    ply_text(m, "comment ");
    while ((m->size + strlen(end)) % 4 != shift % 4) ply_text(m, "x");
    ply_text(m, end);
}

/* for (ply_maker m = {0}; ply_each(&m, lines);): a file of each format, with these lines in its header. */
static inline bool ply_each(ply_maker *m, const char *lines) {
    if (m->begun < FLAVOURS) ply_header(m, (ply_flavour)m->begun, lines, 0);
    return m->begun++ < FLAVOURS;
}

static inline void ply_number(ply_maker *m, char type, double value) {
    if (m->flavour == ASCII) {
        char text[40];
        snprintf(text, sizeof text, "%.17g ", value);
        ply_text(m, text);
        return;
    }
    unsigned char bytes[8] = {0};
    size_t size = 0;
    float f = (float)value;
    int64_t whole = type == 'f' || type == 'd' ? 0 : (int64_t)value;
    switch (type) {
    case 'b': size = 1; break;
    case 's': size = 2; break;
    case 'i': size = 4; break;
    case 'f': size = 4; break;
    case 'l': size = 8; break;
    case 'd': size = 8; break;
    default: fail_msg("no type %c", type);
    }
    if (type == 'f')
        memcpy(bytes, &f, 4);
    else if (type == 'd')
        memcpy(bytes, &value, 8);
    else
        memcpy(bytes, &whole, size);
    for (size_t i = 0; m->flavour == BIG && i < size / 2; ++i) {
        unsigned char swap = bytes[i];
        bytes[i] = bytes[size - 1 - i];
        bytes[size - 1 - i] = swap;
    }
    ply_bytes(m, bytes, size);
}

/* Numbers of these types, signed or not: b 8 bits, s 16, i 32, l 64, f float, d double; a blank ends a row.
 */
static inline void ply_row(ply_maker *m, const char *types, const double *values) {
    for (; *types; ++types) {
        if (*types != ' ')
            ply_number(m, *types, *values++);
        else if (m->flavour == ASCII)
            ply_text(m, "\n");
    }
    if (m->flavour == ASCII) ply_text(m, "\n");
}

#define ROW(maker, types, ...) ply_row(maker, types, (const double[]){__VA_ARGS__})

static const read_mesh_options plain = {.material = FATHOM_NONE};

static inline fathom_scene *ply_try(const ply_maker *m, fathom_status *status) {
    return mesh_try(read_ply, mesh_write("a.ply", m->bytes, m->size), plain, status);
}

static inline fathom_scene *ply_read(const ply_maker *m) {
    return mesh_read(read_ply, mesh_write("a.ply", m->bytes, m->size), plain);
}

#define VERTICES(count) "element vertex " #count "\nproperty float x\nproperty float y\nproperty float z\n"
#define XYZ VERTICES(4)
#define RGB(type) "property " type " red\nproperty " type " green\nproperty " type " blue\n"
#define NORMALS "property float nx\nproperty float ny\nproperty float nz\n"
#define FACES(count) "element face " #count "\nproperty list uchar int vertex_indices\n"

static inline void ply_square(ply_maker *m) { ROW(m, "fff fff fff fff", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0); }

static inline void ply_expect_square(const fathom_scene *scene) {
    const uint32_t expected[6] = {0, 1, 2, 0, 2, 3};
    const fathom_mesh *mesh = mesh_at(scene, 0);
    assert_int_equal(mesh->triangle_count, 2);
    assert_int_equal(mesh->vertex_count, 4);
    mesh_expect_indices(mesh->indices, expected, 6);
    mesh_expect_point(mesh, 0, 0, 0, 0);
    mesh_expect_point(mesh, 1, 1, 0, 0);
    mesh_expect_point(mesh, 2, 1, 1, 0);
    mesh_expect_point(mesh, 3, 0, 1, 0);
}
