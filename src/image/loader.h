/* Finding and loading fathom_image.so. */
#ifndef IMAGE_LOADER_H
#define IMAGE_LOADER_H

#include "image/module/module.h"

/* The module, loaded on the first call; waits for a load that is under way. Any thread. It is never unloaded.
 * FATHOM_INTERNAL names what was tried; FATHOM_OUT_OF_RESOURCES: memory or descriptors ran out. */
fathom_status loader_module(fathom_context *context, const image_module **out);

/* The module if it is loaded, else NULL. Whoever holds something of the module's can count on it. */
const image_module *loader_loaded(void);

/* Whether there is a module to load, without loading it. */
fathom_status loader_find(fathom_context *context);

#endif
