/* A number that differs between scenes that may render differently. */
#ifndef SCENE_FINGERPRINT_H
#define SCENE_FINGERPRINT_H

#include "scene/scene.h"

/* Covers everything that pixels may depend on: shapes, materials, lights, places, camera and surroundings;
 * not names, texture coordinates or settings. Reads all arrays of all meshes, on the context's threads. */
fathom_status scene_fingerprint(const fathom_scene *scene, uint64_t *out);

#endif
