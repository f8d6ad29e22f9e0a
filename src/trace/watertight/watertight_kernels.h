/* What watertight.c asks of every block; kernels/watertight.c. */
#ifndef TRACE_WATERTIGHT_KERNELS_H
#define TRACE_WATERTIGHT_KERNELS_H

#include "trace/trace.h"

typedef struct watertight_kernels {
    /* Whether any lane's ray meets the back of what it meets, closed or not. turned: some instances are
     * placed by maps that turn, mirror or skew. */
    bool (*any_back)(const world *w, bool turned, const trace_block *block, unsigned lanes);
} watertight_kernels;

#endif
