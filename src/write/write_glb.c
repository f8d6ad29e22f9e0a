/* Binary glTF: a JSON chunk, then a binary chunk with the arrays as they lie in memory. Each array starts at
 * a multiple of 16 bytes of the file, so that a reader can use it in the mapped file. */
#include "write/write.h"

#include <stdlib.h>
#include <string.h>

/* The arrays of a mesh in the binary chunk. */
typedef struct glb_mesh {
    write_mesh vertices; /* .mesh is NULL: not placed, not written */
    uint32_t accessor;   /* of the positions; then those of normals, uvs and indices that exist */
    size_t offset;       /* of the positions; the others follow, each aligned */
} glb_mesh;

/* glTF's meshes carry their materials, so a group placed under k different overriding materials becomes k
 * glTF meshes over the same arrays. A mesh with its own origin needs its own node and glTF mesh. */
typedef struct glb_group {
    ARRAY(fathom_id) overrides; /* sorted, each once; with FATHOM_NONE if it is placed without one */
    uint32_t first_mesh;        /* glTF mesh of the first override */
    uint32_t far_count;         /* meshes with their own origin */
    bool near;                  /* whether there are other meshes */
    size_t nodes;               /* of one placement, with everything inside */
} glb_group;

typedef struct glb {
    const fathom_scene *scene;
    const scene_graph *graph;
    const char *path;
    glb_mesh *meshes;  /* one for each of the scene's meshes */
    glb_group *groups; /* one for each of the scene's groups */
    uint32_t *placed;  /* the meshes that are written, in this order */
    size_t placed_count;
    size_t binary_size;
    unsigned char *json;
    size_t json_size;
} glb;

/* Headers of the file and of its two chunks. */
enum { GLB_ALIGNMENT = 16, GLB_HEADERS = 12 + 2 * 8 };

static size_t glb_align(size_t size) { return (size + GLB_ALIGNMENT - 1) / GLB_ALIGNMENT * GLB_ALIGNMENT; }

/* Sizes in bytes of positions, normals, uvs and indices, 0 where the mesh has none. */
static void glb_sizes(const glb_mesh *m, size_t sizes[4]) {
    const fathom_mesh *mesh = m->vertices.mesh;
    size_t count = m->vertices.vertex_count;
    sizes[0] = 3 * sizeof(float) * count;
    sizes[1] = mesh->normals ? 3 * sizeof(float) * count : 0;
    sizes[2] = mesh->uvs ? 2 * sizeof(float) * count : 0;
    sizes[3] = 3 * sizeof(uint32_t) * mesh->triangle_count;
}

