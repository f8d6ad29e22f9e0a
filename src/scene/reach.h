/* How far the vertices of a mesh reach along a few directions, without looking at most of them. */
#ifndef SCENE_REACH_H
#define SCENE_REACH_H

#include "scene/mesh/mesh_facts.h"

#include <stdbool.h>
#include <stddef.h>

enum { REACH_SIDES = 4 };

/* Along side i a vertex p reaches to x[i] p.x + y[i] p.y + z[i] p.z + origin[i] + offset[i], added in this
 * order. */
typedef struct reach_sides {
    double x[REACH_SIDES], y[REACH_SIDES], z[REACH_SIDES];
    double origin[REACH_SIDES], offset[REACH_SIDES];
} reach_sides;

typedef struct reach_box {
    float lower[3], upper[3];
} reach_box;

/* A box for each run of vertices that follow each other. */
typedef struct reach_boxes {
    reach_box *items; /* NULL: not made yet; the owner frees it */
    size_t count;
} reach_boxes;

/* False when there is no memory. The mesh's strides are set. */
bool reach_make_boxes(unsigned threads, const fathom_mesh *mesh, reach_boxes *out);

/* Whether a vertex in the box may reach beyond `most` along some side; true where that is not a number. */
bool reach_box_beyond(const reach_sides *sides, const reach_box *box, const double most[REACH_SIDES]);

/* Raises `most` to how far the vertices reach. Vertices whose reach is not a number do not count. */
void reach_of_mesh(unsigned threads, const reach_sides *sides, const fathom_mesh *mesh,
                   const reach_boxes *boxes, double most[REACH_SIDES]);

#endif
