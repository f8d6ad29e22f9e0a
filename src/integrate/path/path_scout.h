/* Scout paths: a few paths, traced before the render, find out which light the scene blocks, so that light
 * samples can avoid it. */
#pragma once

#include "integrate/plan.h"

/* Traces scout paths, and passes the results to the plan's emitters; everything else in the plan must be
 * set. The paths depend only on the scene, the whole image, its number of samples and the seed. They end
 * early if *stop becomes true. */
fathom_status path_scout_lights(fathom_context *context, render_plan *plan, const atomic_bool *stop);
