/* A sum over the edges of triangles that is zero for closed meshes; see closed.c. */
#ifndef SCENE_BOUNDARY_H
#define SCENE_BOUNDARY_H

#include <stdint.h>

/* Two rounds of multiplication and shift (the finalizer of MurmurHash3, A. Appleby): every bit of the result
 * depends on every bit of x. */
static inline uint32_t boundary_mixed(uint32_t x) {
    x = (x ^ x >> 16) * 0x85ebca6bu;
    x = (x ^ x >> 13) * 0xc2b2ae35u;
    return x ^ x >> 16;
}

/* The two numbers of a vertex. */
typedef struct boundary_pair {
    uint32_t x, y;
} boundary_pair;

static inline boundary_pair boundary_of_index(uint32_t i) {
    return (boundary_pair){i, boundary_mixed(i + 0x9e3779b9u)};
}

/* x(a) y(b) - x(b) y(a) of the edge from a to b, and so of the other two edges of a triangle, in all; modulo
 * 2^64, so that sums may be taken in any order. */
static inline uint64_t boundary_sum(boundary_pair a, boundary_pair b, boundary_pair c) {
    const uint64_t x = a.x, y = a.y;
    return (b.x - x) * (c.y - y) - (c.x - x) * (b.y - y);
}

#endif
