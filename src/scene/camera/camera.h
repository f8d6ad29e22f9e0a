/* Cameras: the choice among those of a file, the position that shows the whole scene, and the aspect ratio of
 * images. */
#pragma once

#include "math/frame.h"
#include "scene/scene.h"

/* ---- the cameras of files that have several ---- */

/* Adds a camera to scene->cameras. The names are copied; NULL: it has none. */
fathom_status scene_note_camera(fathom_scene *scene, const char *name, const char *own_name,
                                bool orthographic);

/* Sets scene->camera_taken to the requested camera, else to the first perspective one, else to the first.
 * FATHOM_NONE when the file has no camera. Warns if there are several and none was requested.
 * FATHOM_BAD_USAGE, with a list, when the requested camera does not exist or several have its name. */
fathom_status scene_choose_camera(fathom_scene *scene, const char *path);

/* ---- the camera position that shows the whole scene ---- */

/* Finds the nearest position of the eye from which the whole scene is in view. The eye looks along -axes->z,
 * and its view extends to out->slopes on both sides of the image's middle; axes->origin is not read. Sets
 * out->eye and out->reach. In the tighter direction the scene touches both sides of the view, unless the eye
 * would come too near to its foremost point. In the other direction it is centred. The scene must have no
 * cycle. *empty: nothing in the scene has bounds, and nothing else is set. FATHOM_BAD_INPUT when the position
 * is not finite. */
fathom_status scene_frame_all(const fathom_scene *scene, const frame_f64 *axes, bool *empty,
                              fathom_framing *out);

/* Sets out->foot to the point below the centre of the scene's bounds, at the height of the scene's lowest
 * point along the unit vector `up`, and out->radius to the radius of the bounds. The scene must have no
 * cycle. *empty: nothing in the scene has bounds, and nothing else is set. */
fathom_status scene_stand_all(const fathom_scene *scene, vec3_f64 up, bool *empty, fathom_framing *out);

/* True when the read options give the position of the automatic camera and the floor. */
bool scene_framing_asked(const fathom_scene *scene);

/* The up direction from the read options; y by default. */
vec3_f64 scene_way_up(const fathom_scene *scene);

/* Adds a floor below the scene (floor.c), as an object of its own. Does nothing unless the integrator is path
 * tracing, fathom_scene_complete() made the camera, and the camera sees the built-in studio or the
 * environment from the read options, from above the floor. */
fathom_status scene_add_floor(fathom_scene *scene);

/* ---- light ---- */

/* Estimates the irradiance (as luminance) that uniformly emissive surfaces cause on at least a quarter of the
 * other surfaces, from a few hundred points and without occlusion. 0 if nothing emits except by textures.
 * INFINITY if something emits and the scene has a plane: a plane has no quarter, and model files have no
 * planes. */
fathom_status scene_measure_lamps(const fathom_scene *scene, double *out);

/* The mean luminance of the built-in studio (light/studio.h) over all directions. */
#define STUDIO_LUMINANCE 0.696
/* Emissive surfaces can light a scene alone if they give it at least this fraction of the studio's light. */
#define LAMPS_SHARE (1.0 / 16)

/* ---- the aspect ratio of images ---- */

typedef struct image_size {
    uint32_t width, height;
} image_size;

/* The size of the image for which the scene is read: from the read options, else from the settings. */
image_size scene_image_size(const fathom_scene *scene);

/* Gives the image the aspect ratio of a camera (width / height, > 0). A length that is given stays; if both
 * are given, nothing changes. If neither is given, the longer side gets the length of the old longer side. */
void image_size_follow(fathom_settings *settings, double aspect, bool has_width, bool has_height);

/* Warns if the image has another aspect ratio than the camera: the image is stretched, or shows less than the
 * camera's view. */
void scene_warn_shape(const fathom_scene *scene, const char *path);
