/* Chooses one of many lights by how much light it may send to a point: a tree of bounds of positions,
 * directions and power (Conty Estevez and Kulla 2018), with eight children per node.
 *
 * Bounds say little about lights that surround the point, and a traversal from the root would lose half of
 * its probability to far lights at every level. The traversal therefore starts from a cut through the tree:
 * nodes that are bright and large, as seen from the point, are replaced by their children, level by level, up
 * to TREE_NEAR of them (as in Yuksel's stochastic lightcuts, 2019, but chosen for each point). Regions of
 * surfaces may have a list of parts instead, which is made once: tree_view.h. */
#pragma once

#include "fathom/scene.h"
#include "math/lanes.h"
#include "math/vec.h"

#include <stdbool.h>
#include <stdint.h>

#define TREE_WIDE 8
#define TREE_LEAF 0x80000000u
#define TREE_NEAR 31

/* A light, as input of the build. */
typedef struct tree_item {
    float lower[3], upper[3];
    float axis[3]; /* unit: the brightest directions are those along ±axis; all 0: the light emits in all
                      directions */
    float spread;  /* the cosine of the widest angle between those directions and the axis, if they vary; 1:
                      they do not */
    bool beam;     /* as a spot: all light goes within the angle of cosine `spread` > 0 of +axis */
    float power;   /* upper bound of the radiant intensity, in any unit; > 0 */
    uint32_t light;
} tree_item;

/* The bounds of each child: a box given by its centre and half its sides, a cone around ±axis with the cosine
 * `spread`, and the sum of power. If `spread` is negative, all light goes within the angle of cosine -spread
 * of +axis. Empty children have no power. Lengths are multiplied by the tree's scale. */
typedef struct tree_node {
    float x[TREE_WIDE], y[TREE_WIDE], z[TREE_WIDE];
    float half_x[TREE_WIDE], half_y[TREE_WIDE], half_z[TREE_WIDE];
    float axis_x[TREE_WIDE], axis_y[TREE_WIDE], axis_z[TREE_WIDE], spread[TREE_WIDE];
    float power[TREE_WIDE];
    uint32_t child[TREE_WIDE]; /* a node, or TREE_LEAF + a light */
} tree_node;

typedef struct tree {
    tree_node *nodes; /* the first node is the root */
    uint32_t *parent; /* of a node: TREE_WIDE times its parent, plus its index among the parent's children */
    uint32_t count;
    uint32_t *row_of;   /* by node: its row of factors, or FATHOM_NONE; NULL: no node has one */
    uint32_t *row_node; /* by row */
    uint32_t rows;
    float scale;  /* a power of two; keeps squares within the range of float */
    double power; /* sum over all lights, in the unit of their items; in nodes the strongest light has 1 */
    const struct tree_kernels *kernels;
} tree;

/* Reorders the items, fewer than 2^31. slot_of, by light: set to TREE_WIDE times the node, plus the child's
 * index. False if out of memory. Release with tree_destroy(). */
bool tree_build(tree_item *items, uint32_t count, tree *out, uint32_t *slot_of);
void tree_destroy(tree *t);

/* Factors of the weights of some children: TREE_WIDE for each node that has a row, in (0, 1]. All lights
 * below a child have its factor, unless the child has a row itself. NULL: all factors are 1. */
typedef const float *tree_factors;

/* Gives rows to the root and to at most `most` - 1 other nodes, always to a node's parent first. They divide
 * the lights into blocks: a block has the lights below a child without a row. asked, by slot: nodes with more
 * questions get rows first, those with fewer than `least` none. False: out of memory. */
bool tree_set_rows(tree *t, const uint32_t *asked, uint32_t least, uint32_t most);
/* Sets the factors of children with rows to the mean of their lights' factors, weighted by power. */
void tree_average(const tree *t, float *factors);
/* The index in a table of factors of this slot, whose node has a row. */
static inline uint32_t tree_factor_at(const tree *t, uint32_t slot) {
    return t->row_of[slot / TREE_WIDE] * TREE_WIDE + slot % TREE_WIDE;
}
/* The block of the light in this slot, as tree_factor_at(). */
uint32_t tree_block(const tree *t, uint32_t slot);

/* Knowledge of the lights in a region: tree_view.h. */
typedef struct tree_view tree_view;

/* The probability that choose() takes the light in this slot. view: NULL: nothing is known. */
double tree_chance(const tree *t, vec3_f32 p, vec3_f32 n, const tree_view *view, uint32_t slot);

/* A cut: the children of `count` nodes, of which the first is the root. A child that is itself among the
 * nodes has the weight 0. */
typedef struct tree_cut {
    uint32_t count, node[1 + TREE_NEAR];
    uint32_t next[1 + TREE_NEAR]; /* order in which u visits the nodes: starts at the first, which is also
                                     next of the last */
    float weight[1 + TREE_NEAR][TREE_WIDE];
} tree_cut;

typedef struct tree_kernels {
    /* Light that the children of a node may send to p; p is already multiplied by the tree's scale. unsure:
     * the upper bound for nodes, times the square of their size over their distance if that is below 1; 0 for
     * lights. */
    void (*weigh)(const tree_node *node, vec3_f32 p, vec3_f32 n, float weight[TREE_WIDE],
                  float unsure[TREE_WIDE]);
    void (*cut)(const tree *t, vec3_f32 p, vec3_f32 n, tree_factors factors, tree_cut *out); /* p: likewise */

    /* Bits: children that a ray from p along the unit vector d may meet before this length; p and length:
     * likewise. May include some that it does not meet. */
    unsigned (*meet)(const tree_node *node, vec3_f32 p, vec3_f32 d, float length);

    /* The lights that u in [0,1) chooses for points p with unit normals n (0: none), and their probabilities,
     * for the lanes whose bit is set; probability 0: no light reaches the point. views: by lane; NULL: of
     * no lane. Changes u. */
    void (*choose)(const tree *t, const lanes3 p, const lanes3 n, const tree_view **views, unsigned lanes,
                   double u[LANES], uint32_t light[LANES], double chance[LANES]);
} tree_kernels;

const tree_kernels *tree_kernels_best(void);
