#include "read/read.h"

#include "scene/mesh/mesh_array.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The rows of an array that indices refer to. */
typedef struct selection {
    const uint32_t *indices;
    size_t corners;
    uint32_t first, reach; /* the smallest index, and the number of rows from it to the largest index */
    uint32_t used;
    uint32_t *numbers;        /* for each row from `first`: UINT32_MAX if unused, else the new number */
    const uint32_t *replaced; /* the new indices, once computed */
} selection;

static bool select_rows(const uint32_t *indices, size_t corners, selection *out) {
    uint32_t least = UINT32_MAX, most = 0;
    for (size_t i = 0; i < corners; ++i) {
        least = indices[i] < least ? indices[i] : least;
        most = indices[i] > most ? indices[i] : most;
    }
    *out = (selection){.indices = indices, .corners = corners, .first = least, .reach = most - least + 1};
    out->numbers = malloc(out->reach * sizeof *out->numbers);
    if (!out->numbers) return false;
    memset(out->numbers, 0xff, out->reach * sizeof *out->numbers);
    for (size_t i = 0; i < corners; ++i) out->numbers[indices[i] - least] = 0;
    for (uint32_t row = 0; row < out->reach; ++row) {
        if (out->numbers[row] != UINT32_MAX) out->numbers[row] = out->used++;
    }
    return true;
}

static fathom_status renumber(fathom_scene *scene, bool in_place, selection *s) {
    void *memory = (void *)(uintptr_t)s->indices;
    fathom_status status = FATHOM_OK;
    if (!in_place) status = scene_allocate_items(scene, s->corners, sizeof(uint32_t), &memory);
    uint32_t *out = memory;
    for (size_t i = 0; status == FATHOM_OK && i < s->corners; ++i)
        out[i] = s->numbers[s->indices[i] - s->first];
    s->replaced = out;
    return status;
}

static fathom_status copy_rows(fathom_scene *scene, const selection *s, fathom_mesh *mesh, mesh_kind kind) {
    const mesh_array a = mesh_array_of(mesh, kind);
    const size_t bytes = a.width * sizeof(float);
    void *memory;
    const fathom_status status = scene_allocate_items(scene, s->used, bytes, &memory);
    char *out = memory;
    for (uint32_t row = 0; status == FATHOM_OK && row < s->reach; ++row) {
        if (s->numbers[row] == UINT32_MAX) continue;
        memcpy(out, (const char *)a.values + a.stride * ((size_t)s->first + row), bytes);
        out += bytes;
    }
    if (status == FATHOM_OK) mesh_array_set(mesh, kind, memory, bytes);
    return status;
}

/* Normals or uvs with indices of their own. */
static fathom_status compact_own(fathom_scene *scene, bool in_place, fathom_mesh *mesh, mesh_kind kind) {
    const size_t corners = 3 * (size_t)mesh->triangle_count;
    selection s;
    if (!select_rows(mesh_array_of(mesh, kind).indices, corners, &s))
        return fail_memory(scene->context, s.reach * sizeof *s.numbers);
    fathom_status status = renumber(scene, in_place, &s);
    if (status == FATHOM_OK) status = copy_rows(scene, &s, mesh, kind);
    if (kind == MESH_NORMALS) mesh->normal_indices = s.replaced, mesh->normal_count = s.used;
    if (kind == MESH_UVS) mesh->uv_indices = s.replaced, mesh->uv_count = s.used;
    free(s.numbers);
    return status;
}

static fathom_status compact_all(fathom_scene *scene, bool in_place, selection *vertices, fathom_mesh *mesh) {
    if (mesh->normal_indices == mesh->indices) mesh->normal_indices = NULL;
    if (mesh->uv_indices == mesh->indices) mesh->uv_indices = NULL;
    fathom_status status = renumber(scene, in_place, vertices);
    for (int kind = 0; kind < MESH_ARRAYS && status == FATHOM_OK; ++kind) {
        const mesh_array a = mesh_array_of(mesh, (mesh_kind)kind);
        if (!a.values) continue;
        status = a.indices && kind != MESH_POSITIONS ? compact_own(scene, in_place, mesh, (mesh_kind)kind)
                                                     : copy_rows(scene, vertices, mesh, (mesh_kind)kind);
    }
    if (mesh->normals && !mesh->normal_indices) mesh->normal_count = vertices->used;
    if (mesh->uvs && !mesh->uv_indices) mesh->uv_count = vertices->used;
    mesh->indices = vertices->replaced, mesh->vertex_count = vertices->used;
    return status;
}

/* A closed mesh has six corners per vertex. With more than twice that, the indices that have to be copied
 * would take much more memory than the vertices, so that a small file could ask for a lot. */
static bool can_change(const fathom_mesh *mesh) {
    return mesh->triangle_count && !mesh->key_count && !(mesh->point_radius > 0) &&
           3 * (uint64_t)mesh->triangle_count <= 12 * (uint64_t)mesh->vertex_count;
}

/* True if the mesh uses at most half of its vertices, or an unused vertex lies outside the bounds of the used
 * ones. Cameras that are placed by the bounds would show the mesh too small. */
static bool is_wasteful(const fathom_mesh *mesh, const mesh_facts *facts, const selection *s) {
    float low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    bool beyond = false;
    for (uint32_t row = 0; row < s->reach; ++row) {
        const float *p = mesh_vertex(mesh, (size_t)s->first + row);
        for (int k = 0; k < 3 && s->numbers[row] != UINT32_MAX; ++k) {
            low[k] = p[k] < low[k] ? p[k] : low[k];
            high[k] = p[k] > high[k] ? p[k] : high[k];
        }
    }
    for (int k = 0; k < 3; ++k) beyond |= low[k] > facts->lower[k] || high[k] < facts->upper[k];
    return beyond || s->used <= mesh->vertex_count / 2;
}

fathom_status mesh_compact(fathom_scene *scene, bool in_place, const mesh_facts *facts, fathom_mesh *mesh,
                           bool *copied) {
    selection vertices;
    *copied = false;
    mesh_array_pack(mesh);
    if (!can_change(mesh)) return FATHOM_OK;
    if (!select_rows(mesh->indices, 3 * (size_t)mesh->triangle_count, &vertices))
        return fail_memory(scene->context, vertices.reach * sizeof *vertices.numbers);
    *copied = is_wasteful(mesh, facts, &vertices);
    const fathom_status status = *copied ? compact_all(scene, in_place, &vertices, mesh) : FATHOM_OK;
    free(vertices.numbers);
    return status;
}
