/* Chooses one of many lights by how much it may send to a point: a tree of bounds of places, directions and
 * power (Conty Estevez and Kulla 2018), eight children to a node.
 *
 * Bounds tell little about lights that surround the point, and a walk from the root would lose half of its
 * chance to far lights at every level. So the walk starts from a cut through the tree: nodes near the point
 * are replaced by their children, level by level, up to TREE_NEAR of them (as in Yuksel's stochastic
 * lightcuts, 2019, but chosen for each point). */
#ifndef LIGHT_TREE_H
#define LIGHT_TREE_H

#include "math/lanes.h"
#include "math/vec.h"

#include <stdint.h>

#define TREE_WIDE 8
#define TREE_LEAF 0x80000000u
#define TREE_NEAR 23

/* A light, for building. */
typedef struct tree_item {
    float lower[3], upper[3];
    float axis[3]; /* unit: both ways along it go the brightest directions; all 0: light goes every way */
    float spread;  /* the cosine of the widest angle between them and the axis, which turns; 1: it does not */
    float power;   /* radiant intensity at most, in any unit; > 0 */
    uint32_t light;
} tree_item;

/* The bounds of each child: a box by its middle and half its sides, a cone around ±axis with the cosine
 * `spread`, and the sum of power. Empty ones have no power. Lengths are multiplied by the tree's scale. */
typedef struct tree_node {
    float x[TREE_WIDE], y[TREE_WIDE], z[TREE_WIDE];
    float half_x[TREE_WIDE], half_y[TREE_WIDE], half_z[TREE_WIDE];
    float axis_x[TREE_WIDE], axis_y[TREE_WIDE], axis_z[TREE_WIDE], spread[TREE_WIDE];
    float power[TREE_WIDE];
    uint32_t child[TREE_WIDE]; /* a node, or TREE_LEAF + a light */
} tree_node;

typedef struct tree {
    tree_node *nodes; /* the first is the root */
    uint32_t *parent; /* of a node: TREE_WIDE times its parent, plus which child it is */
    uint32_t count;
    float scale;  /* a power of two; keeps squares within the range of float */
    double power; /* of all lights, as their items have it; nodes hold parts of the strongest */
    const struct tree_kernels *kernels;
} tree;

/* Reorders the items, fewer than 2^31. slot_of, by light: set to TREE_WIDE times the node, plus which child
 * it is. False without memory. Release with tree_destroy(). */
bool tree_build(tree_item *items, uint32_t count, tree *out, uint32_t *slot_of);
void tree_destroy(tree *t);

/* The chance that choose() takes the light in this slot. */
double tree_chance(const tree *t, vec3_f32 p, vec3_f32 n, uint32_t slot);

/* A cut: the children of `count` nodes, of which the first is the root. A child that is among the nodes has
 * no weight of its own. */
typedef struct tree_cut {
    uint32_t count, node[1 + TREE_NEAR];
    uint32_t
        next[1 + TREE_NEAR]; /* in which order u passes them: from the first, which is next of the last */
    float weight[1 + TREE_NEAR][TREE_WIDE];
} tree_cut;

typedef struct tree_kernels {
    /* How much the children of a node may send to p, which is multiplied by the tree's scale. unsure:
     * the most that nodes near p may send, and 0 for all others. */
    void (*weigh)(const tree_node *node, vec3_f32 p, vec3_f32 n, float weight[TREE_WIDE],
                  float unsure[TREE_WIDE]);
    void (*cut)(const tree *t, vec3_f32 p, vec3_f32 n, tree_cut *out); /* p: likewise */

    /* The lights that u in [0,1) chooses for points p with unit normals n (0: none), and their chances, for
     * the lanes whose bit is set; chance 0: no light reaches the point. Changes u. */
    void (*choose)(const tree *t, const lanes3 p, const lanes3 n, unsigned lanes, double u[LANES],
                   uint32_t light[LANES], double chance[LANES]);
} tree_kernels;

const tree_kernels *tree_kernels_best(void);

#endif
