/* The hand-written BVH gives exactly the answers of linear search. Boxes and leaves are float, as the world's
 * numbers are, so one structure serves every precision: a tree for each geometry, and one for each group over
 * its geometries; the root's also holds the instances. */
#ifndef TRACE_BVH_H
#define TRACE_BVH_H

#include "trace/tracer.h"

typedef struct bvh_node {
    float lower[3], upper[3];
    uint32_t first; /* inner: its first child, the other follows; leaf: of its items */
    uint32_t count; /* of items, at most BVH_LEAF; 0: an inner node */
} bvh_node;

#define BVH_LEAF 4

typedef struct bvh_tree {
    const world_geometry *geometry; /* NULL: the tree of a group */
    bvh_node *nodes;                /* [0] is the root */
    uint32_t node_count;            /* 0: nothing in it can be met */
    uint32_t *items;                /* primitives; of a group: its geometries, then the instances */
    uint32_t count;                 /* of items */
    /* How far a ray may pass outside a box and still meet what is in it, and how much nearer along the ray:
     * unit roundoffs of the ray's distance to the box, unit roundoffs of 1, and a length. bvh_text.h. */
    double spread, offset, reach;
} bvh_tree;

typedef struct bvh_tracer {
    trace_tracer base;
    bvh_tree *geometries; /* in the order of the world's */
    bvh_tree *groups;
} bvh_tracer;

/* An item to be put into a tree. */
typedef struct bvh_item {
    float lower[3], upper[3];
    uint32_t id;
} bvh_item;

/* Fills the nodes from the items, which it reorders. `go_on` may be NULL; false: FATHOM_INTERRUPTED. */
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

#endif
