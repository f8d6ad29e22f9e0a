/* Spheres around runs of a world's primitives, around runs of those spheres, and so on. */
#ifndef PARITY_SEARCH_TREE_H
#define PARITY_SEARCH_TREE_H

#include "verify/exact/filter.h"

#define SEARCH_RUN 16 /* primitives or spheres in one sphere */
#define SEARCH_LEVELS 9

/* The levels of one geometry; the last has at most SEARCH_RUN spheres. */
typedef struct search_part {
    unsigned levels;                                  /* 0: it is empty */
    size_t slot[SEARCH_LEVELS], count[SEARCH_LEVELS]; /* of each level's spheres; level 0 holds primitives */
    uint32_t *order; /* which primitives are in the runs, one after another; NULL: as they come */
} search_part;

typedef struct search_tree {
    filter_spheres bounds;
    search_part *parts; /* of each geometry of the world */
    uint32_t *order;    /* of all of them */
    double extent;      /* all but planes lies so far from the world's origin at most */
} search_tree;

/* Zero it first and free it whatever comes back. False when out of memory. */
bool search_tree_build(const world *w, search_tree *tree);
void search_tree_free(search_tree *tree);

/* True when all its corners are finite: others are never met, and in no sphere. */
bool search_tree_takes(const oracle_primitive *primitive);

#endif
