/* Sums of samples whose bits do not depend on which machine added which samples.
 *
 * The samples of a pixel are grouped into leaves of SUM_LEAF samples, in the order of their indices. A leaf
 * is summed sample by sample. An inner node is its left child plus its right child: at level l, it covers the
 * leaves k 2^l to (k + 1) 2^l - 1. The total is the sum of the fewest nodes that cover all leaves, largest
 * first, added from the end. A machine with only some adjacent leaves sums the nodes that lie inside them.
 * The machine that merges the nodes of all machines continues from there, and so does the same additions as
 * one machine with all leaves. */
#pragma once

#include "film/pixel_sums.h"

/* One sample of each group. */
#define SUM_LEAF 4u

/* The sums of a square's pixels, as pixel_sums holds them for a wave. */
typedef struct square_sums {
    double rgb[SAMPLE_GROUPS][3][LANES];
    double alpha[LANES], n[3][LANES], albedo[3][LANES], nearest[LANES]; /* hits */
    float z[LANES], p[3][LANES], motion[4][LANES]; /* of the sample nearest to the centre, as are the ids */
    uint32_t object[LANES], primitive[LANES], instance[LANES];
    double (*layers)[LANES]; /* may be unused, as `mattes` */
    matte_list (*mattes)[LANES];
} square_sums;

/* The sum of leaves first to first + 2^level - 1, or of fewer at the end. */
typedef struct sum_node {
    uint32_t first, level;
    square_sums sums;
} sum_node;

/* Adjacent nodes; none can be merged with the next. */
typedef struct sum_stack {
    uint32_t count;
    sum_node *nodes; /* owned by the caller, with space for sum_stack_depth() nodes */
} sum_stack;

/* Samples [begin, end) of a pixel. sum_part(): the samples of part `index` (from 0) of `count`, in whole
 * leaves. */
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

/* Nodes of zeros, with their layers. Release with free(). NULL: out of memory. */
sum_node *sum_nodes_create(film_parts parts, size_t count);

/* Upper bound of the number of nodes on a stack for these samples. */
uint32_t sum_stack_depth(sum_range range);
/* The nodes that remain of these samples. Returns their number, and writes `first` and `level` of each to
 * `out`, in order; `out` may be NULL. */
uint32_t sum_list_nodes(sum_range range, sum_node *out);

/* Moves the sums of a square out of the wave's sums, which become 0 there. */
void sum_take(pixel_sums *from, uint32_t square, square_sums *out);
void sum_give(const square_sums *from, uint32_t square, pixel_sums *to);

/* Pushes the node that the caller has filled at nodes[count], and merges it with the nodes that it completes.
 * The nodes have the same parts as `like`. */
void sum_push(const pixel_sums *like, sum_stack *stack);
/* Adds up all nodes: nodes[0] is the sum. */
void sum_fold(const pixel_sums *like, sum_stack *stack);

/* Bytes of a node's sums in a file, and the required size of the buffers below. */
size_t sum_bytes(uint32_t groups, film_parts parts);
void sum_save(const square_sums *from, uint32_t groups, film_parts parts, unsigned char *out);
void sum_load(const unsigned char *in, uint32_t groups, film_parts parts, square_sums *to);
