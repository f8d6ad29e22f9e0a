/* Bounding spheres around runs of a world's primitives, around runs of these spheres, and so on. */
#pragma once

#include "verify/exact/filter.h"

#define SEARCH_RUN 16 /* primitives or spheres in one sphere */
#define SEARCH_LEVELS 9

/* The levels of one geometry; the last has at most SEARCH_RUN spheres. */
typedef struct search_part {
    unsigned levels;                                  /* 0: it is empty */
    size_t slot[SEARCH_LEVELS], count[SEARCH_LEVELS]; /* first sphere and number of spheres of each level;
                                                         level 0 bounds primitives */
    uint32_t *order; /* the primitives of all runs, in order; NULL: order of the world */
} search_part;

typedef struct search_tree {
    filter_spheres bounds;
    search_part *parts; /* of each geometry of the world */
    uint32_t *order;    /* storage for all parts' `order` */
    double extent;      /* maximum distance of anything but planes from the world's origin */
} search_tree;

/* Zero *tree first; free it also after a failure. False when out of memory. */
bool search_tree_build(const world *w, search_tree *tree);
void search_tree_free(search_tree *tree);

/* True when all its corners are finite. Others are never hit, and are in no sphere. */
bool search_tree_takes(const oracle_primitive *primitive);
