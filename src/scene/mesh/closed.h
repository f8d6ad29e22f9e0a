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

#endif
