#include "read/ply/ply.h"

#include "base/threads.h"

#include <stdlib.h>

typedef struct binary_reader {
    ply_reader *r;
    bool big;
    ply_rows vertices, faces;
    bool moving;       /* vertices are stored a second time, from the origin */
    ply_faces *pieces; /* one for each block, where faces are not all alike */
    uint32_t corners;  /* of every face, where they are */
} binary_reader;

/* Uses the mapped file in place where it holds aligned little-endian floats in rows of one size. */
static void use_in_place(binary_reader *b, ply_array *array) {
    const ply_rows *rows = &b->vertices;
    if (!array->present || rows->blocks || rows->row % sizeof(float) || b->big) return;
    if (b->r->file.copy) return; /* it does not outlive the reader */
    size_t first = rows->offsets[b->r->role[array->first_role]];
    const unsigned char *values = rows->begin + first;
    if ((uintptr_t)values % sizeof(float)) return;
    for (int k = 0; k < array->components; ++k) {
        int property = b->r->role[array->first_role + k];
        if (rows->element->properties.items[property].type != PLY_FLOAT32) return;
        if (rows->offsets[property] != first + (size_t)k * sizeof(float)) return;
    }
    array->values = (const float *)(const void *)values;
    array->stride = rows->row;
}

static bool all_in_place(const ply_reader *r) {
    for (int a = 0; a < PLY_ARRAYS; ++a) {
        if (r->arrays[a].present && (!r->arrays[a].values || r->arrays[a].own)) return false;
    }
    return true;
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

static void load_vertex(const binary_reader *b, const ply_row *row, double values[PLY_ROLES]) {
    for (int role = 0; role < PLY_ROLES; ++role) {
        int property = b->r->role[role];
        values[role] = 0;
        if (property < 0) continue;
        values[role] = ply_load(row->at + row->offsets[property],
                                b->vertices.element->properties.items[property].type, b->big);
    }
}

static void read_vertex_block(const binary_reader *b, size_t block, scene_bounds *bounds) {
    ply_row row;
    double values[PLY_ROLES];
    bool more = ply_first_row(b->r, &b->vertices, block, &row);
    for (; more; more = more && ply_next_row(b->r, &b->vertices, &row)) {
        load_vertex(b, &row, values);
        if (b->moving)
            ply_put_position(b->r, (uint32_t)row.number, values);
        else
            more = ply_put_vertex(b->r, (uint32_t)row.number, values, row.at, bounds);
    }
    ply_free_row(&row);
}

static void read_vertices(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const binary_reader *b = user;
    scene_bounds bounds = bounds_empty();
    bool in_place = !b->moving && all_in_place(b->r);
    for (size_t block = begin; block < end; ++block) {
        uint64_t first = (uint64_t)block * PLY_BLOCK, last = first + PLY_BLOCK;
        if (last > b->r->vertex_count) last = b->r->vertex_count;
        if (in_place && check_in_place(b->r, first, last, &bounds)) continue;
        read_vertex_block(b, block, &bounds);
    }
    ply_join_bounds(b->r, &bounds);
}

static fathom_status read_all_vertices(binary_reader *b) {
    ply_reader *r = b->r;
    for (int a = 0; a < PLY_ARRAYS; ++a) use_in_place(b, &r->arrays[a]);
    fathom_status status = ply_allocate_arrays(r);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, b->vertices.block_count, 16, read_vertices, b);
    status = ply_status(r);
    if (status == FATHOM_OK) status = ply_choose_origin(r, &b->moving);
    if (status == FATHOM_OK && b->moving)
        loop_parallel(r->threads, b->vertices.block_count, 16, read_vertices, b);
    return status;
}

static const ply_property *index_list(const binary_reader *b) {
    return &b->faces.element->properties.items[b->r->index_list];
}

/* The index may be out of range on either side. */
static bool load_index(const binary_reader *b, ply_type type, const unsigned char *p, int64_t *out) {
    double index = ply_load(p, type, b->big);
    if (!(fabs(index) < 0x1p53) || index != floor(index)) {
        return ply_wrong(b->r, p, b->faces.element->name, "the index %g is not a whole number", index);
    }
    *out = (int64_t)index;
    return true;
}

/* When all faces have the same number of corners, the row number gives the place of its triangles. */
static bool read_alike_row(const binary_reader *b, uint64_t number, polygon_work *work) {
    ply_reader *r = b->r;
    const ply_property *list = index_list(b);
    const unsigned char *p =
        b->faces.begin + number * b->faces.row + b->faces.offsets[r->index_list] + ply_size(list->count_type);
    uint32_t *out = r->indices + 3 * number * (b->corners - 2), *fan = out, first = 0, last = 0;
    for (uint32_t i = 0; i < b->corners; ++i, p += ply_size(list->type)) {
        int64_t index = 0;
        if (!load_index(b, list->type, p, &index) || !ply_check_index(r, index, p)) return false;
        if (i == 0) first = (uint32_t)index;
        if (i >= 2) {
            *out++ = first;
            *out++ = last;
            *out++ = (uint32_t)index;
        }
        last = (uint32_t)index;
    }
    const polygon_vertices vertices = {r->arrays[PLY_POSITIONS].values, r->arrays[PLY_POSITIONS].stride};
    if (!polygon_split(work, &vertices, b->corners, fan, NULL, NULL)) ply_no_memory(r);
    return true;
}

/* Copies triangles of 32-bit numbers, by far the most common. False if an index is out of range (negative
 * ones are above 2^31 here): the slow path then finds it. */
