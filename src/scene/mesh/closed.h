/* Finds which meshes are closed: without a boundary, and consistently oriented. */
#pragma once

#include "scene/world/world.h"

#include <string.h>

typedef enum closed_how {
    CLOSED_NOT,
    CLOSED_ALONE,   /* every edge is used by the same number of triangles in both directions */
    CLOSED_TOGETHER /* closed only with the other open meshes of its group: a body divided by material */
} closed_how;

/* Sets closed[i] for each geometry i of the world. Vertices at equal positions count as one. False when out
 * of memory. */
bool closed_find(const world *w, closed_how *closed);

/* Bits of a vertex that are equal if the positions are. Adding +0 makes both zeros equal. */
static inline void closed_position_bits(const fathom_mesh *mesh, size_t v, uint32_t out[3]) {
    float p[3];
    memcpy(p, mesh_vertex(mesh, v), sizeof p);
    for (int c = 0; c < 3; ++c) p[c] += 0.0f;
    memcpy(out, p, sizeof p);
}

/* ---- pieces.c: the connected pieces of a mesh; triangles that share a vertex are connected ---- */

typedef struct pieces {
    uint32_t count;      /* 1 or more; 0: there are more than `most` */
    uint32_t *of_vertex; /* the piece of each vertex that a triangle uses; NULL if the count is 0 or 1 */
} pieces;

/* by_position: vertices at equal positions count as one. Stops if there are more than `most` pieces. False
 * when out of memory. Release of_vertex with free(). */
bool pieces_find(unsigned threads, const fathom_mesh *mesh, bool by_position, uint32_t most, pieces *out);

static inline uint32_t pieces_of(const uint32_t *of_vertex, const fathom_mesh *mesh, uint32_t triangle) {
    return of_vertex ? of_vertex[mesh->indices[3 * (size_t)triangle]] : 0;
}
