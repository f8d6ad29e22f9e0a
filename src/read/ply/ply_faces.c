#include "read/ply/ply.h"

#include "base/threads.h"

#include <stdlib.h>
#include <string.h>

bool ply_check_index(ply_reader *r, int64_t index, const void *at) {
    if (index >= 0 && index < (int64_t)r->vertex_count) return true;
    return ply_wrong(r, at, r->header.elements.items[r->face_element].name,
                     "vertex index %lld is out of range; there are %u vertices", (long long)index,
                     r->vertex_count);
}

static bool push_triangle(ply_faces *faces, int64_t a, int64_t b, int64_t c) {
    if (!array_room(&faces->indices, 3)) {
        faces->out_of_memory = true;
        return false;
    }
    uint32_t *out = faces->indices.items + faces->indices.count;
    out[0] = (uint32_t)a, out[1] = (uint32_t)b, out[2] = (uint32_t)c;
    faces->indices.count += 3;
    return true;
}

static bool push_polygon(ply_reader *r, ply_faces *faces, const void *at) {
    const int64_t *row = faces->row.items;
    size_t n = faces->row.count;
    for (size_t i = 0; i < n; ++i) {
        if (!ply_check_index(r, row[i], at)) return false;
    }
    if (n < 3) {
        ++faces->small;
        return true;
    }
    polygon_fan polygon = {faces->indices.count / 3, (uint32_t)n};
    if (n > 3 && !array_push(&faces->polygons, polygon)) {
        faces->out_of_memory = true;
        return false;
    }
    for (size_t i = 2; i < n; ++i) {
        if (!push_triangle(faces, row[0], row[i - 1], row[i])) return false;
    }
    return true;
}

/* Each index makes a triangle with the two before it; every other triangle is turned to keep the winding. -1
 * ends a strip. */
static bool push_strips(ply_reader *r, ply_faces *faces, const void *at) {
    const int64_t *row = faces->row.items;
    size_t length = 0;
    for (size_t i = 0; i < faces->row.count; ++i) {
        if (row[i] == -1) {
            length = 0;
            continue;
        }
        if (!ply_check_index(r, row[i], at)) return false;
        if (++length < 3) continue;
        bool odd = length % 2 == 0;
        if (!push_triangle(faces, row[odd ? i - 1 : i - 2], row[odd ? i - 2 : i - 1], row[i])) return false;
    }
    return true;
}

bool ply_push_row(ply_reader *r, ply_faces *faces, const void *at) {
    return r->strips ? push_strips(r, faces, at) : push_polygon(r, faces, at);
}

typedef struct ply_join {
    ply_reader *r;
    ply_faces *faces;
} ply_join;

static void join_pieces(void *user, size_t begin, size_t end, unsigned worker) {
    (void)worker;
    const ply_join *join = user;
    polygon_work work = {0};
    const polygon_vertices vertices = {join->r->arrays[PLY_POSITIONS].values,
                                       join->r->arrays[PLY_POSITIONS].stride};
    for (size_t i = begin; i < end; ++i) {
        ply_faces *faces = &join->faces[i];
        if (!faces->indices.count) continue;
        uint32_t *out = join->r->indices + 3 * faces->target;
        memcpy(out, faces->indices.items, faces->indices.count * sizeof *out);
        for (size_t k = 0; k < faces->polygons.count; ++k) {
            polygon_fan polygon = faces->polygons.items[k];
            if (!polygon_split(&work, &vertices, polygon.corners, out + 3 * polygon.first, NULL, NULL)) {
                ply_no_memory(join->r);
                break;
            }
        }
    }
    polygon_work_free(&work);
}

fathom_status ply_join_faces(ply_reader *r, ply_faces *faces, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        if (faces[i].out_of_memory) ply_no_memory(r);
        faces[i].target = r->triangle_count;
        r->triangle_count += faces[i].indices.count / 3;
        r->small += faces[i].small;
    }
    fathom_status status = ply_status(r);
    if (status != FATHOM_OK || !r->triangle_count) return status;
    if (r->triangle_count >= UINT32_MAX)
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         "%zu triangles; at most 2^32 - 2 fit into a mesh", r->triangle_count);
    void *memory;
    status = scene_allocate_items(r->scene, r->triangle_count, 3 * sizeof *r->indices, &memory);
    if (status != FATHOM_OK) return status;
    r->indices = memory;
    loop_parallel(r->threads, count, 1, join_pieces, &(ply_join){r, faces});
    return ply_status(r);
}

void ply_free_faces(ply_faces *faces) {
    array_free(&faces->indices);
    array_free(&faces->polygons);
    array_free(&faces->row);
}
