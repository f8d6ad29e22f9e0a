/* The cameras of files that have several. */
#ifndef SCENE_CAMERAS_H
#define SCENE_CAMERAS_H

#include "scene/scene.h"

/* Adds to scene->cameras. The names are copied; NULL: none. */
fathom_status scene_note_camera(fathom_scene *scene, const char *name, const char *own_name,
                                bool orthographic);

/* Sets scene->camera_taken to the camera that was asked for, else to the first perspective one; FATHOM_NONE
 * when there is none. Warns of the others where none was asked for. FATHOM_BAD_USAGE, with a list, when there
 * is no such camera, when several have the name, and when it is orthographic. */
fathom_status scene_choose_camera(fathom_scene *scene, const char *path);

#endif
