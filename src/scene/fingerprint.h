/* A number that tells scenes apart that may render differently. */
#ifndef SCENE_FINGERPRINT_H
#define SCENE_FINGERPRINT_H

#include "scene/scene.h"

/* Of all that pixels may depend on: shapes, materials, lights, places, camera and surroundings. Not of names,
 * texture coordinates, or settings. Reads all arrays of all meshes, on the context's threads. */
fathom_status scene_fingerprint(const fathom_scene *scene, uint64_t *out);

#endif
