/* Facts about a mesh, found by reading its arrays once, when it comes into a scene. */
#ifndef SCENE_MESH_FACTS_H
#define SCENE_MESH_FACTS_H

#include "base/status.h"

#include <fathom/scene.h>

typedef struct mesh_facts {
    float lower[3], upper[3]; /* of all vertices, counted from the mesh's origin */
    float largest;            /* coordinate of its triangles within WORLD_REACH, as a magnitude */
    uint32_t flat;            /* triangles without area: stored, never hit */
    uint32_t beyond;          /* triangles with a coordinate that is not below WORLD_REACH */
    uint64_t boundary;        /* the sum of boundary_sum() by the indices of vertices */
} mesh_facts;

/* Each of these reads an array in parallel and returns FATHOM_BAD_INPUT, with "what[17]", for the first bad
 * item. Strides are in bytes and must be a multiple of 4 that holds an item. */

/* A NaN or an infinity; items have `components` floats. */
fathom_status mesh_check_finite(fathom_context *context, const char *what, const float *values, size_t stride,
                                size_t components, uint32_t count);
/* The same for three-vectors; sets the extremes. */
fathom_status mesh_look_at_vertices(fathom_context *context, const char *what, const float *values,
                                    size_t stride, uint32_t count, mesh_facts *facts);

/* An index, three to a triangle, that is not below `limit`. */
fathom_status mesh_check_indices(fathom_context *context, const char *what, const uint32_t *indices,
                                 size_t count, uint32_t limit);
/* An index that names no vertex. Sets all facts but the extremes; positions may be anything. The mesh's
 * strides are set. */
fathom_status mesh_look_at_triangles(fathom_context *context, const char *what, const fathom_mesh *mesh,
                                     mesh_facts *facts);

/* Row i of numbers that lie `stride` bytes apart, as a mesh's attributes do. */
static inline const float *mesh_row(const float *first, size_t stride, size_t i) {
    return (const float *)(const void *)((const char *)first + stride * i);
}

/* The position of a vertex; the mesh's strides are set, as they are in scenes and worlds. */
static inline const float *mesh_vertex(const fathom_mesh *mesh, size_t i) {
    return mesh_row(mesh->positions, mesh->position_stride, i);
}

#endif
