#include "read/ply/ply.h"

#include "read/mesh/lost.h"

#include <float.h>
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

bool ply_push_uv(ply_reader *r, ply_faces *faces, double value) {
    const bool good = fabs(value) <= (double)FLT_MAX;
    faces->odd += !good;
    return array_push(&faces->row_uvs, good ? (float)value : 0) || text_no_memory(&r->fault);
}

/* Texture coordinates for the n corners of the row, and for its triangles. */
static bool push_uvs(ply_reader *r, ply_faces *faces, size_t n) {
    const uint32_t first = (uint32_t)(faces->uvs.count / 2);
    const bool good = faces->row_uvs.count == 2 * n;
    if (r->uv_list == SIZE_MAX) return true;
    if (!array_room(&faces->uvs, 2 * n) || !array_room(&faces->uv_indices, 3 * (n - 2))) return false;
    faces->bad_uvs += !good;
    for (size_t i = 0; i < 2 * n; ++i)
        faces->uvs.items[faces->uvs.count++] = good ? faces->row_uvs.items[i] : 0;
    uint32_t *out = faces->uv_indices.items + faces->uv_indices.count;
    for (uint32_t i = 2; i < n; ++i, out += 3) out[0] = first, out[1] = first + i - 1, out[2] = first + i;
    faces->uv_indices.count += 3 * (n - 2);
    return true;
}

/* Colour and texture for the triangles of the row. MeshLab writes -1 for no texture. */
static bool push_looks(const ply_reader *r, ply_faces *faces, size_t triangles,
                       double values[PLY_FACE_ROLES]) {
    if (!r->looks_read) return true;
    const double count = (double)r->textures.count, texture = values[PLY_TEXNUMBER];
    const bool known = texture >= 0 && texture < count;
    ply_look look = {.texture = (uint32_t)(known ? texture : count)};
    for (int role = 0; role < PLY_TEXNUMBER; ++role) {
        const bool good = fabs(values[role]) <= (double)FLT_MAX;
        faces->odd += !good;
        values[role] = good ? values[role] : 0;
    }
    for (int c = 0; c < 4; ++c) look.color[c] = (float)values[PLY_FACE_R + c];
    faces->no_texture += count > 0 && !known && texture != -1;
    for (size_t i = 0; i < triangles; ++i) {
        if (!array_push(&faces->looks, look)) return false;
    }
    return true;
}

bool ply_end_row(ply_reader *r, ply_faces *faces, double values[PLY_FACE_ROLES]) {
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
    } else if (!push_uvs(r, faces, n) || !push_looks(r, faces, n - 2, values)) {
        return text_no_memory(&r->fault);
    } else {
        for (size_t i = 2; i < n; ++i) push_triangle(faces, row[0], row[i - 1], row[i]);
    }
    faces->row.count = faces->row_uvs.count = 0;
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

void ply_drop_lost(ply_reader *r) {
    float *positions = r->arrays[PLY_POSITIONS].own;
    const lost_rows looks[2] = {{r->uv_indices, 3 * sizeof *r->uv_indices}, {r->looks, sizeof *r->looks}},
                    none[2] = {{NULL, 0}, {NULL, 0}},
                    colors = {r->arrays[PLY_COLORS].own,
                              (size_t)r->arrays[PLY_COLORS].components * sizeof(float)};
    r->triangle_count = lost_drop(positions, r->indices, 3, r->triangle_count, looks);
    if (r->edge_element != SIZE_MAX) {
        uint64_t *count = &r->header.elements.items[r->edge_element].count;
        *count = lost_drop(positions, r->edges, PLY_ENDS, (size_t)*count, none);
    }
    if (r->face_element == SIZE_MAX && r->edge_element == SIZE_MAX)
        r->vertex_count = (uint32_t)lost_drop_points(positions, r->vertex_count, &colors);
    lost_mend(positions, r->vertex_count);
}

