/* Binary glTF: a JSON chunk, then a binary chunk with the arrays as in memory, and the image files. Each of
 * them is aligned to 16 bytes in the file, so that a reader can use it in the mapped file. */
#include "write/write_glb.h"

#include <stdlib.h>
#include <string.h>

/* Headers of the file and of its two chunks. */
enum { GLB_ALIGNMENT = 16, GLB_HEADERS = 12 + 2 * 8 };

static size_t glb_align(size_t size) { return (size + GLB_ALIGNMENT - 1) / GLB_ALIGNMENT * GLB_ALIGNMENT; }

/* Numbers per entry. */
static unsigned glb_width(const fathom_mesh *mesh, int kind) {
    return kind == GLB_INDEX ? 1 : write_mesh_width(mesh, (mesh_kind)kind);
}

void glb_sizes(const glb_mesh *m, size_t sizes[GLB_ARRAYS]) {
    const fathom_mesh *mesh = m->vertices.mesh;
    for (int kind = 0; kind < GLB_ARRAYS; ++kind) {
        const size_t count = kind == GLB_INDEX ? (size_t)mesh->triangle_count * 3 : m->vertices.vertex_count;
        sizes[kind] = glb_width(mesh, kind) * sizeof(float) * count;
    }
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
    m->vertices.flips = write_flips_back(g->scene, index);
    size_t sizes[GLB_ARRAYS];
    glb_sizes(m, sizes);
    m->accessor = *accessors, m->offset = g->binary_size;
    for (int k = 0; k < GLB_ARRAYS; ++k) {
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
    g->views = accessors;
    return status;
}

static fathom_status lay_out_images(glb *g) {
    fathom_status status = write_images_open(g->scene, false, &g->images);
    if (status != FATHOM_OK) return status;
    g->image_offsets = malloc((g->images.count + 1) * sizeof *g->image_offsets);
    if (!g->image_offsets) return fail_memory(g->scene->context, g->images.count * sizeof *g->image_offsets);
    for (uint32_t i = 0; i < g->images.count; ++i) {
        g->image_offsets[i] = g->binary_size;
        g->binary_size += glb_align(g->images.items[i].size);
    }
    return FATHOM_OK;
}

/* ---- binary chunk ---- */

typedef struct glb_array {
    const write_mesh *mesh;
    int kind;
} glb_array;

static size_t format_array(const void *user, size_t begin, size_t end, char *out) {
    const glb_array *a = user;
    const size_t size = glb_width(a->mesh->mesh, a->kind) * sizeof(float);
    for (size_t i = begin; i < end; ++i, out += size) {
        const uint32_t corner = a->kind == GLB_INDEX ? write_mesh_index(a->mesh, i) : 0;
        float v[4];
        if (a->kind != GLB_INDEX) write_mesh_entry(a->mesh, (mesh_kind)a->kind, (uint32_t)i, v);
        if (a->kind == MESH_NORMALS || a->kind == MESH_TANGENTS) store_f32(v, write_unit(load_f32(v)));
        memcpy(out, a->kind == GLB_INDEX ? (const void *)&corner : v, size);
    }
    return (end - begin) * size;
}

/* The array itself if it already has glTF's layout, else NULL. */
static const void *array_in_place(const write_mesh *m, int kind) {
    if (kind == GLB_INDEX) return m->indices ? m->indices : m->mesh->indices;
    const mesh_array a = mesh_array_of(m->mesh, (mesh_kind)kind);
    const bool flipped = m->flips && (kind == MESH_UVS || kind == MESH_UVS_1),
               packed = !m->positions && !flipped && a.stride == a.width * sizeof(float);
    return packed && !write_has_lengths(m->mesh, (mesh_kind)kind) ? a.values : NULL;
}

static void put_aligned(write_stream *s, const void *bytes, size_t size) {
    const char zeros[GLB_ALIGNMENT] = {0};
    if (bytes) file_writer_put(s->file, bytes, size);
    file_writer_put(s->file, zeros, glb_align(size) - size);
}

static void put_array(write_stream *s, const write_mesh *m, int kind, size_t size) {
    const void *ready = array_in_place(m, kind);
    const glb_array array = {m, kind};
    const size_t item = glb_width(m->mesh, kind) * sizeof(float);
    if (!ready) write_items(s, size / item, item, format_array, &array);
    put_aligned(s, ready, size);
}

static void put_binary(const glb *g, write_stream *s) {
    for (size_t i = 0; i < g->placed_count; ++i) {
        const glb_mesh *m = &g->meshes[g->placed[i]];
        size_t sizes[GLB_ARRAYS];
        glb_sizes(m, sizes);
        for (int kind = 0; kind < GLB_ARRAYS; ++kind) {
            if (sizes[kind]) put_array(s, &m->vertices, kind, sizes[kind]);
        }
    }
    for (uint32_t i = 0; i < g->images.count; ++i)
        put_aligned(s, g->images.items[i].bytes, g->images.items[i].size);
}

/* ---- the JSON chunk ---- */

/* glTF requires the bounds of each array of positions. */
static void put_box(file_writer *t, const write_mesh *m) {
    scene_bounds box = bounds_empty();
    for (uint32_t i = 0; i < m->vertex_count; ++i) bounds_add(&box, widen(write_mesh_position(m, i)));
    file_writer_print(t, ",\"min\":[%.17g,%.17g,%.17g],\"max\":[%.17g,%.17g,%.17g]", box.lower.x, box.lower.y,
                      box.lower.z, box.upper.x, box.upper.y, box.upper.z);
}

/* The accessors, or the buffer views, one for each array of the meshes. */
static void put_arrays(const glb *g, file_writer *t, bool views) {
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    uint32_t view = 0;
    for (size_t i = 0; i < g->placed_count; ++i) {
        const glb_mesh *m = &g->meshes[g->placed[i]];
        size_t sizes[GLB_ARRAYS], offset = m->offset;
        glb_sizes(m, sizes);
        for (int kind = 0; kind < GLB_ARRAYS; offset += glb_align(sizes[kind]), ++kind) {
            if (!sizes[kind]) continue;
            size_t count = kind == GLB_INDEX ? sizes[GLB_INDEX] / sizeof(uint32_t) : m->vertices.vertex_count;
            file_writer_print(t, "%s\n{", view ? "," : "");
            if (views)
                file_writer_print(t, "\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":%d",
                                  offset, sizes[kind], kind == GLB_INDEX ? 34963 : 34962);
            else
                file_writer_print(t, "\"bufferView\":%u,\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"",
                                  view, kind == GLB_INDEX ? 5125 : 5126, count,
                                  types[glb_width(m->vertices.mesh, kind)]);
            if (kind == MESH_POSITIONS && !views) put_box(t, &m->vertices);
            file_writer_print(t, "}");
            ++view;
        }
    }
    for (uint32_t i = 0; i < g->images.count && views; ++i)
        file_writer_print(t, "%s\n{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", view + i ? "," : "",
                          g->image_offsets[i], g->images.items[i].size);
}

/* Makes the JSON text, padded with spaces to align the arrays. */
static fathom_status make_json(glb *g) {
    file_writer *t;
    fathom_status status = file_writer_open_memory(g->scene->context, g->path, &t);
    if (status != FATHOM_OK) return status;
    file_writer_print(t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Fathom %s\"},\n", fathom_version());
    glb_put_tree(g, t);
    glb_put_materials(g, t);
    glb_put_textures(g, t);
    glb_put_cameras(g, t);
    file_writer_print(t, ",\n\"accessors\":[");
    put_arrays(g, t, false);
    file_writer_print(t, "],\n\"buffers\":[{\"byteLength\":%zu}],\n\"bufferViews\":[", g->binary_size);
    put_arrays(g, t, true);
    file_writer_print(t, "]}%*s", GLB_ALIGNMENT, "");
    status = file_writer_take(t, &g->json, &g->json_size);
    g->json_size -= status == FATHOM_OK ? (GLB_HEADERS + g->json_size) % GLB_ALIGNMENT : 0;
    return status;
}

/* ---- file ---- */

static fathom_status put_file(const glb *g) {
    size_t total = GLB_HEADERS + g->json_size + g->binary_size;
    if (total > UINT32_MAX) {
        return fail_file(g->scene->context, FATHOM_BAD_USAGE, g->path,
                         "the arrays and nodes take %zu bytes, and a .glb holds at most 4294967295; .ply "
                         "holds more triangles",
                         total);
    }
    const uint32_t head[5] = {0x46546c67, 2, (uint32_t)total, (uint32_t)g->json_size, 0x4e4f534a};
    const uint32_t binary[2] = {(uint32_t)g->binary_size, 0x004e4942};
    write_stream stream;
    fathom_status status = write_stream_open(g->scene->context, g->path, &stream);
    if (status != FATHOM_OK) return status;
    file_writer_put(stream.file, head, sizeof head);
    file_writer_put(stream.file, g->json, g->json_size);
    file_writer_put(stream.file, binary, sizeof binary);
    put_binary(g, &stream);
    return write_stream_close(&stream, FATHOM_OK);
}

fathom_status write_glb(const fathom_scene *scene, const scene_graph *graph, const char *path,
                        note_list *notes) {
    glb g = {.scene = scene, .graph = graph, .path = path, .notes = notes};
    g.meshes = calloc(scene->meshes.count, sizeof *g.meshes);
    g.groups = calloc(scene->groups.count, sizeof *g.groups);
    fathom_status status = g.meshes && g.groups
                               ? lay_out(&g)
                               : fail_memory(scene->context, scene->meshes.count * sizeof *g.meshes);
    if (status == FATHOM_OK) status = lay_out_images(&g);
    if (status == FATHOM_OK) status = glb_plan_groups(&g);
    if (status == FATHOM_OK) status = make_json(&g);
    if (status == FATHOM_OK) status = put_file(&g);
    for (size_t i = 0; g.meshes && i < scene->meshes.count; ++i) write_mesh_free(&g.meshes[i].vertices);
    for (size_t i = 0; g.groups && i < scene->groups.count; ++i) array_free(&g.groups[i].overrides);
    write_images_close(&g.images);
    free(g.image_offsets);
    free(g.meshes), free(g.groups), free(g.placed), free(g.json);
    return status;
}
