/* Nodes, and the lights and cameras that they place. */
#pragma once

#include "read/gltf/gltf.h"

/* A place of a node in the tree. Links to others are GLTF_ABSENT if there are none. */
struct gltf_link {
    uint32_t node; /* its index */
    uint32_t parent;
    uint32_t child; /* the last one */
    uint32_t next;  /* the sibling before it */
};

/* The place and the index of a camera; one for each camera of the scene. */
struct gltf_camera {
    uint32_t link, index; /* `link` into links, `index` into cameras */
};

/* ---- gltf_tree.c, gltf_node.c ---- */

/* Fills in g->links, which then have no cycle. */
void gltf_tree_open(gltf *g);
/* Walks the nodes of the scene. */
void gltf_nodes_place(gltf *g);

/* ---- gltf_light.c, gltf_camera.c ---- */

void gltf_light_place(gltf *g, const gltf_value *node, const gltf_way *to_world);
void gltf_camera_note(gltf *g, const gltf_value *node, uint32_t link);
/* Sets the scene's camera to the requested one of the noted cameras, else to the first perspective one. */
void gltf_camera_take(gltf *g);
