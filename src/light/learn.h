/* Estimates from rays which parts of the light, called blocks, regions of surfaces see. */
#pragma once

#include "base/array.h"
#include "light/regions.h"

#include <stdint.h>

enum { LEARN_BLOCKS = 512, LEARN_LEVELS = 4 };
#define LEARN_NONE UINT16_MAX

/* A ray from a surface to a block. */
typedef struct learn_look {
    float at[6]; /* its point, and perhaps the normal */
    float seen;  /* fraction of its light that arrives, in [0, 1] */
    uint32_t block;
} learn_look;

/* Rays of a region. */
typedef struct learn_looks {
    learn_look *items;
    size_t count;
} learn_looks;

typedef struct learner {
    uint32_t blocks;                             /* at most LEARN_BLOCKS */
    uint16_t groups[LEARN_LEVELS][LEARN_BLOCKS]; /* by block, from the largest to the smallest; LEARN_NONE */
    unsigned axes;                               /* coordinates of `at` that divide regions */
    float scales[6];                             /* of these */
    size_t least;                                /* minimum number of rays of a region */
    /* Makes a leaf for a region, without REGION_LEAF. seen: by block, fractions in (0, 1]. */
    uint32_t (*settle)(void *user, learn_looks looks, const double seen[LEARN_BLOCKS]);
    void *user;
    ARRAY(region_split) splits;
    bool fails; /* out of memory */
} learner;

/* Divides surfaces into regions; returns them all, as region_split.below. Reorders the rays. */
uint32_t learn_regions(learner *l, learn_looks looks);
