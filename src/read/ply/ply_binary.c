/* Binary rows. They are read in blocks. If rows differ in size, one pass over them finds where each block
 * begins. */
#include "read/ply/ply.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#ifndef PLY_BLOCK /* fuzzing sets a small size, so that small files have several blocks */
#define PLY_BLOCK 4096
#endif

/* The position of an element's rows in the file. */
typedef struct ply_rows {
    const ply_element *element;
    const unsigned char *begin, *end;
    size_t row;                   /* bytes per row, if all rows have the same size */
    size_t *offsets;              /* of each property in the row, if all rows are alike */
    const unsigned char **blocks; /* otherwise the start of each block */
    size_t block_count;
} ply_rows;

typedef struct binary_reader {
    ply_reader *r;
    bool big; /* big-endian */
    ply_rows vertices, faces, edges;
    atomic_bool refused; /* copy_triangles() found an index out of range */
} binary_reader;

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "little-endian files are used in place");

/* ---- positions of rows ---- */

static size_t bytes_left(const ply_reader *r, const unsigned char *p) {
    return (size_t)((const unsigned char *)r->file.end - p);
}

/* Reads the length of the list at *p, and moves *p past it; false after a fault. */
static bool list_count(const binary_reader *b, const ply_property *list, const unsigned char **p,
                       uint64_t *out) {
    text_fault *fault = &b->r->fault;
    size_t size = scalar_size(list->count_type), left = bytes_left(b->r, *p);
    if (left < size) return text_wrong(fault, *p, list->name, "the file ends before the list's length");
    double count = scalar_load(*p, list->count_type, b->big);
    bool whole = list->count_type < SCALAR_FLOAT32 || count == floor(count);
    if (!(count >= 0 && count < 0x1p32) || !whole)
        return text_wrong(fault, *p, list->name, "a list of length %g", count);
    *out = (uint64_t)count;
    if (*out > (left - size) / scalar_size(list->type))
        return text_wrong(fault, *p, list->name,
                          "a list of %llu numbers does not fit into the %zu bytes that follow",
                          (unsigned long long)*out, left - size);
    *p += size;
    return true;
}

/* The end of the row at `p`, NULL after a fault. */
static const unsigned char *walk_row(const binary_reader *b, const ply_element *element,
                                     const unsigned char *p, size_t *offsets) {
    const unsigned char *begin = p;
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        offsets[i] = (size_t)(p - begin);
        uint64_t count = 1;
        if (property->is_list && !list_count(b, property, &p, &count)) return NULL;
        size_t bytes = (size_t)count * scalar_size(property->type);
        if (bytes > bytes_left(b->r, p)) {
            text_wrong(&b->r->fault, p, property->name, "the file ends before it");
            return NULL;
        }
        p += bytes;
    }
    return p;
}

/* Checks that all rows have lists of the same lengths as the first row, so that all rows have one size. By
 * induction: a row that starts at its assumed position and has these lengths ends where the next row is
 * assumed to start. */
typedef struct likeness {
    const ply_rows *rows;
    atomic_bool differs;
} likeness;

static void compare_rows(void *user, size_t begin, size_t end) {
    likeness *all = user;
    const ply_rows *rows = all->rows;
    bool differs = false;
    for (size_t k = 0; k < rows->element->properties.count; ++k) {
        const ply_property *property = &rows->element->properties.items[k];
        if (!property->is_list) continue;
        const unsigned char *count = rows->begin + rows->offsets[k];
        size_t size = scalar_size(property->count_type);
        if (size == 1) {
            for (size_t i = begin; i < end; ++i) differs |= count[i * rows->row] != *count;
        } else {
            for (size_t i = begin; i < end; ++i) differs |= memcmp(count + i * rows->row, count, size) != 0;
        }
    }
    if (differs) atomic_store(&all->differs, true);
}

static bool rows_are_alike(const binary_reader *b, const ply_rows *rows) {
    likeness all = {.rows = rows};
    if (rows->element->count > bytes_left(b->r, rows->begin) / rows->row) return false;
    loop_parallel(b->r->threads, (size_t)rows->element->count, 1u << 16, compare_rows, &all);
    return !all.differs;
}

