/* What the image helper does for this process, as plain calls. */
#ifndef IMAGE_LOADER_H
#define IMAGE_LOADER_H

#include "image/helper/module.h"

/* The calls of helper/module.h, each made in the helper; any thread. A call that the helper does not survive
 * fails with FATHOM_OUT_OF_RESOURCES, and so does each later one on what was open then. */
extern const image_module image_calls;

/* FATHOM_OUT_OF_RESOURCES when the helper's program is not there, with a message. Starts nothing. */
fathom_status loader_find(fathom_context *context);

#endif