static void join_looks(const ply_reader *r, const ply_faces *faces) {
    for (size_t i = 0; i < faces->uv_indices.count; ++i)
        r->uv_indices[3 * faces->target + i] = (uint32_t)faces->uv_target + faces->uv_indices.items[i];
    if (faces->uvs.count)
        memcpy(r->uvs + 2 * faces->uv_target, faces->uvs.items, faces->uvs.count * sizeof *r->uvs);
    if (faces->looks.count)
        memcpy(r->looks + faces->target, faces->looks.items, faces->looks.count * sizeof *r->looks);
}

static void join_pieces(void *user, size_t begin, size_t end) {
    ply_reader *r = user;
    polygon_work work = {0};
    const polygon_vertices vertices = {r->arrays[PLY_POSITIONS].values, r->arrays[PLY_POSITIONS].stride};
    for (size_t i = begin; i < end; ++i) {
        const ply_faces *faces = &r->pieces[i];
        uint32_t *out = r->indices + 3 * faces->target;
        uint32_t *uvs = r->uv_indices ? r->uv_indices + 3 * faces->target : NULL;
        if (faces->indices.count) memcpy(out, faces->indices.items, faces->indices.count * sizeof *out);
        join_looks(r, faces);
        for (size_t k = 0; k < faces->polygons.count; ++k) {
            polygon_fan polygon = faces->polygons.items[k];
            if (!polygon_split(&work, &vertices, polygon.corners, out + 3 * polygon.first,
                               uvs ? uvs + 3 * polygon.first : NULL, NULL))
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

/* Allocates what triangles have from their faces; uvs: the number of texture coordinates. */
static fathom_status allocate_looks(ply_reader *r, size_t uvs) {
    void *memory = NULL;
    if (uvs >= UINT32_MAX)
        return fail_file(r->scene->context, FATHOM_BAD_INPUT, r->file.path,
                         "texcoord: %zu corners; at most 2^32 - 2 fit into a mesh", uvs);
    if (uvs) {
        fathom_status status =
            scene_allocate_items(r->scene, r->triangle_count, 3 * sizeof *r->uv_indices, &memory);
        if (status != FATHOM_OK) return status;
        r->uv_indices = memory;
        r->uvs = malloc(uvs * 2 * sizeof *r->uvs);
        if (!r->uvs) return fail_memory(r->scene->context, uvs * 2 * sizeof *r->uvs);
    }
    if (!r->looks_read) return FATHOM_OK;
    r->looks = malloc(r->triangle_count * sizeof *r->looks);
    return r->looks ? FATHOM_OK : fail_memory(r->scene->context, r->triangle_count * sizeof *r->looks);
}

static void note_faces(ply_reader *r, const ply_faces *faces) {
    notes_add(&r->notes, faces->small, "", "faces of less than 3 corners are left out");
    notes_add(&r->notes, faces->bad_uvs, "",
              "texcoord: a face without 2 numbers for each corner gets 0 for all of them");
    notes_add(&r->notes, faces->odd, "", "a NaN or an infinity of a face is taken as 0");
    notes_add(&r->notes, faces->no_texture, "",
              "texnumber: a face with the number of no TextureFile gets no texture");
}

fathom_status ply_join_faces(ply_reader *r) {
    uint64_t triangles = 0;
    size_t uvs = 0;
    for (size_t i = 0; i < r->piece_count; ++i) {
        r->pieces[i].target = (size_t)triangles, r->pieces[i].uv_target = uvs;
        triangles += r->pieces[i].indices.count / 3;
        uvs += r->pieces[i].uvs.count / 2;
        note_faces(r, &r->pieces[i]);
    }
    fathom_status status = text_status(&r->file, &r->fault);
    if (status != FATHOM_OK || !triangles) return status;
    status = ply_allocate_triangles(r, triangles);
    if (status == FATHOM_OK) status = allocate_looks(r, uvs);
    if (status != FATHOM_OK) return status;
    loop_parallel(r->threads, r->piece_count, 1, join_pieces, r);
    return text_status(&r->file, &r->fault);
}
