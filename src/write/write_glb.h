/* Shared by the parts of the writer of binary glTF. */
#ifndef WRITE_GLB_H
#define WRITE_GLB_H

#include "write/write.h"

#include "write/image.h"

/* The arrays of a mesh in the binary chunk: a mesh_kind, then the indices. */
enum { GLB_INDEX = MESH_ARRAYS, GLB_ARRAYS };

typedef struct glb_mesh {
    write_mesh vertices; /* .mesh is NULL: not placed, not written */
    uint32_t accessor;   /* of the first array; those of the others that exist follow */
    size_t offset;       /* likewise, each aligned */
} glb_mesh;

/* glTF's meshes carry their materials, so a group placed under k different overriding materials becomes k
 * glTF meshes over the same arrays. A mesh with its own origin needs its own node and glTF mesh. */
typedef struct glb_group {
    ARRAY(fathom_id) overrides; /* sorted, each once; with FATHOM_NONE if it is placed without one */
    uint32_t first_mesh;        /* glTF mesh of the first override */
    uint32_t far_count;         /* meshes with their own origin */
    bool near;                  /* whether there are other meshes */
    size_t nodes;               /* of one placement, with everything inside */
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
    uint32_t views; /* of arrays; those of images follow */
    size_t binary_size;
    unsigned char *json;
    size_t json_size;
    note_list *notes;
} glb;

/* The mesh of an item of the graph's objects; NULL: another shape. */
const fathom_mesh *glb_object_mesh(const glb *g, uint32_t item, uint32_t *index);
/* Bytes of each array, 0 where the mesh has none. */
void glb_sizes(const glb_mesh *m, size_t sizes[GLB_ARRAYS]);

/* ---- groups, meshes, nodes ---- */

void glb_put_name(file_writer *t, const char *separator, const char *name);
/* Overrides and node counts of all groups. */
fathom_status glb_plan_groups(glb *g);
/* The members "scene", "scenes", "nodes" and "meshes". */
void glb_put_tree(const glb *g, file_writer *t);

/* ---- cameras and lights ---- */

/* How many nodes the lights and the camera take, and these nodes, which follow all others. */
size_t glb_surroundings(const glb *g);
void glb_put_surroundings(const glb *g, file_writer *t);
/* The members "cameras", and "extensions" with the lights. */
void glb_put_cameras(const glb *g, file_writer *t);
bool glb_has_lights(const glb *g);

/* ---- materials ---- */

/* The members "materials" and "extensionsUsed". */
void glb_put_materials(glb *g, file_writer *t);
/* The members "textures", "samplers" and "images". */
void glb_put_textures(const glb *g, file_writer *t);
/* A material of the classic model as a metallic-roughness one: the inverse of reading, as far as they agree.
 */
fathom_material glb_classic(const fathom_material *m);

#endif
