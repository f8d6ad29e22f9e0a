/* Loading fathom_image.so and the libraries that it needs. */
#ifndef IMAGE_MODULE_OPEN_H
#define IMAGE_MODULE_OPEN_H

#include "image/module/module.h"
#include "image/module_find.h"

#include <stdatomic.h>

/* Finds the module and loads it, on the calling thread; NULL with a reason. Gives up between two libraries
 * once `closing` is set. */
const image_module *module_open(const atomic_bool *closing, module_trouble *why);

/* For image_is_loading_here(): the calling thread does what the loading of a library may do. */
void module_loading_here(bool is);

#endif
