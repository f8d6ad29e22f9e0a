/* The parts of writing a .glb. */
#ifndef READ_WRITE_GLB_H
#define READ_WRITE_GLB_H

#include "write/write.h"

/* The arrays of a mesh in the binary chunk. */
typedef struct glb_mesh {
    write_mesh vertices; /* .mesh is NULL: not placed, not written */
    uint32_t accessor;   /* of the positions; then those of normals, uvs and indices that exist */
    size_t offset;       /* of the positions; the others follow, each aligned */
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
    size_t binary_size;
    write_text json;
} glb;

#define GLB_ALIGNMENT 16

static inline size_t glb_align(size_t size) {
    return (size + GLB_ALIGNMENT - 1) / GLB_ALIGNMENT * GLB_ALIGNMENT;
}

/* Sizes in bytes of positions, normals, uvs and indices, 0 where the mesh has none. */
void glb_sizes(const glb_mesh *m, size_t sizes[4]);
bool glb_is_near(const fathom_mesh *mesh);
const fathom_mesh *glb_object_mesh(const glb *g, uint32_t item, uint32_t *index);
/* The glTF mesh of a group placed under an override. */
uint32_t glb_mesh_number(const glb *g, uint32_t group, fathom_id override);

/* Overrides and node counts of all groups. */
fathom_status glb_plan_groups(glb *g);
void glb_put_json(glb *g);
void glb_put_materials(glb *g);

#endif