/* False after a fault or when out of memory. */
static bool walk_rows(const binary_reader *b, ply_rows *rows) {
    const unsigned char *p = rows->begin;
    rows->blocks = malloc(rows->block_count * sizeof *rows->blocks);
    if (!rows->blocks) return text_no_memory(&b->r->fault);
    for (uint64_t i = 0; p && i < rows->element->count; ++i) {
        if (i % PLY_BLOCK == 0) rows->blocks[i / PLY_BLOCK] = p;
        p = walk_row(b, rows->element, p, rows->offsets);
    }
    rows->end = p;
    return p != NULL;
}

/* Finds the rows of the element, which begin at `begin`. */
static bool find_rows(const binary_reader *b, const ply_element *element, const unsigned char *begin,
                      ply_rows *out) {
    *out = (ply_rows){.element = element, .begin = begin, .end = begin};
    if (!element->count) return true;
    out->block_count = (size_t)((element->count + PLY_BLOCK - 1) / PLY_BLOCK);
    out->offsets = malloc(element->properties.count * sizeof *out->offsets);
    if (!out->offsets) return text_no_memory(&b->r->fault);
    const unsigned char *second = walk_row(b, element, begin, out->offsets);
    if (!second) return false;
    out->row = (size_t)(second - begin);
    if (!rows_are_alike(b, out)) return walk_rows(b, out);
    out->end = begin + element->count * out->row;
    return true;
}

static void free_rows(const ply_rows *rows) { free(rows->offsets), free(rows->blocks); }

/* Finds the rows of all elements up to the last one that is needed. */
static bool find_all_rows(binary_reader *b) {
    ply_reader *r = b->r;
    const unsigned char *p = (const unsigned char *)r->header.body;
    size_t last = r->vertex_element;
    if (r->face_element != SIZE_MAX && r->face_element > last) last = r->face_element;
    if (r->edge_element != SIZE_MAX && r->edge_element > last) last = r->edge_element;
    for (size_t i = 0; i <= last; ++i) {
        ply_rows rows;
        bool found = find_rows(b, &r->header.elements.items[i], p, &rows);
        p = rows.end;
        if (i == r->vertex_element)
            b->vertices = rows;
        else if (i == r->face_element)
            b->faces = rows;
        else if (i == r->edge_element)
            b->edges = rows;
        else
            free_rows(&rows);
        if (!found) return false;
    }
    if (last + 1 == r->header.elements.count)
        notes_add(&r->notes, bytes_left(r, p), "",
                  "bytes after the rows that the header promises are left out");
    return true;
}

/* Calls visit() for each row of a block, until it returns false. */
typedef bool row_visit(const binary_reader *b, uint64_t number, const unsigned char *row,
                       const size_t *offsets, void *user);

static void each_row(const binary_reader *b, const ply_rows *rows, size_t block, row_visit *visit,
                     void *user) {
    uint64_t first = (uint64_t)block * PLY_BLOCK, left = rows->element->count - first;
    uint64_t end = first + (left < PLY_BLOCK ? left : PLY_BLOCK);
    const unsigned char *row = rows->blocks ? rows->blocks[block] : rows->begin + first * rows->row;
    size_t *own = rows->blocks ? malloc(rows->element->properties.count * sizeof *own) : NULL;
    bool good = own || !rows->blocks || text_no_memory(&b->r->fault);
    for (uint64_t i = first; good && i < end; ++i) {
        const unsigned char *next = own ? walk_row(b, rows->element, row, own) : row + rows->row;
        good = next && visit(b, i, row, own ? own : rows->offsets, user);
        row = next;
    }
    free(own);
}

/* ---- vertices ---- */

/* Uses the mapped file in place if it has aligned little-endian floats in rows of one size. */
static void use_in_place(const binary_reader *b, ply_array *array) {
    const ply_rows *rows = &b->vertices;
    if (!array->present || rows->blocks || rows->row % sizeof(float) || b->big) return;
    if (b->r->splats && array->first_role == PLY_R) return;
    if (b->r->file.copy) return; /* the copy does not outlive the reader */
    size_t first = rows->offsets[b->r->role[array->first_role]];
    const unsigned char *values = rows->begin + first;
    if ((uintptr_t)values % sizeof(float)) return;
    for (int k = 0; k < array->components; ++k) {
        int property = b->r->role[array->first_role + k];
        if (rows->element->properties.items[property].type != SCALAR_FLOAT32) return;
        if (rows->offsets[property] != first + (size_t)k * sizeof(float)) return;
    }
    array->values = (const float *)(const void *)values;
    array->stride = rows->row;
}

