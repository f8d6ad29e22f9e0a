/* The parts of writing a .glb. */
#ifndef READ_WRITE_GLB_H
#define READ_WRITE_GLB_H

#include "write/write.h"

/* Where the arrays of a mesh lie in the binary chunk. */
typedef struct glb_mesh {
    write_mesh vertices; /* .mesh is NULL: not placed, not written */
    uint32_t accessor;   /* of the positions; then normals, uvs, indices, as far as there are */
    size_t offset;       /* of the positions; the others follow, each aligned */
} glb_mesh;

/* glTF's meshes carry their materials, so a group that is placed under k different overriding materials
 * becomes k glTF meshes over the same arrays; a mesh with an origin of its own needs a node, and so a glTF
 * mesh, of its own. */
typedef struct glb_group {
    ARRAY(fathom_id) overrides; /* sorted, each once; FATHOM_NONE among them when it is placed without one */
    uint32_t first_mesh;        /* glTF mesh of the first override */
    uint32_t far_count;         /* meshes with an origin of their own */
    bool near;                  /* whether there are others */
    size_t nodes;               /* of one placement, all that is inside counted */
} glb_group;

typedef struct glb {
    const fathom_scene *scene;
    const scene_graph *graph;
    const char *path;
    glb_mesh *meshes;  /* beside the scene's */
    glb_group *groups; /* beside the scene's */
    size_t binary_size;
    write_text json;
} glb;

#define GLB_ALIGNMENT 16

static inline size_t glb_align(size_t size) {
    return (size + GLB_ALIGNMENT - 1) / GLB_ALIGNMENT * GLB_ALIGNMENT;
}

/* Sizes in bytes of positions, normals, uvs and indices, 0 where the mesh has none. */
void glb_sizes(const glb_mesh *m, size_t sizes[4]);
/* The meshes of a group in the order in which they are written. */
bool glb_is_near(const fathom_mesh *mesh);
const fathom_mesh *glb_object_mesh(const glb *g, uint32_t item, uint32_t *index);
/* glTF mesh for a group placed under an override. */
uint32_t glb_mesh_number(const glb *g, uint32_t group, fathom_id override);

/* Overrides and node counts of all groups. */
fathom_status glb_plan_groups(glb *g);
void glb_put_json(glb *g);
void glb_put_materials(glb *g);

#endif
