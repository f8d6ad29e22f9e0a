/* Invisible shapes: their material transmits all light as it is, and they cast no shadow. glTF's
 * alphaMode MASK and an MTL's `d 0` remove surfaces this way. No ray hits these shapes, so they cost no
 * bounce and appear in no AOV. */
#pragma once

#include "scene/graph.h"

/* True for a classic material with k_t 1, an ior of 1, and everything else 0. */
bool absent_material(const fathom_material *m);

/* Finds whether each object of the scene is invisible; release *out with free(). A shape is kept if any
 * instance gives it another material; it is then traced in all placements of its group. Does not read
 * graph->absent. */
fathom_status absent_find(const fathom_scene *scene, const scene_graph *graph, bool **out);

/* True when the shape is invisible with its own material: a classic one as above, or a metallic-roughness one
 * that covers nothing. */
bool absent_object(const fathom_scene *scene, fathom_id object);
/* True when no instance replaces materials, so that absent_object() decides alone. */
bool absent_by_own_material(const fathom_scene *scene);
