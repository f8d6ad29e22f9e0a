/* Small scenes with every kind of shape, for runs without a scene file. */
#pragma once

#include <fathom/scene.h>

/* "spheres" …; NULL past the last. */
const char *builtin_name(unsigned index);

/* Makes the scene, complete and checked; release with fathom_scene_destroy(). FATHOM_BAD_INPUT when there is
 * none of this name. */
fathom_status builtin_create(fathom_context *context, const char *name, fathom_scene **out);
