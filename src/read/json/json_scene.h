/* Adds the contents of a scene JSON document to the scene. */
#pragma once

#include "math/affine.h"
#include "math/frame.h"
#include "read/json/json_doc.h"
#include "scene/scene.h"

typedef struct object_reader {
    const doc *doc;
    fathom_scene *scene;
    json_t *materials, *groups; /* the ids by name */
} object_reader;

/* Adds the objects of `list` to `group`, in their order. */
fathom_status object_list(const object_reader *r, const where *at, json_t *list, fathom_id group);

/* Lets meshes that are clear in their file cast shadows where an instance gives them a solid material. Call
 * it once the scene has its objects. */
fathom_status objects_cast(const object_reader *r);

/* Adds the sources [first, end) to the light group `name`; NULL: no light group. `at` and `key`: for
 * messages. */
fathom_status light_group_set(const object_reader *r, const where *at, const char *key,
                              fathom_light_source source, size_t first, size_t end, const char *name);

/* ---- materials (json_material.c) ---- */

fathom_status materials_add(const object_reader *r, json_t *materials);

/* Warns of keys without effect and of unused materials. Call it once the scene has its objects. */
fathom_status materials_warn(const object_reader *r, json_t *materials);

/* ---- frames and transforms (json_place.c) ---- */

/* `value` is the "frame" object that was read into `values`. */
fathom_status place_frame(const doc *d, const where *at, json_t *value, const form_frame_values *values,
                          frame_f64 *out);

double place_radians(double degrees);

/* Stores the place of a part for messages after reading. */
fathom_status place_origin(const object_reader *r, const where *at, scene_part part, fathom_id id);

/* The transform that an object's placement keys describe; *placed is false if it has no such keys. */
fathom_status place_object(const doc *d, const where *at, json_t *object, const form_place_values *values,
                           affine_f64 *out, bool *placed);

/* Reads one key of a motion: its time and its transform. */
typedef fathom_status place_key_reader(const object_reader *r, const where *at, json_t *value, double *time,
                                       affine_f64 *map);
/* Reads the motion `list` of the object or camera at `at`. *keys holds *count times, then *count maps of 12
 * numbers, row by row. The caller frees *keys, even after a failure. */
fathom_status place_motion(const object_reader *r, const where *at, json_t *list, place_key_reader *read,
                           uint32_t *count, double **keys);
/* doc_within() for an object, mesh or camera with keys in its member `list`: an error about item k of
 * key_times, key_transforms… is placed at key k. */
fathom_status place_within(const object_reader *r, const where *at, const char *list, fathom_status status);

/* ---- triangles (json_mesh.c) ---- */

/* Successive triangles with the same material, flags and kinds of data. They become one mesh, because a
 * tracer is much faster with one mesh of many triangles than with many meshes of one triangle. */
typedef struct mesh_batch {
    ARRAY(json_t *) triangles;
    fathom_id group, material;
    unsigned flags;
    const char *light_group, *name; /* owned by the document; NULL: none */
} mesh_batch;

/* Adds a triangle; first flushes the batch if its triangles differ from this one. */
fathom_status mesh_batch_add(const object_reader *r, json_t *value, const form_object_values *o,
                             fathom_id group, fathom_id material, unsigned flags, mesh_batch *batch);
/* Makes the batch a mesh of the scene, and empties it. */
fathom_status mesh_batch_flush(const object_reader *r, mesh_batch *batch);
void mesh_batch_free(mesh_batch *batch);

/* Adds the mesh of an object that has "positions". */
fathom_status mesh_inline(const object_reader *r, const where *at, const form_object_values *o,
                          fathom_id group, fathom_id material, unsigned flags);
