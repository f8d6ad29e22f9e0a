/* Triangles in scene JSON. */
#ifndef READ_JSON_MESH_H
#define READ_JSON_MESH_H

#include "read/json/json_object.h"

/* Successive triangles with the same material, flags and kinds of data: they become one mesh, because a
 * tracer handles one mesh of many triangles far better than many of one. */
typedef struct mesh_batch {
    ARRAY(double) positions, normals, uvs;
    fathom_id group, material;
    unsigned flags;
} mesh_batch;

/* Adds a triangle; first flushes the batch if its triangles differ from this one. */
fathom_status mesh_batch_add(const object_reader *r, json_t *value, const form_object_values *o,
                             fathom_id group, fathom_id material, unsigned flags, mesh_batch *batch);
/* Makes the batch a mesh of the scene, and empties it. */
fathom_status mesh_batch_flush(const object_reader *r, mesh_batch *batch);
void mesh_batch_free(mesh_batch *batch);

/* The mesh of an object with "positions". */
fathom_status mesh_inline(const object_reader *r, const where *at, const form_object_values *o,
                          fathom_id group, fathom_id material, unsigned flags);

#endif