static bool copy_triangles(const binary_reader *b, uint64_t begin, uint64_t end) {
    const ply_property *list = index_list(b);
    if (b->corners != 3 || (list->type != PLY_INT32 && list->type != PLY_UINT32)) return false;
    size_t row = b->faces.row;
    const unsigned char *p =
        b->faces.begin + b->faces.offsets[b->r->index_list] + ply_size(list->count_type) + begin * row;
    uint32_t *out = b->r->indices + 3 * begin, highest = 0;
    for (uint64_t i = begin; i < end; ++i, p += row, out += 3) {
        for (int k = 0; k < 3; ++k) {
            out[k] = ply_load_32(p + 4 * k, b->big);
            highest = out[k] > highest ? out[k] : highest;
        }
    }
    return highest < b->r->vertex_count;
}

static void read_alike(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const binary_reader *b = user;
    if (copy_triangles(b, begin, end)) return;
    polygon_work work = {0};
    for (uint64_t i = begin; i < end; ++i) {
        if (!read_alike_row(b, i, &work)) break;
    }
    polygon_work_free(&work);
}

static fathom_status read_alike_faces(binary_reader *b, uint64_t corners) {
    ply_reader *r = b->r;
    uint64_t count = b->faces.element->count;
    if (corners < 3) {
        r->small = (size_t)count;
        return FATHOM_OK;
    }
    /* Each corner has bytes in the file, so no product overflows. */
    if (count * (corners - 2) >= UINT32_MAX) {
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         "%llu triangles; at most 2^32 - 2 fit into a mesh",
                         (unsigned long long)(count * (corners - 2)));
    }
    r->triangle_count = (size_t)(count * (corners - 2));
    b->corners = (uint32_t)corners;
    void *memory;
    fathom_status status = scene_allocate_items(r->scene, r->triangle_count, 3 * sizeof *r->indices, &memory);
    if (status != FATHOM_OK) return status;
    r->indices = memory;
    loop_parallel(r->threads, (size_t)count, 1u << 15, read_alike, b);
    return ply_status(r);
}

static bool read_face_row(const binary_reader *b, const ply_row *row, ply_faces *faces) {
    ply_reader *r = b->r;
    const ply_property *list = index_list(b);
    const unsigned char *p = row->at + row->offsets[r->index_list];
    uint64_t count;
    if (!ply_list_count(r, list, &p, &count)) return false;
    faces->row.count = 0;
    if (!array_room(&faces->row, (size_t)count)) {
        faces->out_of_memory = true;
        return false;
    }
    for (uint64_t i = 0; i < count; ++i, p += ply_size(list->type)) {
        if (!load_index(b, list->type, p, &faces->row.items[i])) return false;
    }
    faces->row.count = (size_t)count;
    return ply_push_row(r, faces, row->at);
}

static void read_blocks(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const binary_reader *b = user;
    for (size_t block = begin; block < end; ++block) {
        ply_row row;
        bool more = ply_first_row(b->r, &b->faces, block, &row);
        while (more) more = read_face_row(b, &row, &b->pieces[block]) && ply_next_row(b->r, &b->faces, &row);
        ply_free_row(&row);
    }
}

static fathom_status read_mixed_faces(binary_reader *b) {
    ply_reader *r = b->r;
    b->pieces = calloc(b->faces.block_count, sizeof *b->pieces);
    if (!b->pieces) return fail_memory(r->scene->context, b->faces.block_count * sizeof *b->pieces);
    loop_parallel(r->threads, b->faces.block_count, 1, read_blocks, b);
    fathom_status status = ply_join_faces(r, b->pieces, b->faces.block_count);
    for (size_t i = 0; i < b->faces.block_count; ++i) ply_free_faces(&b->pieces[i]);
    free(b->pieces);
    return status;
}

static fathom_status read_all_faces(binary_reader *b) {
    if (b->faces.blocks || b->r->strips) return read_mixed_faces(b);
    const unsigned char *p = b->faces.begin + b->faces.offsets[b->r->index_list];
    uint64_t corners;
    if (!ply_list_count(b->r, index_list(b), &p, &corners)) return ply_status(b->r);
    return read_alike_faces(b, corners);
}

/* Walks through all elements up to the last one that is needed. */
static fathom_status find_rows(binary_reader *b) {
    ply_reader *r = b->r;
    const unsigned char *p = (const unsigned char *)r->header.body;
    size_t last = r->vertex_element > r->face_element ? r->vertex_element : r->face_element;
    for (size_t i = 0; i <= last; ++i) {
        ply_rows rows;
        fathom_status status = ply_find_rows(r, &r->header.elements.items[i], p, &rows);
        p = rows.end;
        if (i == r->vertex_element)
            b->vertices = rows;
        else if (i == r->face_element)
            b->faces = rows;
        else
            ply_free_rows(&rows);
        if (status != FATHOM_OK) return status;
    }
    if (last + 1 == r->header.elements.count)
        notes_add(&r->notes, (size_t)((const unsigned char *)r->file.end - p), "",
                  "bytes after the rows that the header promises are left out");
    return FATHOM_OK;
}

fathom_status ply_read_binary(ply_reader *r) {
    binary_reader b = {.r = r, .big = r->header.format == PLY_BIG};
    fathom_status status = find_rows(&b);
    if (status == FATHOM_OK) status = read_all_vertices(&b);
    if (status == FATHOM_OK) status = read_all_faces(&b);
    ply_free_rows(&b.vertices);
    ply_free_rows(&b.faces);
    return status;
}
