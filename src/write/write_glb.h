/* Shared by the parts of the writer of binary glTF. */
#pragma once

#include "write/write.h"

#include "write/image.h"

/* The arrays of a mesh in the binary chunk: a mesh_kind, then the indices. */
enum { GLB_INDEX = MESH_ARRAYS, GLB_ARRAYS };

typedef struct glb_mesh {
    write_mesh vertices; /* .mesh is NULL: not placed, so not written */
    uint32_t accessor;   /* accessor of the first array; those of the other arrays follow */
    size_t offset;       /* byte offset of the first array; the others follow, aligned */
} glb_mesh;

/* A glTF mesh contains its materials. So a group that is placed with k different overriding materials becomes
 * k glTF meshes that share their arrays. A mesh with its own origin needs its own node and glTF mesh. */
typedef struct glb_group {
    ARRAY(fathom_id) overrides; /* sorted, unique; FATHOM_NONE: placed without one */
    uint32_t first_mesh;        /* the glTF mesh for the first override */
    uint32_t alone_count;       /* meshes with a node of their own */
    bool together;              /* whether there are other meshes */
    size_t nodes;               /* nodes for one placement, with all nodes below it */
} glb_group;

typedef struct glb {
    const fathom_scene *scene;
    const scene_graph *graph;
    const char *path;
    glb_mesh *meshes;  /* one for each of the scene's meshes */
    glb_group *groups; /* one for each of the scene's groups */
    uint32_t *placed;  /* the meshes that are written, in this order */
    size_t placed_count;
    write_images images;
    size_t *image_offsets;
    uint32_t views; /* number of views of arrays; the views of images follow */
    size_t binary_size;
    unsigned char *json;
    size_t json_size;
    note_list *notes;
} glb;

/* The mesh of item `item` of the graph's objects; NULL: not a mesh. */
const fathom_mesh *glb_object_mesh(const glb *g, uint32_t item, uint32_t *index);
/* Bytes of each array; 0 if the mesh does not have it. */
void glb_sizes(const glb_mesh *m, size_t sizes[GLB_ARRAYS]);

/* ---- groups, meshes, nodes ---- */

void glb_put_name(file_writer *t, const char *separator, const char *name);
/* Overrides and node counts of all groups. */
fathom_status glb_plan_groups(glb *g);
/* The members "scene", "scenes", "nodes" and "meshes". */
void glb_put_tree(const glb *g, file_writer *t);

/* ---- cameras and lights ---- */

/* The number of nodes of the lights and the camera; and these nodes, which follow all other nodes. */
size_t glb_surroundings(const glb *g);
void glb_put_surroundings(const glb *g, file_writer *t);
/* The members "cameras", and "extensions" with the lights. */
void glb_put_cameras(const glb *g, file_writer *t);
bool glb_has_lights(const glb *g);

/* ---- materials ---- */

/* The members "materials" and "extensionsUsed", and "extensionsRequired" if there are such. */
void glb_put_materials(glb *g, file_writer *t);
/* The members "textures", "samplers" and "images". */
void glb_put_textures(const glb *g, file_writer *t);
/* Converts a material of the classic model to metallic-roughness: the inverse of reading, as far as
 * possible. *lost: counts the maps that are not kept. */
fathom_material glb_classic(const fathom_material *m, size_t *lost);
/* True if the result shows the same as the material: Lambert's law, emission included. */
bool glb_is_exact(const fathom_material *m);
