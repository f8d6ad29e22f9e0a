/* The JSON chunk. */
#include "write/write_glb.h"

static void put_name(write_text *t, const char *name) {
    if (!name) return;
    write_put_key(t, "name");
    write_put_json(t, name);
}

/* ---- arrays ---- */

/* glTF requires the bounds of each array of positions. */
static void put_box(write_text *t, const write_mesh *m) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t i = 0; i < m->vertex_count; ++i) {
        vec3_f64 p = widen(write_mesh_position(m, i));
        low[0] = p.x < low[0] ? p.x : low[0], high[0] = p.x > high[0] ? p.x : high[0];
        low[1] = p.y < low[1] ? p.y : low[1], high[1] = p.y > high[1] ? p.y : high[1];
        low[2] = p.z < low[2] ? p.z : low[2], high[2] = p.z > high[2] ? p.z : high[2];
    }
    write_put_text(t, ",\"min\":");
    write_put_numbers(t, low, 3);
    write_put_text(t, ",\"max\":");
    write_put_numbers(t, high, 3);
}

static void put_accessors(glb *g) {
    static const char *const types[] = {"VEC3", "VEC3", "VEC2", "SCALAR"};
    write_text *t = &g->json;
    uint32_t view = 0;
    write_put_text(t, ",\n\"accessors\":[");
    for (size_t i = 0; i < g->placed_count; ++i) {
        const glb_mesh *m = &g->meshes[g->placed[i]];
        size_t sizes[4];
        glb_sizes(m, sizes);
        for (int kind = 0; kind < 4; ++kind) {
            if (!sizes[kind]) continue;
            size_t count = kind == 3 ? sizes[3] / sizeof(uint32_t) : m->vertices.vertex_count;
            write_put(t, "%s\n{\"bufferView\":%u,\"componentType\":%d,\"count\":%zu,\"type\":\"%s\"",
                      view ? "," : "", view, kind == 3 ? 5125 : 5126, count, types[kind]);
            if (kind == 0) put_box(t, &m->vertices);
            write_put_text(t, "}");
            ++view;
        }
    }
    write_put_text(t, "]");
}

static void put_views(glb *g) {
    write_text *t = &g->json;
    const char *comma = "";
    write_put(t, ",\n\"buffers\":[{\"byteLength\":%zu}],\n\"bufferViews\":[", g->binary_size);
    for (size_t i = 0; i < g->placed_count; ++i) {
        const glb_mesh *m = &g->meshes[g->placed[i]];
        size_t sizes[4], offset = m->offset;
        glb_sizes(m, sizes);
        for (int kind = 0; kind < 4; offset += glb_align(sizes[kind]), ++kind) {
            if (!sizes[kind]) continue;
            write_put(t, "%s\n{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,\"target\":%d}", comma,
                      offset, sizes[kind], kind == 3 ? 34963 : 34962);
            comma = ",";
        }
    }
    write_put_text(t, "]");
}

/* ---- meshes ---- */

static void put_primitive(glb *g, uint32_t index, fathom_id override) {
    write_text *t = &g->json;
    const glb_mesh *m = &g->meshes[index];
    const fathom_mesh *mesh = m->vertices.mesh;
    uint32_t accessor = m->accessor;
    write_put(t, "{\"attributes\":{\"POSITION\":%u", accessor);
    if (mesh->normals) write_put(t, ",\"NORMAL\":%u", ++accessor);
    if (mesh->uvs) write_put(t, ",\"TEXCOORD_0\":%u", ++accessor);
    write_put(t, "},\"indices\":%u,\"material\":%u}", ++accessor,
              override != FATHOM_NONE ? override : mesh->material);
}

/* One glTF mesh for the meshes that share the group's origin, then one for each other mesh, in the order of
 * glb_mesh_number(). */
static void put_group_meshes(glb *g, uint32_t group, fathom_id override, const char **comma) {
    write_text *t = &g->json;
    const char *inner = "";
    for (int far = g->groups[group].near ? 0 : 1; far < 2; ++far) {
        if (!far) {
            write_put(t, "%s\n{\"primitives\":[", *comma);
            *comma = ",";
        }
        for (uint32_t i = g->graph->objects.first[group], index; i < g->graph->objects.first[group + 1];
             ++i) {
            const fathom_mesh *mesh = glb_object_mesh(g, i, &index);
            if (!mesh || glb_is_near(mesh) == (far == 1)) continue;
            write_put(t, "%s%s", far ? *comma : inner, far ? "\n{\"primitives\":[" : "");
            put_primitive(g, index, override);
            if (far) write_put_text(t, "]}");
            inner = *comma = ",";
        }
        if (far) continue;
        write_put_text(t, "]");
        put_name(t, g->scene->groups.items[group]);
        write_put_text(t, "}");
    }
}