static bool all_in_place(const ply_reader *r) {
    for (int a = 0; a < PLY_ARRAYS; ++a) {
        if (r->arrays[a].present && (!r->arrays[a].values || r->arrays[a].own)) return false;
    }
    return !r->moving;
}

/* Checks rows that need no conversion: true if all are finite. v - v is 0 for a finite v, else NaN. */
static bool check_in_place(const ply_reader *r, uint64_t begin, uint64_t end, scene_bounds *bounds) {
    float sum = 0, lower[3] = {INFINITY, INFINITY, INFINITY}, upper[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int a = 0; a < PLY_ARRAYS; ++a) {
        const ply_array *array = &r->arrays[a];
        if (!array->present) continue;
        const char *at = (const char *)array->values;
        for (uint64_t i = begin; i < end; ++i) {
            const float *v = (const float *)(const void *)(at + i * array->stride);
            for (int k = 0; k < array->components; ++k) sum += v[k] - v[k];
            for (int k = 0; k < 3 && a == PLY_POSITIONS; ++k) {
                lower[k] = v[k] < lower[k] ? v[k] : lower[k];
                upper[k] = v[k] > upper[k] ? v[k] : upper[k];
            }
        }
    }
    if (sum != 0) return false;
    bounds_add(bounds, widen(load_f32(lower)));
    bounds_add(bounds, widen(load_f32(upper)));
    return true;
}

static bool read_vertex(const binary_reader *b, uint64_t number, const unsigned char *row,
                        const size_t *offsets, void *bounds) {
    double values[PLY_ROLES] = {0};
    for (int role = 0; role < PLY_ROLES; ++role) {
        int property = b->r->role[role];
        if (property < 0) continue;
        values[role] = scalar_load(row + offsets[property],
                                   b->vertices.element->properties.items[property].type, b->big);
    }
    ply_put_vertex(b->r, (uint32_t)number, values, bounds);
    return true;
}

static void read_vertices(void *user, size_t begin, size_t end) {
    const binary_reader *b = user;
    scene_bounds bounds = bounds_empty();
    bool in_place = all_in_place(b->r);
    for (size_t block = begin; block < end; ++block) {
        uint64_t first = (uint64_t)block * PLY_BLOCK, last = first + PLY_BLOCK;
        if (last > b->r->vertex_count) last = b->r->vertex_count;
        if (in_place && check_in_place(b->r, first, last, &bounds)) continue;
        each_row(b, &b->vertices, block, read_vertex, &bounds);
    }
    ply_join_bounds(b->r, &bounds);
}

/* ---- faces ---- */

static const ply_property *index_list(const binary_reader *b) {
    return &b->faces.element->properties.items[b->r->index_list];
}

static bool read_uvs(const binary_reader *b, const unsigned char *p, ply_faces *faces) {
    const ply_property *list = &b->faces.element->properties.items[b->r->uv_list];
    uint64_t count;
    bool good = list_count(b, list, &p, &count);
    for (uint64_t i = 0; good && i < count; ++i, p += scalar_size(list->type))
        good = ply_push_uv(b->r, faces, scalar_load(p, list->type, b->big));
    return good;
}

/* The numbers of the row that have a role, by role. */
static void load_roles(const binary_reader *b, const ply_element *element, const unsigned char *row,
                       const size_t *offsets, double *out) {
    for (size_t i = 0; i < element->properties.count; ++i) {
        const ply_property *property = &element->properties.items[i];
        if (property->role >= 0) out[property->role] = scalar_load(row + offsets[i], property->type, b->big);
    }
}

