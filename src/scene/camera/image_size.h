/* The size of images, and the shape that cameras are made for. */
#ifndef SCENE_IMAGE_SIZE_H
#define SCENE_IMAGE_SIZE_H

#include "scene/scene.h"

typedef struct image_size {
    uint32_t width, height;
} image_size;

/* Of the image that the scene is read for: what was asked for, else the settings'. */
image_size scene_image_size(const fathom_scene *scene);

/* Gives the image the shape of a camera of this width over height, > 0: the length that is given stays, and
 * nothing changes where both are. Where none is, the longer side stays what the longer one was. */
void image_size_follow(fathom_settings *settings, double aspect, bool has_width, bool has_height);

/* Warns where the image that the scene is read for has another shape than its camera: it is stretched, or
 * shows less than the camera does. */
void scene_warn_shape(const fathom_scene *scene, const char *path);

#endif