/* The mesh of an item of the graph's objects; NULL: another shape. */
static const fathom_mesh *glb_object_mesh(const glb *g, uint32_t item, uint32_t *index) {
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
        file_writer_put(s->file, ready, size);
    else
        write_items(s, size / item, item, format_array, &array);
    file_writer_put(s->file, zeros, glb_align(size) - size);
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

/* ---- groups ---- */

/* A node takes about a hundred bytes of JSON, and a file has at most 2^32. */
#define MOST_NODES ((size_t)1 << 26)

static bool is_near(const fathom_mesh *mesh) {
    return mesh->origin[0] == 0 && mesh->origin[1] == 0 && mesh->origin[2] == 0;
}

static int compare_ids(const void *a, const void *b) {
    const fathom_id *x = a, *y = b;
    return *x < *y ? -1 : *x > *y;
}

static void sort_overrides(glb_group *group) {
    fathom_id *items = group->overrides.items;
    size_t count = 0;
    if (!group->overrides.count) return;
    qsort(items, group->overrides.count, sizeof *items, compare_ids);
    for (size_t i = 0; i < group->overrides.count; ++i) {
        if (!count || items[count - 1] != items[i]) items[count++] = items[i];
    }
    group->overrides.count = count;
}

/* The outermost override counts. */
static bool pass_overrides(const glb_group *from, const fathom_instance *instance, glb_group *to) {
    for (size_t i = 0; i < from->overrides.count; ++i) {
        fathom_id override = from->overrides.items[i];
        if (!array_push(&to->overrides, override != FATHOM_NONE ? override : instance->material))
            return false;
        if (to->overrides.count >= 64 && to->overrides.count == to->overrides.capacity) sort_overrides(to);
    }
    return true;
}

static uint32_t meshes_for_one(const glb_group *group) { return group->far_count + group->near; }

/* The glTF mesh of a group placed under an override. */
static uint32_t mesh_number(const glb *g, uint32_t index, fathom_id override) {
    const glb_group *group = &g->groups[index];
    const fathom_id *found =
        bsearch(&override, group->overrides.items, group->overrides.count, sizeof override, compare_ids);
    return group->first_mesh + (uint32_t)(found - group->overrides.items) * meshes_for_one(group);
}

static void count_meshes(const glb *g, uint32_t index, uint32_t *next_mesh) {
    glb_group *group = &g->groups[index];
    uint32_t unused;
    for (uint32_t i = g->graph->objects.first[index]; i < g->graph->objects.first[index + 1]; ++i) {
        const fathom_mesh *mesh = glb_object_mesh(g, i, &unused);
        if (!mesh) continue;
        if (is_near(mesh))
            group->near = true;
        else
            ++group->far_count;
    }
    group->first_mesh = *next_mesh;
    *next_mesh += meshes_for_one(group) * (uint32_t)group->overrides.count;
}

static void count_nodes(const glb *g, uint32_t index) {
    glb_group *group = &g->groups[index];
    group->nodes = 1 + group->far_count;
    for (uint32_t i = g->graph->instances.first[index]; i < g->graph->instances.first[index + 1]; ++i) {
        const fathom_instance *instance = &g->scene->instances.items[g->graph->instances.items[i]];
        group->nodes = write_add(group->nodes, g->groups[instance->group].nodes);
    }
}

/* Overrides and node counts of all groups. */
static fathom_status plan_groups(glb *g) {
    bool good = array_push(&g->groups[FATHOM_ROOT].overrides, FATHOM_NONE);
    uint32_t meshes = 0;
    for (uint32_t k = 0; k < g->graph->order_count && good; ++k) {
        uint32_t index = g->graph->order[k];
        sort_overrides(&g->groups[index]);
        count_meshes(g, index, &meshes);
        for (uint32_t i = g->graph->instances.first[index]; i < g->graph->instances.first[index + 1] && good;
             ++i) {
            const fathom_instance *instance = &g->scene->instances.items[g->graph->instances.items[i]];
            good = pass_overrides(&g->groups[index], instance, &g->groups[instance->group]);
        }
    }
    if (!good) return fail_memory(g->scene->context, g->scene->instances.count * sizeof(fathom_id));
    for (uint32_t k = g->graph->order_count; k-- > 0;) count_nodes(g, g->graph->order[k]);
    size_t nodes = g->groups[FATHOM_ROOT].nodes;
    if (nodes <= MOST_NODES) return FATHOM_OK;
    return fail_file(g->scene->context, FATHOM_BAD_USAGE, g->path,
                     "glTF needs a node for each of %zu placed groups, and a .glb has room for about %zu",
                     nodes, MOST_NODES);
}

/* ---- the JSON chunk ---- */

static void put_name(file_writer *t, const char *separator, const char *name) {
    file_writer_print(t, "%s\"name\":", separator);
    write_quoted(t, name);
}

/* glTF requires the bounds of each array of positions. */
static void put_box(file_writer *t, const write_mesh *m) {
    scene_bounds box = bounds_empty();
    for (uint32_t i = 0; i < m->vertex_count; ++i) bounds_add(&box, widen(write_mesh_position(m, i)));
    file_writer_print(t, ",\"min\":[%.17g,%.17g,%.17g],\"max\":[%.17g,%.17g,%.17g]", box.lower.x, box.lower.y,
                      box.lower.z, box.upper.x, box.upper.y, box.upper.z);
}

/* The accessors, or the buffer views, one for each array of the meshes. */
static void put_arrays(const glb *g, file_writer *t, bool views) {
    static const char *const types[] = {"VEC3", "VEC3", "VEC2", "SCALAR"};
    uint32_t view = 0;
    for (size_t i = 0; i < g->placed_count; ++i) {
        const glb_mesh *m = &g->meshes[g->placed[i]];
        size_t sizes[4], offset = m->offset;
        glb_sizes(m, sizes);
        for (int kind = 0; kind < 4; offset += glb_align(sizes[kind]), ++kind) {
            if (!sizes[kind]) continue;
            size_t count = kind == 3 ? sizes[3] / sizeof(uint32_t) : m->vertices.vertex_count;
            file_writer_print(t, "%s\n{", view ? "," : "");
            if (views)
                file_writer_print(t, "\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":%d",
                                  offset, sizes[kind], kind == 3 ? 34963 : 34962);
            else
                file_writer_print(t, "\"bufferView\":%u,\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"",
                                  view, kind == 3 ? 5125 : 5126, count, types[kind]);
            if (kind == 0 && !views) put_box(t, &m->vertices);
            file_writer_print(t, "}");
            ++view;
        }
    }
}

static void put_primitive(const glb *g, file_writer *t, uint32_t index, fathom_id override) {
    const glb_mesh *m = &g->meshes[index];
    const fathom_mesh *mesh = m->vertices.mesh;
    uint32_t accessor = m->accessor;
    file_writer_print(t, "{\"attributes\":{\"POSITION\":%u", accessor);
    if (mesh->normals) file_writer_print(t, ",\"NORMAL\":%u", ++accessor);
    if (mesh->uvs) file_writer_print(t, ",\"TEXCOORD_0\":%u", ++accessor);
    file_writer_print(t, "},\"indices\":%u,\"material\":%u}", ++accessor,
                      override != FATHOM_NONE ? override : mesh->material);
}

/* One glTF mesh for the meshes that share the group's origin, then one for each other mesh, in the order of
 * mesh_number(). */
static void put_group_meshes(const glb *g, file_writer *t, uint32_t group, fathom_id override,
                             const char **comma) {
    for (int far = g->groups[group].near ? 0 : 1; far < 2; ++far) {
        const char *separator = far ? *comma : "";
        if (!far) file_writer_print(t, "%s\n{\"primitives\":[", *comma);
        for (uint32_t i = g->graph->objects.first[group], index; i < g->graph->objects.first[group + 1];
             ++i) {
            const fathom_mesh *mesh = glb_object_mesh(g, i, &index);
            if (!mesh || is_near(mesh) == (far == 1)) continue;
            file_writer_print(t, "%s%s", separator, far ? "\n{\"primitives\":[" : "");
            put_primitive(g, t, index, override);
            if (far) file_writer_print(t, "]}");
            separator = *comma = ",";
        }
        if (far) continue;
        file_writer_print(t, "]");
        if (g->scene->groups.items[group]) put_name(t, ",", g->scene->groups.items[group]);
        file_writer_print(t, "}");
    }
}

static void put_meshes(const glb *g, file_writer *t) {
    const char *comma = "";
    for (uint32_t k = 0; k < g->graph->order_count; ++k) {
        const glb_group *group = &g->groups[g->graph->order[k]];
        for (size_t i = 0; i < group->overrides.count; ++i)
            put_group_meshes(g, t, g->graph->order[k], group->overrides.items[i], &comma);
    }
}

/* glTF stores matrices by columns, with the row 0 0 0 1. */
static void put_transform(file_writer *t, const char **separator, const double rows[12]) {
    affine_f64 map;
    affine_load(&map, rows);
    if (affine_is_identity(&map)) return;
    file_writer_print(t, "%s\"matrix\":", *separator);
    *separator = ",";
    for (int i = 0; i < 16; ++i) {
        double number = i % 4 < 3 ? map.m[i % 4][i / 4] : i / 4 == 3;
        file_writer_print(t, "%s%.17g", i ? "," : "[", number);
    }
    file_writer_print(t, "]");
}

/* Children are numbered after their parent, each followed by everything inside it. */
static void put_children(const glb *g, file_writer *t, const char *separator, uint32_t group, size_t number) {
    size_t child = number + 1;
    const char *comma = "[";
    if (g->groups[group].nodes == 1) return;
    file_writer_print(t, "%s\"children\":", separator);
    for (uint32_t i = 0; i < g->groups[group].far_count; ++i, comma = ",")
        file_writer_print(t, "%s%zu", comma, child++);
    for (uint32_t i = g->graph->instances.first[group]; i < g->graph->instances.first[group + 1];
         ++i, comma = ",") {
        file_writer_print(t, "%s%zu", comma, child);
        child += g->groups[g->scene->instances.items[g->graph->instances.items[i]].group].nodes;
    }
    file_writer_print(t, "]");
}

static void put_far_nodes(const glb *g, file_writer *t, uint32_t group, uint32_t mesh) {
    for (uint32_t i = g->graph->objects.first[group], index; i < g->graph->objects.first[group + 1]; ++i) {
        const fathom_mesh *far = glb_object_mesh(g, i, &index);
        if (!far || is_near(far)) continue;
        file_writer_print(t, ",\n{\"mesh\":%u,\"translation\":[%.17g,%.17g,%.17g]}", mesh++, far->origin[0],
                          far->origin[1], far->origin[2]);
    }
}

/* Each placement of a group gets its own nodes, because nodes form a tree. */
static void put_nodes(const glb *g, file_writer *t, uint32_t group, const fathom_instance *instance,
                      fathom_id override, size_t *number) {
    const char *name = g->scene->groups.items[group], *separator = "";
    uint32_t mesh = mesh_number(g, group, override);
    file_writer_print(t, *number ? ",\n{" : "\n{");
    if (name) put_name(t, separator, name), separator = ",";
    if (instance) put_transform(t, &separator, instance->transform);
    if (g->groups[group].near) {
        file_writer_print(t, "%s\"mesh\":%u", separator, mesh++);
        separator = ",";
    }
    put_children(g, t, separator, group, *number);
    file_writer_print(t, "}");
    put_far_nodes(g, t, group, mesh);
    *number += 1 + g->groups[group].far_count;
    for (uint32_t i = g->graph->instances.first[group]; i < g->graph->instances.first[group + 1]; ++i) {
        const fathom_instance *child = &g->scene->instances.items[g->graph->instances.items[i]];
        put_nodes(g, t, child->group, child, override != FATHOM_NONE ? override : child->material, number);
    }
}

/* Padded with spaces to align the arrays. */
static fathom_status make_json(glb *g) {
    file_writer *t;
    size_t number = 0;
    fathom_status status = file_writer_open_memory(g->scene->context, g->path, &t);
    if (status != FATHOM_OK) return status;
    file_writer_print(t, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Fathom %s\"},\n", fathom_version());
    file_writer_print(t, "\"scene\":0,\"scenes\":[{\"nodes\":[0]");
    if (*g->scene->name) put_name(t, ",", g->scene->name);
    file_writer_print(t, "}],\n\"nodes\":[");
    put_nodes(g, t, FATHOM_ROOT, NULL, FATHOM_NONE, &number);
    file_writer_print(t, "],\n\"meshes\":[");
    put_meshes(g, t);
    file_writer_print(t, "]");
    write_glb_materials(t, g->scene);
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
        return fail_file(
            g->scene->context, FATHOM_BAD_USAGE, g->path,
            "the arrays and nodes take %zu bytes, and a .glb holds at most 4294967295; .ply holds more "
            "triangles",
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

fathom_status write_glb(const fathom_scene *scene, const scene_graph *graph, const char *path) {
    glb g = {.scene = scene, .graph = graph, .path = path};
    g.meshes = calloc(scene->meshes.count, sizeof *g.meshes);
    g.groups = calloc(scene->groups.count, sizeof *g.groups);
    fathom_status status = g.meshes && g.groups
                               ? lay_out(&g)
                               : fail_memory(scene->context, scene->meshes.count * sizeof *g.meshes);
    if (status == FATHOM_OK) status = plan_groups(&g);
    if (status == FATHOM_OK) status = make_json(&g);
    if (status == FATHOM_OK) status = put_file(&g);
    for (size_t i = 0; g.meshes && i < scene->meshes.count; ++i) write_mesh_free(&g.meshes[i].vertices);
    for (size_t i = 0; g.groups && i < scene->groups.count; ++i) array_free(&g.groups[i].overrides);
    free(g.meshes), free(g.groups), free(g.placed), free(g.json);
    return status;
}