static bool read_face(const binary_reader *b, uint64_t number, const unsigned char *row,
                      const size_t *offsets, void *user) {
    (void)number;
    double values[PLY_FACE_ROLES] = {0};
    ply_reader *r = b->r;
    ply_faces *faces = user;
    const ply_property *list = index_list(b);
    const unsigned char *p = row + offsets[r->index_list];
    uint64_t count;
    if (!list_count(b, list, &p, &count)) return false;
    for (uint64_t i = 0; i < count; ++i, p += scalar_size(list->type)) {
        double index = scalar_load(p, list->type, b->big);
        if (list->type >= SCALAR_INT64 && (!(fabs(index) < 0x1p53) || index != floor(index)))
            return text_wrong(&r->fault, p, b->faces.element->name,
                              "the index %g is not a whole number below 2^53", index);
        if (!ply_push_index(r, faces, (int64_t)index, p)) return false;
    }
    if (r->looks_read) load_roles(b, b->faces.element, row, offsets, values);
    if (r->uv_list != SIZE_MAX && !read_uvs(b, row + offsets[r->uv_list], faces)) return false;
    return ply_end_row(r, faces, values);
}

static void read_blocks(void *user, size_t begin, size_t end) {
    const binary_reader *b = user;
    for (size_t block = begin; block < end; ++block)
        each_row(b, &b->faces, block, read_face, &b->r->pieces[block]);
}

static void copy_triangles(void *user, size_t begin, size_t end) {
    binary_reader *b = user;
    const ply_property *list = index_list(b);
    size_t row = b->faces.row;
    const unsigned char *p =
        b->faces.begin + b->faces.offsets[b->r->index_list] + scalar_size(list->count_type) + begin * row;
    uint32_t *out = b->r->indices + 3 * begin, highest = 0;
    for (uint64_t i = begin; i < end; ++i, p += row, out += 3) {
        for (int k = 0; k < 3; ++k) {
            out[k] = scalar_load_32(p + 4 * k, b->big);
            highest = out[k] > highest ? out[k] : highest;
        }
    }
    if (highest >= b->r->vertex_count) atomic_store(&b->refused, true);
}

/* True if all faces are only triangles with 32-bit indices, by far the most common case. Negative indices,
 * read as unsigned, are out of range. */
static bool has_plain_triangles(const binary_reader *b) {
    const ply_property *list = index_list(b);
    if (b->r->looks_read || b->r->uv_list != SIZE_MAX) return false;
    if (b->faces.blocks || b->r->strips || (list->type != SCALAR_INT32 && list->type != SCALAR_UINT32))
        return false;
    return scalar_load(b->faces.begin + b->faces.offsets[b->r->index_list], list->count_type, b->big) == 3;
}

static fathom_status read_faces(binary_reader *b) {
    ply_reader *r = b->r;
    if (has_plain_triangles(b)) {
        fathom_status status = ply_allocate_triangles(r, b->faces.element->count);
        if (status != FATHOM_OK) return status;
        loop_parallel(r->threads, r->triangle_count, 1u << 15, copy_triangles, b);
        if (!b->refused) return FATHOM_OK;
    }
    fathom_status status = ply_make_pieces(r, b->faces.block_count);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, r->piece_count, 1, read_blocks, b);
    return ply_join_faces(r);
}

/* ---- edges ---- */

static bool read_edge(const binary_reader *b, uint64_t number, const unsigned char *row,
                      const size_t *offsets, void *user) {
    (void)user;
    double ends[PLY_ENDS] = {0};
    load_roles(b, b->edges.element, row, offsets, ends);
    return ply_put_edge(b->r, number, ends, row);
}

static void read_edges(void *user, size_t begin, size_t end) {
    const binary_reader *b = user;
    for (size_t block = begin; block < end; ++block) each_row(b, &b->edges, block, read_edge, NULL);
}

fathom_status ply_read_binary(ply_reader *r) {
    binary_reader b = {.r = r, .big = r->header.format == PLY_BIG};
    bool found = find_all_rows(&b);
    for (int a = 0; found && a < PLY_ARRAYS; ++a) use_in_place(&b, &r->arrays[a]);
    fathom_status status = found ? ply_read_vertices(r, b.vertices.block_count, 16, read_vertices, &b)
                                 : text_status(&r->file, &r->fault);
    if (status == FATHOM_OK && r->face_element != SIZE_MAX) status = read_faces(&b);
    if (status == FATHOM_OK) {
        loop_parallel(r->threads, b.edges.block_count, 1, read_edges, &b);
        status = text_status(&r->file, &r->fault);
    }
    free_rows(&b.vertices);
    free_rows(&b.edges);
    free_rows(&b.faces);
    return status;
}
