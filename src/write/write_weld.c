/* One index for each vertex: corners with the same position, normal and uv become one vertex. */
#include "write/write.h"

#include <stdlib.h>
#include <string.h>

typedef struct welder {
    const fathom_mesh *mesh;
    uint32_t *newest;      /* by position: the last vertex made for it, FATHOM_NONE: none */
    ARRAY(uint32_t) older; /* by vertex: the one made before it for the same position */
    ARRAY(uint32_t) positions;
    ARRAY(uint32_t) normals;
    ARRAY(uint32_t) uvs;
    uint32_t *indices;
} welder;

static bool push_vertex(welder *w, uint32_t p, uint32_t n, uint32_t t) {
    return w->positions.count < UINT32_MAX - 1 && array_push(&w->older, w->newest[p]) &&
           array_push(&w->positions, p) && array_push(&w->normals, n) && array_push(&w->uvs, t);
}

/* A chain is as long as a position has different normals and uvs: a few. */
static bool weld_corner(welder *w, size_t corner) {
    const fathom_mesh *m = w->mesh;
    uint32_t p = m->indices[corner], n = m->normal_indices ? m->normal_indices[corner] : p;
    uint32_t t = m->uv_indices ? m->uv_indices[corner] : p, v = w->newest[p];
    while (v != FATHOM_NONE && (w->normals.items[v] != n || w->uvs.items[v] != t)) v = w->older.items[v];
    if (v == FATHOM_NONE) {
        if (!push_vertex(w, p, n, t)) return false;
        v = w->newest[p] = (uint32_t)(w->positions.count - 1);
    }
    w->indices[corner] = v;
    return true;
}

static fathom_status weld(fathom_context *context, const fathom_mesh *mesh, write_mesh *out) {
    size_t corners = (size_t)mesh->triangle_count * 3, head = mesh->vertex_count * sizeof(uint32_t);
    welder w = {.mesh = mesh, .newest = malloc(head), .indices = malloc(corners * sizeof *w.indices)};
    bool good = w.newest && w.indices;
    if (good) memset(w.newest, 0xff, head);
    for (size_t c = 0; c < corners && good; ++c) good = weld_corner(&w, c);
    free(w.newest);
    array_free(&w.older);
    *out = (write_mesh){.mesh = mesh,
                        .vertex_count = (uint32_t)w.positions.count,
                        .positions = w.positions.items,
                        .normals = w.normals.items,
                        .uvs = w.uvs.items,
                        .indices = w.indices};
    if (good) return FATHOM_OK;
    write_mesh_free(out);
    return fail_memory(context, corners * sizeof(uint32_t));
}

fathom_status write_mesh_prepare(fathom_context *context, const fathom_mesh *mesh, bool facets,
                                 write_mesh *out) {
    if (facets) {
        if (mesh->triangle_count > UINT32_MAX / 3) {
            return fail(context, FATHOM_OUT_OF_RESOURCES,
                        "a mesh of %u triangles without normals has too many corners for 32-bit indices",
                        mesh->triangle_count);
        }
        *out = (write_mesh){.mesh = mesh, .vertex_count = 3 * mesh->triangle_count, .facets = true};
        return FATHOM_OK;
    }
    if (mesh->normal_indices || mesh->uv_indices) return weld(context, mesh, out);
    *out = (write_mesh){.mesh = mesh, .vertex_count = mesh->vertex_count};
    return FATHOM_OK;
}

void write_mesh_free(write_mesh *m) {
    free(m->positions);
    free(m->normals);
    free(m->uvs);
    free(m->indices);
    *m = (write_mesh){.mesh = NULL};
}

static uint32_t position_index(const write_mesh *m, uint32_t vertex) {
    if (m->facets) return m->mesh->indices[vertex];
    return m->positions ? m->positions[vertex] : vertex;
}

vec3_f32 write_mesh_position(const write_mesh *m, uint32_t vertex) {
    return write_item(m->mesh->positions, m->mesh->position_stride, position_index(m, vertex));
}

static vec3_f32 facet_normal(const fathom_mesh *mesh, uint32_t triangle) {
    const uint32_t *t = mesh->indices + (size_t)triangle * 3;
    vec3_f64 p[3];
    for (int k = 0; k < 3; ++k) p[k] = widen(write_item(mesh->positions, mesh->position_stride, t[k]));
    return narrow(normalize_f64(cross_f64(sub_f64(p[1], p[0]), sub_f64(p[2], p[0]))));
}

vec3_f32 write_mesh_normal(const write_mesh *m, uint32_t vertex) {
    if (m->facets) return facet_normal(m->mesh, vertex / 3);
    return write_item(m->mesh->normals, m->mesh->normal_stride, m->normals ? m->normals[vertex] : vertex);
}

void write_mesh_uv(const write_mesh *m, uint32_t vertex, float uv[2]) {
    uv[0] = uv[1] = 0;
    if (!m->mesh->uvs) return;
    uint32_t i = m->uvs ? m->uvs[vertex] : vertex;
    if (m->facets) i = m->mesh->uv_indices ? m->mesh->uv_indices[vertex] : m->mesh->indices[vertex];
    memcpy(uv, (const char *)m->mesh->uvs + m->mesh->uv_stride * i, 2 * sizeof *uv);
}

uint32_t write_mesh_index(const write_mesh *m, size_t corner) {
    if (m->facets) return (uint32_t)corner;
    return m->indices ? m->indices[corner] : m->mesh->indices[corner];
}
