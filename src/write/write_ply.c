/* PLY: little-endian binary, instances placed. Normals and uvs are written when any mesh has them; a vertex
 * has one normal, so that flat meshes among smooth ones get a vertex for each corner, with the facet's
 * normal. */
#include "write/write.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct ply {
    const fathom_scene *scene;
    const scene_graph *graph;
    const char *path;
    write_stream stream;
    write_mesh *meshes; /* beside the scene's */
    bool normals, uvs;
    size_t vertices, triangles; /* in all */
    size_t first_vertex;        /* of the placement being written */
} ply;

/* ---- counting ---- */

static const fathom_mesh *mesh_of(const ply *p, uint32_t item, uint32_t *index) {
    scene_object object = p->scene->objects.items[p->graph->objects.items[item]];
    *index = object.index;
    return object.kind == SCENE_MESH ? &p->scene->meshes.items[object.index] : NULL;
}

/* Calls for each mesh of each group that is placed. */
typedef fathom_status (*ply_mesh_fn)(ply *p, uint32_t index, const fathom_mesh *mesh, size_t ways);

static fathom_status each_mesh(ply *p, const size_t *ways, ply_mesh_fn fn) {
    fathom_status status = FATHOM_OK;
    for (uint32_t k = 0; k < p->graph->order_count; ++k) {
        uint32_t g = p->graph->order[k], index;
        for (uint32_t i = p->graph->objects.first[g]; i < p->graph->objects.first[g + 1]; ++i) {
            const fathom_mesh *mesh = mesh_of(p, i, &index);
            if (mesh && status == FATHOM_OK) status = fn(p, index, mesh, ways[g]);
        }
    }
    return status;
}

static fathom_status note_arrays(ply *p, uint32_t index, const fathom_mesh *mesh, size_t ways) {
    (void)index;
    (void)ways;
    p->normals |= mesh->normals != NULL;
    p->uvs |= mesh->uvs != NULL;
    return FATHOM_OK;
}

static fathom_status prepare_mesh(ply *p, uint32_t index, const fathom_mesh *mesh, size_t ways) {
    write_mesh *m = &p->meshes[index];
    fathom_status status = write_mesh_prepare(p->scene->context, mesh, p->normals && !mesh->normals, m);
    p->vertices = write_add(p->vertices, write_multiply(ways, m->vertex_count));
    p->triangles = write_add(p->triangles, write_multiply(ways, mesh->triangle_count));
    return status;
}

static fathom_status count_all(ply *p) {
    size_t *ways;
    fathom_status status = write_count_ways(p->scene, p->graph, &ways);
    if (status == FATHOM_OK) status = each_mesh(p, ways, note_arrays);
    if (status == FATHOM_OK) status = each_mesh(p, ways, prepare_mesh);
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

/* Returns the length. `blanks` behind the comment. */
static int format_header(const ply *p, int blanks, char text[512]) {
    return snprintf(text, 512,
                    "ply\nformat binary_little_endian 1.0\ncomment Fathom %s%*s\nelement vertex %zu\n"
                    "property float x\nproperty float y\nproperty float z\n%s%selement face %zu\n"
                    "property list uchar uint vertex_indices\nend_header\n",
                    fathom_version(), blanks, "", p->vertices,
                    p->normals ? "property float nx\nproperty float ny\nproperty float nz\n" : "",
                    p->uvs ? "property float s\nproperty float t\n" : "", p->triangles);
}

/* Padded to a multiple of 4 bytes: the vertices behind it can then be used straight from the mapped file. */
static void put_header(ply *p) {
    char text[512];
    int length = format_header(p, 0, text);
    length = format_header(p, (4 - length % 4) % 4, text);
    write_bytes(&p->stream, text, (size_t)length);
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

fathom_status write_ply(const fathom_scene *scene, const scene_graph *graph, const char *path) {
    ply p = {.scene = scene, .graph = graph, .path = path};
    p.meshes = calloc(scene->meshes.count, sizeof *p.meshes);
    if (!p.meshes) return fail_memory(scene->context, scene->meshes.count * sizeof *p.meshes);
    fathom_status status = count_all(&p);
    if (status == FATHOM_OK) status = put_all(&p);
    for (size_t i = 0; i < scene->meshes.count; ++i) write_mesh_free(&p.meshes[i]);
    free(p.meshes);
    return status;
}
