/* The extent of a mesh's vertices along a few directions, found without reading most of them. */
#pragma once

#include "scene/mesh/mesh_facts.h"

#include <stdbool.h>
#include <stddef.h>

enum { EXTENT_SIDES = 4 };

/* The extent of a vertex p along side i is x[i] p.x + y[i] p.y + z[i] p.z + origin[i] + offset[i], added in
 * this order. */
typedef struct extent_sides {
    double x[EXTENT_SIDES], y[EXTENT_SIDES], z[EXTENT_SIDES];
    double origin[EXTENT_SIDES], offset[EXTENT_SIDES];
} extent_sides;

typedef struct extent_box {
    float lower[3], upper[3];
} extent_box;

/* A bounding box for each run of consecutive vertices. */
typedef struct extent_boxes {
    extent_box *items; /* NULL: not made yet; the owner frees it */
    size_t count;
} extent_boxes;

/* False when out of memory. The mesh's strides must be set. */
bool extent_make_boxes(unsigned threads, const fathom_mesh *mesh, extent_boxes *out);

/* True when the extent of a vertex in the box may exceed `most` along some side, or is NaN there. */
bool extent_box_beyond(const extent_sides *sides, const extent_box *box, const double most[EXTENT_SIDES]);

/* Raises `most` to the extent of the vertices. A vertex whose extent is NaN does not count. */
void extent_of_mesh(const extent_sides *sides, const fathom_mesh *mesh, const extent_boxes *boxes,
                    double most[EXTENT_SIDES]);
