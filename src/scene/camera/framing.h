/* Where a camera must stand to see everything. */
#ifndef SCENE_FRAMING_H
#define SCENE_FRAMING_H

#include "math/frame.h"
#include "scene/scene.h"

/* The nearest place from which all of the scene lies in view, for an eye that looks along -axes->z and sees
 * slopes of at most across and up from the middle of its image; axes->origin is not read. The scene touches
 * both sides of the view in the tighter direction, unless the eye would come too near to its foremost point,
 * and is centred in the other. The scene must have no cycle. *empty: nothing in it has bounds, and *eye is
 * not set. FATHOM_BAD_INPUT when the place is not finite. */
fathom_status scene_frame_all(const fathom_scene *scene, const frame_f64 *axes, double across, double up,
                              bool *empty, vec3_f64 *eye);

#endif
