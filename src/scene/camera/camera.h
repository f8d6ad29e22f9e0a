/* Cameras: which of a file's is taken, where one must stand to see everything, and the image's shape. */
#ifndef SCENE_CAMERA_H
#define SCENE_CAMERA_H

#include "math/frame.h"
#include "scene/scene.h"

/* ---- the cameras of files that have several ---- */

/* Adds to scene->cameras. The names are copied; NULL: none. */
fathom_status scene_note_camera(fathom_scene *scene, const char *name, const char *own_name,
                                bool orthographic);

/* Sets scene->camera_taken to the camera that was asked for, else to the first perspective one; FATHOM_NONE
 * when there is none. Warns of the others where none was asked for. FATHOM_BAD_USAGE, with a list, when there
 * is no such camera, when several have the name, and when it is orthographic. */
fathom_status scene_choose_camera(fathom_scene *scene, const char *path);

/* ---- where a camera must stand to see everything ---- */

/* Finds the nearest place from which all of the scene lies in view, for an eye that looks along -axes->z and
 * sees out->slopes from the middle of its image; axes->origin is not read. Sets out->eye and out->reach. The
 * scene touches both sides of the view in the tighter direction, unless the eye would come too near to its
 * foremost point, and is centred in the other. The scene must have no cycle. *empty: nothing in it has
 * bounds, and nothing is set. FATHOM_BAD_INPUT when the place is not finite. */
fathom_status scene_frame_all(const fathom_scene *scene, const frame_f64 *axes, bool *empty,
                              fathom_framing *out);

/* The point below the middle of everything, as low along the unit vector `up` as the lowest point of all, and
 * the radius of the bounds. The scene must have no cycle. *empty: nothing in it has bounds, and nothing is
 * set. */
fathom_status scene_stand_all(const fathom_scene *scene, vec3_f64 up, bool *empty, vec3_f64 *foot,
                              double *radius);

/* The axes of the automatic camera: it looks from ahead, a little to the right and above. */
frame_f64 scene_default_view(fathom_up up);
/* True when whoever reads the scene gives the place of its automatic camera and floor. */
bool scene_framing_asked(const fathom_scene *scene);

/* As whoever reads the scene asked for it; y unless they did. */
vec3_f64 scene_way_up(const fathom_scene *scene);

/* Stands the scene on a floor (floor.c), an object of its own. Nothing happens unless path tracing sees the
 * studio, or the environment that was asked for, by a camera that fathom_scene_complete() made. */
fathom_status scene_add_floor(fathom_scene *scene);

/* ---- light ---- */

/* The mean irradiance that even emission, as luminance, brings to what does not shine, by sight alone: an
 * estimate from a few hundred points, without shadows. 0 where nothing shines but by images. INFINITY where
 * something shines and there is a plane: its mean has no bound, and files of models have none. */
fathom_status scene_measure_lamps(const fathom_scene *scene, double *out);

/* The luminance of the built-in studio (light/studio.h), the mean of all directions. */
#define STUDIO_LUMINANCE 0.696
/* Lamps that light the scene by themselves bring at least this share of what the studio would. */
#define LAMPS_SHARE (1.0 / 16)

/* ---- the shape of images ---- */

typedef struct image_size {
    uint32_t width, height;
} image_size;

/* The size of the image that the scene is read for: the one asked for, else the settings'. */
image_size scene_image_size(const fathom_scene *scene);

/* Gives the image the shape of a camera of this width over height, > 0: the length that is given stays, and
 * nothing changes where both are. Where none is, the longer side stays what the longer one was. */
void image_size_follow(fathom_settings *settings, double aspect, bool has_width, bool has_height);

/* Warns where the image that the scene is read for has another shape than its camera: it is stretched, or
 * shows less than the camera does. */
void scene_warn_shape(const fathom_scene *scene, const char *path);

#endif
