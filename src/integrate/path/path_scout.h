/* A few paths that run before the image, to find what the scene hides of its lights. */
#pragma once

#include "integrate/plan.h"

/* Tells the plan's emitters; everything else in the plan must be set. The paths depend on the scene, the
 * whole image, its number of samples and the seed alone. They end early if *stop becomes true. */
fathom_status path_scout_lights(fathom_context *context, render_plan *plan, const atomic_bool *stop);
