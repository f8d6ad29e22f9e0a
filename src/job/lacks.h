/* Warnings before a render: parts of the scene that the image will not show, or will show wrongly. */
#pragma once

#include "scene/world/world.h"

enum { LACKS_MOST = 8 };
/* Calls tell() with each sentence, of fewer than PARTS_TEXT bytes; at most LACKS_MOST times. */
void lacks_find(const world *w, fathom_integrator integrator, void (*tell)(void *user, const char *text),
                void *user);
