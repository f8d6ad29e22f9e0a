/* What is found out about a mesh by looking through its arrays, once, when it comes into a scene. */
#ifndef SCENE_MESH_FACTS_H
#define SCENE_MESH_FACTS_H

#include "base/status.h"

#include <fathom/scene.h>

typedef struct mesh_facts {
    float lower[3], upper[3]; /* of all vertices, counted from the mesh's origin */
    float largest;            /* coordinate of its triangles within WORLD_REACH, as a magnitude */
    uint32_t flat;            /* triangles without area: stored, never hit */
    uint32_t beyond;          /* triangles with a coordinate that is not below WORLD_REACH */
    uint64_t boundary;        /* the sum of boundary.h by the indices of vertices */
} mesh_facts;

/* FATHOM_BAD_INPUT, with "what[17]", for the first vector that holds a NaN or an infinity, and for a stride
 * that is no multiple of 4 of at least 12. Sets the extremes. */
fathom_status mesh_look_at_vertices(fathom_context *context, const char *what, const float *values,
                                    size_t stride, uint32_t count, mesh_facts *facts);

/* FATHOM_BAD_INPUT, with "what[17]", for the first index, three to a triangle, that names no vertex. Sets all
 * but the extremes; positions may be anything. The mesh's strides are set. */
fathom_status mesh_look_at_triangles(fathom_context *context, const char *what, const fathom_mesh *mesh,
                                     mesh_facts *facts);

#endif
