/* PLY: little-endian binary, instances are placed. Normals and uvs are written if any mesh has them. A vertex
 * has one normal, so flat meshes among smooth ones get a vertex for each corner, with the facet's normal. */
#include "write/write.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ply {
    const fathom_scene *scene;
    const scene_graph *graph;
    const char *path;
    write_stream stream;
    write_mesh *meshes; /* one for each of the scene's meshes */
    bool normals, uvs;
    size_t vertices, triangles; /* in all */
    size_t first_vertex;        /* of the placement being written */
} ply;

/* ---- counting ---- */

/* Notes the arrays of a mesh, and prepares it once the arrays of all meshes are known. */
static fathom_status count_mesh(ply *p, uint32_t index, size_t ways, bool prepare) {
    const fathom_mesh *mesh = &p->scene->meshes.items[index];
    write_mesh *m = &p->meshes[index];
    p->normals |= mesh->normals != NULL;
    p->uvs |= mesh->uvs != NULL;
    if (!prepare) return FATHOM_OK;
    fathom_status status = write_mesh_prepare(p->scene->context, mesh, p->normals && !mesh->normals, m);
    p->vertices = write_add(p->vertices, write_multiply(ways, m->vertex_count));
    p->triangles = write_add(p->triangles, write_multiply(ways, mesh->triangle_count));
    return status;
}

static fathom_status count_meshes(ply *p, const size_t *ways, bool prepare) {
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < p->scene->objects.count && status == FATHOM_OK; ++i) {
        scene_object object = p->scene->objects.items[i];
        if (object.kind == SCENE_MESH && ways[object.group])
            status = count_mesh(p, object.index, ways[object.group], prepare);
    }
    return status;
}

static fathom_status count_all(ply *p) {
    size_t *ways;
    fathom_status status = write_count_ways(p->scene, p->graph, &ways);
    if (status == FATHOM_OK) status = count_meshes(p, ways, false);
    if (status == FATHOM_OK) status = count_meshes(p, ways, true);
    free(ways);
    if (status == FATHOM_OK && (p->vertices > UINT32_MAX || p->triangles > UINT32_MAX)) {
        return fail_file(
            p->scene->context, FATHOM_BAD_USAGE, p->path,
            "with all instances placed there are %zu vertices and %zu triangles, and PLY counts to "
            "4294967295; .glb keeps instances as they are",
            p->vertices, p->triangles);
    }
    return status;
}

/* ---- writing ---- */

/* Returns the length. `blanks` follow the comment. */
static int format_header(const ply *p, int blanks, char text[512]) {
    return snprintf(text, 512,
                    "ply\nformat binary_little_endian 1.0\ncomment Fathom %s%*s\nelement vertex %zu\n"
                    "property float x\nproperty float y\nproperty float z\n%s%selement face %zu\n"
                    "property list uchar uint vertex_indices\nend_header\n",
                    fathom_version(), blanks, "", p->vertices,
                    p->normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
                    p->uvs ? "property float s\nproperty float t\n" : "", p->triangles);
}

/* Padded to a multiple of 4 bytes, so that the vertices can be used in the mapped file. */
static void put_header(ply *p) {
    char text[512];
    int length = format_header(p, 0, text);
    length = format_header(p, (4 - length % 4) % 4, text);
    file_writer_put(p->stream.file, text, (size_t)length);
}

typedef struct ply_part {
    const ply *p;
    const write_mesh *mesh;
    const write_placement *at;
} ply_part;

static size_t format_vertices(const void *user, size_t begin, size_t end, char *out) {
    const ply_part *part = user;
    char *start = out;
    for (uint32_t i = (uint32_t)begin; i < end; ++i) {
        float numbers[8];
        size_t count = 3;
        store_f32(numbers, write_placed_position(part->at, write_mesh_position(part->mesh, i)));
        if (part->p->normals) {
            store_f32(numbers + count, write_placed_normal(part->at, write_mesh_normal(part->mesh, i)));
            count += 3;
        }
        if (part->p->uvs) write_mesh_uv(part->mesh, i, numbers + count), count += 2;
        memcpy(out, numbers, count * sizeof *numbers);
        out += count * sizeof *numbers;
    }
    return (size_t)(out - start);
}

#define FACE_BYTES 13

static size_t format_faces(const void *user, size_t begin, size_t end, char *out) {
    const ply_part *part = user;
    uint32_t first = (uint32_t)part->p->first_vertex;
    size_t second = part->at->mirrored ? 2 : 1;
    for (size_t t = begin; t < end; ++t, out += FACE_BYTES) {
        uint32_t corners[3] = {first + write_mesh_index(part->mesh, 3 * t),
                               first + write_mesh_index(part->mesh, 3 * t + second),
                               first + write_mesh_index(part->mesh, 3 * t + 3 - second)};
        *out = 3;
        memcpy(out + 1, corners, sizeof corners);
    }
    return (end - begin) * FACE_BYTES;
}

static fathom_status put_vertices(void *user, const write_placement *at) {
    ply *p = user;
    ply_part part = {p, &p->meshes[at->mesh_index], at};
    write_items(&p->stream, part.mesh->vertex_count, 8 * sizeof(float), format_vertices, &part);
    return FATHOM_OK;
}

static fathom_status put_faces(void *user, const write_placement *at) {
    ply *p = user;
    ply_part part = {p, &p->meshes[at->mesh_index], at};
    write_items(&p->stream, at->mesh->triangle_count, FACE_BYTES, format_faces, &part);
    p->first_vertex += part.mesh->vertex_count;
    return FATHOM_OK;
}

static fathom_status put_all(ply *p) {
    fathom_status status = write_stream_open(p->scene->context, p->path, &p->stream);
    if (status != FATHOM_OK) return status;
    put_header(p);
    status = write_each_placement(p->scene, p->graph, put_vertices, p);
    if (status == FATHOM_OK) status = write_each_placement(p->scene, p->graph, put_faces, p);
    return write_stream_close(&p->stream, status);
}

fathom_status write_ply(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes) {
    (void)notes;
    ply p = {.scene = scene, .graph = graph, .path = path};
    p.meshes = calloc(scene->meshes.count, sizeof *p.meshes);
    if (!p.meshes) return fail_memory(scene->context, scene->meshes.count * sizeof *p.meshes);
    fathom_status status = count_all(&p);
    if (status == FATHOM_OK) status = put_all(&p);
    for (size_t i = 0; i < scene->meshes.count; ++i) write_mesh_free(&p.meshes[i]);
    free(p.meshes);
    return status;
}
