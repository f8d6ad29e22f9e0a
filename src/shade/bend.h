/* Mirrored and refracted rays. */
#ifndef SHADE_BEND_H
#define SHADE_BEND_H

#include "shade/surface.h"

/* Rays that leave sixteen points; weight 0 where none does. */
typedef struct bend_block {
    _Alignas(64) lanes3 origin;
    lanes3 direction; /* unit */
    float weight[3][LANES];
} bend_block;

#endif
