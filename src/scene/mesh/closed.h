/* Which meshes are closed: without a boundary, and oriented alike throughout. */
#ifndef SCENE_CLOSED_H
#define SCENE_CLOSED_H

#include "scene/world/world.h"

typedef enum closed_how {
    CLOSED_NOT,
    CLOSED_ALONE,   /* every edge is met by as many triangles one way as the other */
    CLOSED_TOGETHER /* with the other open meshes of its group: a body cut up by material */
} closed_how;

/* Finds this for each of the world's geometries. Vertices are told apart by position. False when out of
 * memory. */
bool closed_find(const world *w, closed_how *closed);

/* ---- pieces.c: the connected pieces of a mesh; triangles belong together that share a vertex ---- */

typedef struct pieces {
    uint32_t count;      /* 1 or more; 0: more than were asked for */
    uint32_t *of_vertex; /* the piece of each vertex that a triangle has; NULL where the count is 0 or 1 */
} pieces;

/* by_position: vertices at equal positions count as one. Looks for at most `most` pieces. False when out of
 * memory. Release of_vertex with free(). */
bool pieces_find(unsigned threads, const fathom_mesh *mesh, bool by_position, uint32_t most, pieces *out);

static inline uint32_t pieces_of(const uint32_t *of_vertex, const fathom_mesh *mesh, uint32_t triangle) {
    return of_vertex ? of_vertex[mesh->indices[3 * (size_t)triangle]] : 0;
}

#endif
