/* The float arrays of a mesh as one table, for code that copies, checks, counts or writes all of them. */
#pragma once

#include <fathom/scene.h>

typedef enum mesh_kind {
    MESH_POSITIONS,
    MESH_NORMALS,
    MESH_UVS,
    MESH_UVS_1,
    MESH_COLORS,
    MESH_TANGENTS,
    MESH_ARRAYS
} mesh_kind;

typedef struct mesh_array {
    const char *name, *index_name; /* of the members of fathom_mesh */
    const float *values;           /* NULL: none */
    size_t stride;
    unsigned width; /* floats per entry */
    uint32_t count;
    const uint32_t *indices; /* its indices, 3 per triangle; NULL: one entry per vertex */
    bool mapped; /* shading reads it only if materials use texture coordinates (scene->uses_uvs) */
} mesh_array;

mesh_array mesh_array_of(const fathom_mesh *mesh, mesh_kind kind);
void mesh_array_set(fathom_mesh *mesh, mesh_kind kind, const float *values, size_t stride);
/* Strides of 0 become those of tightly packed entries. */
void mesh_array_pack(fathom_mesh *mesh);
