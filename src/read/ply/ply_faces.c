#include "read/ply/ply.h"

#include <stdlib.h>
#include <string.h>

fathom_status ply_make_pieces(ply_reader *r, size_t count) {
    r->pieces = calloc(count + 1, sizeof *r->pieces);
    r->piece_count = r->pieces ? count : 0;
    return r->pieces ? FATHOM_OK : fail_memory(r->scene->context, (count + 1) * sizeof *r->pieces);
}

bool ply_push_checked(ply_reader *r, ply_faces *faces, int64_t index, const void *at) {
    bool valid = index >= 0 && index < (int64_t)r->vertex_count;
    if (!valid && !(r->strips && index == -1))
        return text_wrong(&r->fault, at, r->header.elements.items[r->face_element].name,
                          "vertex index %lld is out of range; there are %u vertices", (long long)index,
                          r->vertex_count);
    return array_push(&faces->row, valid ? (uint32_t)index : UINT32_MAX) || text_no_memory(&r->fault);
}

static void push_triangle(ply_faces *faces, uint32_t a, uint32_t b, uint32_t c) {
    uint32_t *out = faces->indices.items + faces->indices.count;
    out[0] = a, out[1] = b, out[2] = c;
    faces->indices.count += 3;
}

/* Each index forms a triangle with the two before it. Every second triangle is reversed to keep the
 * winding. */
static void push_strips(ply_faces *faces) {
    const uint32_t *row = faces->row.items;
    size_t length = 0;
    for (size_t i = 0; i < faces->row.count; ++i) {
        length = row[i] == UINT32_MAX ? 0 : length + 1;
        if (length < 3) continue;
        bool odd = length % 2 == 0;
        push_triangle(faces, row[odd ? i - 1 : i - 2], row[odd ? i - 2 : i - 1], row[i]);
    }
}

bool ply_end_row(ply_reader *r, ply_faces *faces) {
    const uint32_t *row = faces->row.items;
    const size_t n = faces->row.count;
    const polygon_fan polygon = {faces->indices.count / 3, (uint32_t)n};
    if (n < 3) {
        faces->small += !r->strips;
    } else if (!array_room(&faces->indices, 3 * (n - 2)) ||
               (n > 3 && !r->strips && !array_push(&faces->polygons, polygon))) {
        return text_no_memory(&r->fault);
    } else if (r->strips) {
        push_strips(faces);
    } else {
        for (size_t i = 2; i < n; ++i) push_triangle(faces, row[0], row[i - 1], row[i]);
    }
    faces->row.count = 0;
    return true;
}

bool ply_put_edge(ply_reader *r, uint64_t i, const double values[PLY_ENDS], const void *at) {
    for (int end = 0; end < PLY_ENDS; ++end) {
        const double index = values[end];
        if (!(index >= 0 && index < (double)r->vertex_count) || index != floor(index))
            return text_wrong(&r->fault, at, end == PLY_FROM ? "vertex1" : "vertex2",
                              "edge %llu: expected a number of a vertex, of which there are %u, found %g",
                              (unsigned long long)i, r->vertex_count, index);
        r->edges[2 * i + (unsigned)end] = (uint32_t)index;
    }
    return true;
}

static void join_pieces(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    ply_reader *r = user;
    polygon_work work = {0};
    const polygon_vertices vertices = {r->arrays[PLY_POSITIONS].values, r->arrays[PLY_POSITIONS].stride};
    for (size_t i = begin; i < end; ++i) {
        const ply_faces *faces = &r->pieces[i];
        uint32_t *out = r->indices + 3 * faces->target;
        if (faces->indices.count) memcpy(out, faces->indices.items, faces->indices.count * sizeof *out);
        for (size_t k = 0; k < faces->polygons.count; ++k) {
            polygon_fan polygon = faces->polygons.items[k];
            if (!polygon_split(&work, &vertices, polygon.corners, out + 3 * polygon.first, NULL, NULL))
                text_no_memory(&r->fault);
        }
    }
    polygon_work_free(&work);
}

fathom_status ply_allocate_triangles(ply_reader *r, uint64_t count) {
    void *memory;
    if (count >= UINT32_MAX)
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         "%llu triangles; at most 2^32 - 2 fit into a mesh", (unsigned long long)count);
    fathom_status status = scene_allocate_items(r->scene, (size_t)count, 3 * sizeof *r->indices, &memory);
    r->indices = status == FATHOM_OK ? memory : NULL;
    r->triangle_count = (size_t)count;
    return status;
}

fathom_status ply_join_faces(ply_reader *r) {
    uint64_t triangles = 0;
    size_t small = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        r->pieces[i].target = (size_t)triangles;
        triangles += r->pieces[i].indices.count / 3;
        small += r->pieces[i].small;
    }
    notes_add(&r->notes, small, "", "faces of less than 3 corners are left out");
    fathom_status status = text_status(&r->file, &r->fault);
    if (status != FATHOM_OK || !triangles) return status;
    status = ply_allocate_triangles(r, triangles);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, r->piece_count, 1, join_pieces, r);
    return text_status(&r->file, &r->fault);
}
