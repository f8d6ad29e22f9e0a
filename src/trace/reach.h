/* What Embree's range of numbers leaves of a world, known before anything is built. */
#ifndef TRACE_REACH_H
#define TRACE_REACH_H

#include "scene/world/world.h"

/* Embree drops primitives whose coordinates are not below this; half of it leaves room for sums. */
#define REACH_LARGEST 1.844e18f

/* What the coordinates of rays may be, as magnitudes. */
typedef struct trace_reach {
    float origin, direction;
} trace_reach;

bool reach_usable(vec3_f32 p);

/* A point of something in the geometry that can be hit; false: nothing can be. */
bool reach_point(const world *w, const world_geometry *geometry, vec3_f32 *out);

/* Which groups are placed and hold something that can be hit, a flag each, to be freed; the root always does.
 * NULL when out of memory. */
bool *reach_placed(const world *w);

/* FATHOM_BAD_INPUT where an instance takes rays that the scene needs out of the range, or has a frame that
 * Embree cannot invert in float; a warning where instances are too far out to be seen. placed: from
 * reach_placed(). */
fathom_status reach_find(fathom_context *context, const world *w, const bool *placed, trace_reach *out);

/* The same check for those who build nothing: what building the world with Embree would say. */
fathom_status reach_check(fathom_context *context, const world *w);

#endif
