/* Invisible shapes: their material passes all light straight on, and they cast no shadow. glTF's alphaMode
 * MASK and an MTL's `d 0` cut surfaces away like that. No ray meets them, so they take no bounce, and no AOV
 * shows them. */
#ifndef SCENE_ABSENT_H
#define SCENE_ABSENT_H

#include "scene/graph.h"

/* True for a classic material with k_t 1, an ior of 1, and everything else 0. */
bool absent_material(const fathom_material *m);

/* Sets out[object] for each object of the scene. A shape stays where an instance gives it another material:
 * its group is then traced as a whole wherever it is placed. */
fathom_status absent_find(const fathom_scene *scene, const scene_graph *graph, bool *out);

/* True when the shape is invisible with its own material. */
bool absent_object(const fathom_scene *scene, fathom_id object);
/* True when every instance keeps the materials inside, so that absent_object() decides alone. */
bool absent_by_own_material(const fathom_scene *scene);

#endif
