/* Loops over the arrays of meshes; see base/kernel.h. */
#ifndef SCENE_KERNELS_H
#define SCENE_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct scene_kernels {
    const char *name; /* "plain", "avx2", "avx512" */

    /* Adds `count` vectors that lie `stride` bytes apart to the extremes; NaNs may be skipped. False where a
     * number is not finite. */
    bool (*vectors)(const float *values, size_t stride, size_t count, float lower[3], float upper[3]);

    /* Whether all of `count` indices are below the limit. */
    bool (*indices)(const uint32_t *indices, size_t count, uint32_t limit);

    /* The sum of boundary.h over `count` triangles, by the indices of their vertices. */
    uint64_t (*boundary)(const uint32_t *triangles, size_t count);

    /* False where not each of `count` triangles has an area for sure and lies within WORLD_REACH; else raises
     * *largest to the largest of their coordinates. Reads four floats from each vertex. */
    bool (*areas)(const float *positions, size_t stride, const uint32_t *triangles, size_t count,
                  float *largest);
} scene_kernels;

const scene_kernels *scene_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const scene_kernels *scene_kernels_at(unsigned index);

#endif
