/* Loops over the arrays of meshes; see base/kernel.h. */
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct scene_kernels {
    const char *name; /* "plain", "avx2", "avx512" */

    /* Extends the bounds by `count` vectors that are `stride` bytes apart; NaNs may be skipped. False if a
     * number is not finite. */
    bool (*vectors)(const float *values, size_t stride, size_t count, float lower[3], float upper[3]);

    /* True when all of `count` indices are below the limit. */
    bool (*indices)(const uint32_t *indices, size_t count, uint32_t limit);

    /* The sum of boundary_sum() over `count` triangles, with boundary_of_index() of their vertices. */
    uint64_t (*boundary)(const uint32_t *triangles, size_t count);

    /* True if it is certain that each of `count` triangles has an area and lies within WORLD_REACH; then
     * raises *largest to the largest magnitude of their coordinates. Reads four floats from each vertex. */
    bool (*areas)(const float *positions, size_t stride, const uint32_t *triangles, size_t count,
                  float *largest);
} scene_kernels;

const scene_kernels *scene_kernels_best(void);

/* ---- a sum over the edges of triangles that is zero for closed meshes; see closed.c ---- */

/* Two rounds of multiplication and shift (the finalizer of MurmurHash3, A. Appleby): every bit of the result
 * depends on every bit of x. */
static inline uint32_t boundary_mixed(uint32_t x) {
    x = (x ^ x >> 16) * 0x85ebca6bu;
    x = (x ^ x >> 13) * 0xc2b2ae35u;
    return x ^ x >> 16;
}

/* The two numbers assigned to a vertex. */
typedef struct boundary_pair {
    uint32_t x, y;
} boundary_pair;

static inline boundary_pair boundary_of_index(uint32_t i) {
    return (boundary_pair){i, boundary_mixed(i + 0x9e3779b9u)};
}

/* The sum of x(a) y(b) - x(b) y(a) over the edges of a triangle, where an edge goes from a to b. It is modulo
 * 2^64, so the order of summation does not matter. */
static inline uint64_t boundary_sum(boundary_pair a, boundary_pair b, boundary_pair c) {
    const uint64_t x = a.x, y = a.y;
    return (b.x - x) * (c.y - y) - (c.x - x) * (b.y - y);
}