static void put_meshes(glb *g) {
    const char *comma = "";
    write_put_text(&g->json, ",\n\"meshes\":[");
    for (uint32_t k = 0; k < g->graph->order_count; ++k) {
        const glb_group *group = &g->groups[g->graph->order[k]];
        for (size_t i = 0; i < group->overrides.count; ++i)
            put_group_meshes(g, g->graph->order[k], group->overrides.items[i], &comma);
    }
    write_put_text(&g->json, "]");
}

/* ---- nodes ---- */

/* glTF stores matrices by columns, with the row 0 0 0 1. */
static void put_transform(write_text *t, const double rows[12]) {
    affine_f64 map;
    affine_load(&map, rows);
    if (affine_is_identity(&map)) return;
    double columns[16];
    for (int c = 0; c < 4; ++c) {
        for (int r = 0; r < 4; ++r) columns[4 * c + r] = r < 3 ? map.m[r][c] : c == 3;
    }
    write_put_key(t, "matrix");
    write_put_numbers(t, columns, 16);
}

/* Children are numbered after their parent, each followed by everything inside it. */
static void put_children(glb *g, uint32_t group, size_t number) {
    write_text *t = &g->json;
    size_t child = number + 1;
    const char *comma = "[";
    if (g->groups[group].nodes == 1) return;
    write_put_key(t, "children");
    for (uint32_t i = 0; i < g->groups[group].far_count; ++i, comma = ",")
        write_put(t, "%s%zu", comma, child++);
    for (uint32_t i = g->graph->instances.first[group]; i < g->graph->instances.first[group + 1];
         ++i, comma = ",") {
        write_put(t, "%s%zu", comma, child);
        child += g->groups[g->scene->instances.items[g->graph->instances.items[i]].group].nodes;
    }
    write_put_text(t, "]");
}

static void put_far_nodes(glb *g, uint32_t group, uint32_t mesh) {
    for (uint32_t i = g->graph->objects.first[group], index; i < g->graph->objects.first[group + 1]; ++i) {
        const fathom_mesh *far = glb_object_mesh(g, i, &index);
        if (!far || glb_is_near(far)) continue;
        write_put(&g->json, ",\n{\"mesh\":%u,\"translation\":", mesh++);
        write_put_numbers(&g->json, far->origin, 3);
        write_put_text(&g->json, "}");
    }
}

static void put_nodes(glb *g, uint32_t group, const fathom_instance *instance, fathom_id override,
                      size_t *number) {
    write_text *t = &g->json;
    uint32_t mesh = glb_mesh_number(g, group, override);
    write_put_text(t, *number ? ",\n{" : "\n{");
    put_name(t, g->scene->groups.items[group]);
    if (instance) put_transform(t, instance->transform);
    if (g->groups[group].near) {
        write_put_key(t, "mesh");
        write_put(t, "%u", mesh++);
    }
    put_children(g, group, *number);
    write_put_text(t, "}");
    put_far_nodes(g, group, mesh);
    *number += 1 + g->groups[group].far_count;
    for (uint32_t i = g->graph->instances.first[group]; i < g->graph->instances.first[group + 1]; ++i) {
        const fathom_instance *child = &g->scene->instances.items[g->graph->instances.items[i]];
        put_nodes(g, child->group, child, override != FATHOM_NONE ? override : child->material, number);
    }
}

void glb_put_json(glb *g) {
    write_text *t = &g->json;
    size_t number = 0;
    write_put(t,
              "{\"asset\":{\"version\":\"2.0\",\"generator\":\"Fathom "
              "%s\"},\n\"scene\":0,\"scenes\":[{\"nodes\":[0]",
              fathom_version());
    if (*g->scene->name) put_name(t, g->scene->name);
    write_put_text(t, "}],\n\"nodes\":[");
    put_nodes(g, FATHOM_ROOT, NULL, FATHOM_NONE, &number);
    write_put_text(t, "]");
    put_meshes(g);
    glb_put_materials(g);
    put_accessors(g);
    put_views(g);
    write_put_text(t, "}");
}
