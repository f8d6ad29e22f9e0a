/* Meshes, and how nodes deform them. */
#pragma once

#include "read/gltf/gltf_data.h"
#include "read/gltf/gltf_pose.h"

#define GLTF_EMPTY (FATHOM_NONE - 1) /* a mesh without a triangle */

/* The matrices of a skin's joints, from mesh to world space, minus `origin`. If the node mirrors its meshes,
 * x is negated at the end, which the instance of the mesh undoes: that reverses the winding of triangles. */
struct gltf_joints {
    affine_f64 *matrices; /* NULL: not made yet */
    uint32_t count;
    bool mirrored;
    bool flat;       /* no skin, but the one matrix of a node that flattens: no instance can have it */
    vec3_f64 origin; /* the same at all moments */
};

/* How a node deforms its mesh. */
struct gltf_shape {
    double *weights; /* of morph targets; owned */
    size_t weight_count;
    const gltf_joints *joints; /* NULL: no skin */
};

/* ---- gltf_mesh.c ---- */

/* Makes a group with mesh `index`; GLTF_EMPTY if it has no triangle. moves: there is a shape for each moment,
 * else there is one. */
fathom_id gltf_mesh_group(gltf *g, uint32_t index, const gltf_shape *shapes, bool moves);

/* ---- gltf_shape.c ---- */

/* The group that holds mesh `mesh` as the node deforms it at all moments, or GLTF_EMPTY. Nodes that deform it
 * alike share the group. node NULL: the mesh's own weights. way: the node's transforms. *joints: at the
 * opening of the shutter; NULL: no skin, and nothing flat. */
fathom_id gltf_shape_mesh(gltf *g, const gltf_value *node, uint32_t mesh, const gltf_way *way,
                          const gltf_joints **joints);
/* Call it before gltf_moments_close(). */
void gltf_posed_close(gltf *g);

/* ---- gltf_morph.c, gltf_skin.c ---- */

/* Reads the weights: from the pose, else from the node, else from the mesh. node may be NULL. */
void gltf_weights_read(gltf *g, const gltf_pose *pose, const gltf_value *node, const gltf_value *mesh,
                       gltf_shape *out);
/* Each call replaces the floats of an attribute by deformed ones, if the shape changes them. They are tightly
 * packed in `to`, or in new memory of the scene if `to` is NULL. */
void gltf_morph(gltf *g, const gltf_value *primitive, const gltf_shape *shape, const char *key,
                unsigned components, gltf_elements *floats, float *to);
/* Adds a note for each attribute that is not deformed of the targets that a shape uses at any moment. */
void gltf_morph_note(gltf *g, const gltf_value *primitive, const gltf_shape *shapes, size_t moments);
typedef enum gltf_kind { GLTF_POINT, GLTF_NORMAL, GLTF_TANGENT } gltf_kind;
void gltf_skin_carry(gltf *g, const gltf_value *attributes, const gltf_joints *joints, gltf_kind kind,
                     gltf_elements *floats, float *to);
/* The joints of skin `index` at a moment of g; valid as long as the moment. */
const gltf_joints *gltf_skin_read(gltf *g, gltf_moment *m, uint32_t index, bool mirrored);
/* The one joint that all vertices of a flattened mesh follow; NULL: out of memory. */
const gltf_joints *gltf_skin_flatten(gltf *g, const gltf_value *node, const affine_f64 *to_world,
                                     vec3_f64 origin);
