#include "scene/mesh/mesh_array.h"

#define MEMBER(name) offsetof(fathom_mesh, name)
static const struct {
    const char *name, *index_name;
    size_t values, stride;
    unsigned width;
    bool mapped;
} members[MESH_ARRAYS] = {
    [MESH_POSITIONS] = {"positions", "indices", MEMBER(positions), MEMBER(position_stride), 3, false},
    [MESH_NORMALS] = {"normals", "normal_indices", MEMBER(normals), MEMBER(normal_stride), 3, false},
    [MESH_UVS] = {"uvs", "uv_indices", MEMBER(uvs), MEMBER(uv_stride), 2, true},
    [MESH_UVS_1] = {"uvs_1", NULL, MEMBER(uvs_1), MEMBER(uv_1_stride), 2, true},
    [MESH_COLORS] = {"colors", NULL, MEMBER(colors), MEMBER(color_stride), 3, false},
    [MESH_TANGENTS] = {"tangents", NULL, MEMBER(tangents), MEMBER(tangent_stride), 4, true},
};

static void *at(const fathom_mesh *mesh, size_t offset) { return (char *)(uintptr_t)mesh + offset; }

mesh_array mesh_array_of(const fathom_mesh *mesh, mesh_kind kind) {
    mesh_array out = {.name = members[kind].name,
                      .index_name = members[kind].index_name,
                      .values = *(const float *const *)at(mesh, members[kind].values),
                      .stride = *(const size_t *)at(mesh, members[kind].stride),
                      .width = members[kind].width,
                      .count = mesh->vertex_count,
                      .mapped = members[kind].mapped};
    if (kind == MESH_POSITIONS) out.indices = mesh->indices;
    if (kind == MESH_NORMALS) out.indices = mesh->normal_indices, out.count = mesh->normal_count;
    if (kind == MESH_UVS) out.indices = mesh->uv_indices, out.count = mesh->uv_count;
    if (kind == MESH_COLORS) out.width = mesh->color_channels;
    return out;
}

void mesh_array_set(fathom_mesh *mesh, mesh_kind kind, const float *values, size_t stride) {
    *(const float **)at(mesh, members[kind].values) = values;
    *(size_t *)at(mesh, members[kind].stride) = stride;
}

void mesh_array_pack(fathom_mesh *mesh) {
    for (int k = 0; k < MESH_ARRAYS; ++k) {
        size_t *stride = at(mesh, members[k].stride);
        if (!*stride) *stride = mesh_array_of(mesh, (mesh_kind)k).width * sizeof(float);
    }
}
