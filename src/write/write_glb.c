/* Binary glTF: a JSON chunk, then a binary chunk with the arrays as they lie in memory. Each array starts at
 * a multiple of 16 bytes of the file, so that a reader can use it in the mapped file. */
#include "write/write_glb.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

void glb_sizes(const glb_mesh *m, size_t sizes[4]) {
    const fathom_mesh *mesh = m->vertices.mesh;
    size_t count = m->vertices.vertex_count;
    sizes[0] = 3 * sizeof(float) * count;
    sizes[1] = mesh->normals ? 3 * sizeof(float) * count : 0;
    sizes[2] = mesh->uvs ? 2 * sizeof(float) * count : 0;
    sizes[3] = 3 * sizeof(uint32_t) * mesh->triangle_count;
}

const fathom_mesh *glb_object_mesh(const glb *g, uint32_t item, uint32_t *index) {
    scene_object object = g->scene->objects.items[g->graph->objects.items[item]];
    *index = object.index;
    return object.kind == SCENE_MESH ? &g->scene->meshes.items[object.index] : NULL;
}

/* ---- layout ---- */

static fathom_status lay_out_mesh(glb *g, uint32_t index, const fathom_mesh *mesh, uint32_t *accessors) {
    glb_mesh *m = &g->meshes[index];
    fathom_status status = write_mesh_prepare(g->scene->context, mesh, false, &m->vertices);
    if (status != FATHOM_OK) return status;
    size_t sizes[4];
    glb_sizes(m, sizes);
    m->accessor = *accessors, m->offset = g->binary_size;
    for (int k = 0; k < 4; ++k) {
        g->binary_size += glb_align(sizes[k]);
        *accessors += sizes[k] > 0;
    }
    return FATHOM_OK;
}

static fathom_status lay_out(glb *g) {
    fathom_status status = FATHOM_OK;
    uint32_t accessors = 0, index;
    g->placed = malloc((g->scene->meshes.count + 1) * sizeof *g->placed);
    if (!g->placed) return fail_memory(g->scene->context, g->scene->meshes.count * sizeof *g->placed);
    for (uint32_t k = 0; k < g->graph->order_count; ++k) {
        uint32_t group = g->graph->order[k];
        for (uint32_t i = g->graph->objects.first[group]; i < g->graph->objects.first[group + 1]; ++i) {
            const fathom_mesh *mesh = glb_object_mesh(g, i, &index);
            if (!mesh || status != FATHOM_OK) continue;
            g->placed[g->placed_count++] = index;
            status = lay_out_mesh(g, index, mesh, &accessors);
        }
    }
    return status;
}

/* ---- binary chunk ---- */

typedef struct glb_array {
    const write_mesh *mesh;
    int kind; /* 0 positions, 1 normals, 2 uvs, 3 indices */
} glb_array;

static size_t format_array(const void *user, size_t begin, size_t end, char *out) {
    const glb_array *a = user;
    char *start = out;
    for (size_t i = begin; i < end; ++i) {
        float v[3];
        size_t size = a->kind == 2 ? 8 : a->kind == 3 ? 4 : 12;
        uint32_t corner = a->kind == 3 ? write_mesh_index(a->mesh, i) : 0;
        if (a->kind == 0) store_f32(v, write_mesh_position(a->mesh, (uint32_t)i));
        if (a->kind == 1) store_f32(v, write_mesh_normal(a->mesh, (uint32_t)i));
        if (a->kind == 2) write_mesh_uv(a->mesh, (uint32_t)i, v);
        memcpy(out, a->kind == 3 ? (const void *)&corner : v, size);
        out += size;
    }
    return (size_t)(out - start);
}

/* The array itself if it already has glTF's layout, else NULL. */
static const void *array_in_place(const write_mesh *m, int kind) {
    const fathom_mesh *mesh = m->mesh;
    if (kind == 3) return m->indices ? m->indices : mesh->indices;
    if (m->positions) return NULL;
    if (kind == 0) return mesh->position_stride == 12 ? mesh->positions : NULL;
    if (kind == 1) return mesh->normal_stride == 12 ? mesh->normals : NULL;
    return mesh->uv_stride == 8 ? mesh->uvs : NULL;
}

static void put_array(write_stream *s, const write_mesh *m, int kind, size_t size) {
    const char zeros[GLB_ALIGNMENT] = {0};
    const void *ready = array_in_place(m, kind);
    glb_array array = {m, kind};
    size_t item = kind == 2 ? 8 : kind == 3 ? 4 : 12;
    if (ready)
        write_bytes(s, ready, size);
    else
        write_items(s, size / item, item, format_array, &array);
    write_bytes(s, zeros, glb_align(size) - size);
}

static void put_binary(const glb *g, write_stream *s) {
    for (size_t i = 0; i < g->placed_count; ++i) {
        const glb_mesh *m = &g->meshes[g->placed[i]];
        size_t sizes[4];
        glb_sizes(m, sizes);
        for (int kind = 0; kind < 4; ++kind) {
            if (sizes[kind]) put_array(s, &m->vertices, kind, sizes[kind]);
        }
    }
}

/* ---- file ---- */

/* Writes headers and chunks; pads the JSON with spaces to align the arrays. */
static fathom_status put_file(glb *g) {
    const size_t header = 12, chunk = 8;
    while (!g->json.failed && (header + 2 * chunk + g->json.bytes.count) % GLB_ALIGNMENT)
        write_put_text(&g->json, " ");
    if (g->json.failed) return fail_memory(g->scene->context, g->json.bytes.capacity);
    size_t total = header + 2 * chunk + g->json.bytes.count + g->binary_size;
    if (total > UINT32_MAX) {
        return fail_file(
            g->scene->context, FATHOM_BAD_USAGE, g->path,
            "the arrays and nodes take %zu bytes, and a .glb holds at most 4294967295; .ply holds more "
            "triangles",
            total);
    }
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)total, (uint32_t)g->json.bytes.count, 0x4e4f534a};
    const uint32_t binary[2] = {(uint32_t)g->binary_size, 0x004e4942};
    write_stream stream;
    fathom_status status = write_stream_open(g->scene->context, g->path, &stream);
    if (status != FATHOM_OK) return status;
    write_bytes(&stream, head, sizeof head);
    write_bytes(&stream, g->json.bytes.items, g->json.bytes.count);
    write_bytes(&stream, binary, sizeof binary);
    put_binary(g, &stream);
    return write_stream_close(&stream, FATHOM_OK);
}

fathom_status write_glb(const fathom_scene *scene, const scene_graph *graph, const char *path) {
    glb g = {.scene = scene, .graph = graph, .path = path};
    g.meshes = calloc(scene->meshes.count, sizeof *g.meshes);
    g.groups = calloc(scene->groups.count, sizeof *g.groups);
    fathom_status status = g.meshes && g.groups
                               ? lay_out(&g)
                               : fail_memory(scene->context, scene->meshes.count * sizeof *g.meshes);
    if (status == FATHOM_OK) status = glb_plan_groups(&g);
    if (status == FATHOM_OK) {
        glb_put_json(&g);
        status = put_file(&g);
    }
    for (size_t i = 0; g.meshes && i < scene->meshes.count; ++i) write_mesh_free(&g.meshes[i].vertices);
    for (size_t i = 0; g.groups && i < scene->groups.count; ++i) array_free(&g.groups[i].overrides);
    free(g.meshes), free(g.groups), free(g.placed);
    array_free(&g.json.bytes);
    return status;
}
