/* Small scenes that hold every shape, for runs without a scene of one's own. */
#ifndef PARITY_BUILTIN_H
#define PARITY_BUILTIN_H

#include <fathom/scene.h>

/* "spheres" …; NULL past the last. */
const char *builtin_name(unsigned index);

/* Complete and checked; release with fathom_scene_destroy(). */
fathom_status builtin_create(fathom_context *context, unsigned index, fathom_scene **out);

#endif
