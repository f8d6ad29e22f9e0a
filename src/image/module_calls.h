/* The module's calls, which return where its libraries end the process. */
#ifndef IMAGE_MODULE_CALLS_H
#define IMAGE_MODULE_CALLS_H

#include "image/module/module.h"

/* The same calls as the module's own. One that faults, traps or calls abort() fails as
 * image_call_failed_here() says, where the process's handler of such signals calls that; after it all others
 * fail too, and what the libraries hold is left to them, since nobody knows in what state they are. Valid as
 * long as the module; of one module. */
const image_module *module_calls(const image_module *module);

#endif
