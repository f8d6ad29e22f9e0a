/* Facts about a mesh, found by reading its arrays once, when it is added to a scene. */
#pragma once

#include "base/status.h"

#include <fathom/scene.h>

typedef struct mesh_facts {
    float lower[3], upper[3]; /* of all vertices, relative to the mesh's origin */
    /* The same without stray points, and their number: set when the mesh is in a scene. */
    float core_lower[3], core_upper[3];
    uint32_t strays;
    float largest;     /* the largest magnitude of a coordinate of triangles within WORLD_REACH */
    uint32_t flat;     /* triangles without area: stored, never hit */
    uint32_t beyond;   /* triangles with a coordinate whose magnitude is not below WORLD_REACH */
    uint64_t boundary; /* the sum of boundary_sum(), by vertex indices */
    bool upwards;      /* v grows upwards, as in OBJ and PLY files; their readers set it */
} mesh_facts;

/* Each of these reads an array in parallel. For the first bad item it returns FATHOM_BAD_INPUT, with
 * "what[17]" in the message. Strides are in bytes; they must be a multiple of 4 and at least the size of an
 * item. */

/* An item is bad if it holds a NaN or an infinity. Items have `components` floats. */
fathom_status mesh_check_finite(fathom_context *context, const char *what, const float *values, size_t stride,
                                size_t components, uint32_t count);
/* The same for three-vectors. Also sets lower and upper of the facts, and `upwards` to false. */
fathom_status mesh_look_at_vertices(fathom_context *context, const char *what, const float *values,
                                    size_t stride, uint32_t count, mesh_facts *facts);

/* An index, three per triangle, is bad if it is not below `limit`. */
fathom_status mesh_check_indices(fathom_context *context, const char *what, const uint32_t *indices,
                                 size_t count, uint32_t limit);
/* An index is bad if there is no such vertex. Sets all facts that mesh_look_at_vertices() does not. Positions
 * may be any floats. The mesh's strides must be set. */
fathom_status mesh_look_at_triangles(fathom_context *context, const char *what, const fathom_mesh *mesh,
                                     mesh_facts *facts);

/* Bounds of points without strays: at most about 1 % of the points beyond each end of an axis, farther from
 * the rest than the rest is long. They come from scanners' reflections, and would make everything else a dot
 * in the image. *lower and *upper hold the bounds of all points before. Returns the number of strays. */
uint32_t mesh_find_strays(const float *values, size_t stride, uint32_t count, float lower[3], float upper[3]);

/* Row i of an array whose rows are `stride` bytes apart, as in a mesh's attributes. */
static inline const float *mesh_row(const float *first, size_t stride, size_t i) {
    return (const float *)(const void *)((const char *)first + stride * i);
}

/* The position of a vertex. The mesh's strides must be set, as they are in scenes and worlds. */
static inline const float *mesh_vertex(const fathom_mesh *mesh, size_t i) {
    return mesh_row(mesh->positions, mesh->position_stride, i);
}
