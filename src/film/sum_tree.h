/* Sums of samples whose bits do not depend on who added which samples.
 *
 * The samples of a pixel are leaves of SUM_LEAF samples each, in the order of their indices. A leaf is summed
 * sample by sample. A node adds its left child to its right one: at level l it holds leaves k 2^l to
 * (k + 1) 2^l - 1. The sum of all is that of the nodes that make up all leaves, largest first, added from the
 * end. A machine that has some leaves alone, next to each other, adds up the nodes that lie within; whoever
 * gets all nodes goes on from there, and does the additions of one machine that had all leaves. */
#ifndef FILM_SUM_TREE_H
#define FILM_SUM_TREE_H

#include "film/pixel_sums.h"

/* A sample of each group. */
#define SUM_LEAF 4u

/* The sums of a square's pixels, as pixel_sums has them for a wave's. */
typedef struct square_sums {
    double rgb[SAMPLE_GROUPS][3][LANES];
    double alpha[LANES], n[3][LANES], albedo[3][LANES], nearest[LANES]; /* hits */
    float z[LANES], p[3][LANES], motion[4][LANES];                      /* of the nearest, as the next */
    uint32_t object[LANES], primitive[LANES], instance[LANES];
    double (*layers)[LANES]; /* where there are any, as the next */
    matte_list (*mattes)[LANES];
} square_sums;

/* Of leaves first to first + 2^level - 1, or fewer at the end of all. */
typedef struct sum_node {
    uint32_t first, level;
    square_sums sums;
} sum_node;

/* Nodes side by side, none of which can be added to the next. */
typedef struct sum_stack {
    uint32_t count;
    sum_node *nodes; /* the caller's: room for sum_stack_depth() */
} sum_stack;

/* Samples [begin, end) of a pixel: those of part `index` of `count`, from 0; whole leaves. */
typedef struct sum_range {
    uint32_t begin, end;
} sum_range;

static inline uint32_t sum_leaves(uint32_t spp) { return (spp + SUM_LEAF - 1) / SUM_LEAF; }
static inline sum_range sum_part(uint32_t spp, uint32_t index, uint32_t count) {
    const uint64_t leaves = sum_leaves(spp);
    const uint32_t begin = (uint32_t)(leaves * index / count) * SUM_LEAF,
                   end = (uint32_t)(leaves * (index + 1) / count) * SUM_LEAF;
    return (sum_range){begin, end < spp ? end : spp};
}

/* Zeros, with their layers; release with free(). NULL: out of memory. */
sum_node *sum_nodes_create(film_parts parts, size_t count);

/* The most nodes that a stack of these samples ever has. */
uint32_t sum_stack_depth(sum_range range);
/* The nodes that are left of these samples: their firsts and levels in order, of which `out` may be NULL. */
uint32_t sum_list_nodes(sum_range range, sum_node *out);

/* Moves the sums of a square out of those of the wave, where they become 0. */
void sum_take(pixel_sums *from, uint32_t square, square_sums *out);
void sum_give(const square_sums *from, uint32_t square, pixel_sums *to);

/* The top of the stack, at nodes[count], has been filled: it goes in, and is added to what it completes. The
 * nodes have the parts that `like` has. */
void sum_push(const pixel_sums *like, sum_stack *stack);
/* Adds up all nodes: nodes[0] is the sum. */
void sum_fold(const pixel_sums *like, sum_stack *stack);

/* Bytes of a node's sums in a file; room for these. */
size_t sum_bytes(uint32_t groups, film_parts parts);
void sum_save(const square_sums *from, uint32_t groups, film_parts parts, unsigned char *out);
void sum_load(const unsigned char *in, uint32_t groups, film_parts parts, square_sums *to);

#endif
