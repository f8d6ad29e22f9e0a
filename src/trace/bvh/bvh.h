/* The hand-written BVH gives exactly the hits of linear search. Boxes are float, like the world's
 * coordinates, so one structure serves every precision. There is one tree per geometry, and one per group
 * over its geometries; the root's tree also holds the instances. */
#pragma once

#include "trace/tracer.h"

typedef struct bvh_node {
    float lower[3], upper[3];
    uint32_t first; /* inner: index of its first child, the second follows; leaf: of its first item */
    uint32_t count; /* of items, at most BVH_LEAF; 0: an inner node */
} bvh_node;

#define BVH_LEAF 4

typedef struct bvh_tree {
    const world_geometry *geometry; /* NULL: the tree of a group */
    bvh_node *nodes;                /* [0] is the root */
    uint32_t node_count;            /* 0: nothing in it can be hit */
    uint32_t *items;                /* primitives; of a group: its geometries, then the instances */
    uint32_t count;                 /* of items */
    /* Slack of the box tests: by how much a ray may miss a box and still hit something in it, and by how much
     * nearer along the ray. spread: in unit roundoffs of the distance to the box; offset: in unit roundoffs
     * of 1; reach: a length. See bvh_text.h. */
    double spread, offset, reach;
} bvh_tree;

typedef struct bvh_tracer {
    trace_tracer base;
    bvh_tree *geometries; /* in the order of the world's */
    bvh_tree *groups;
} bvh_tracer;

/* Input of a build. */
typedef struct bvh_item {
    float lower[3], upper[3];
    uint32_t id;
} bvh_item;

/* Builds the nodes and reorders the items. `go_on` may be NULL; if it returns false: FATHOM_INTERRUPTED. */
typedef struct bvh_build {
    fathom_context *context;
    bool (*go_on)(void *user, double fraction);
    void *user;
} bvh_build;
fathom_status bvh_tree_build(const bvh_build *build, bvh_item *items, uint32_t count, bvh_tree *tree);

/* bvh_trace.c: the calls of each precision. */
extern const trace_ops bvh_ops_f32, bvh_ops_f64, bvh_ops_f128;

/* bvh_world.c */
void bvh_destroy(trace_tracer *tracer);
