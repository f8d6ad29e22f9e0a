/* Limits of Embree, checked before anything is built: the range of coordinates, and memory. */
#pragma once

#include "scene/world/world.h"

/* ---- memory ---- */

typedef struct trace_need {
    double kept;   /* bytes of Embree's finished structure, beyond the meshes themselves */
    double passed; /* additional bytes during the build */
} trace_need;

/* Accurate to a fifth for meshes of a million triangles and more. */
trace_need trace_need_of(const world *w, bool compact);

/* ---- range ---- */

/* Embree drops primitives with coordinates not below this limit. We use half of it, to leave room for
 * sums. */
#define REACH_LARGEST 1.844e18f

/* The largest coordinates of rays, as magnitudes. Longer directions are scaled: see stretch.h. */
typedef struct trace_reach {
    float origin, direction;
} trace_reach;

bool reach_usable(vec3_f32 p);

/* One flag per group: the group is used by the root or by an instance, and contains something that can be
 * hit. Always set for the root. Release with free(). NULL when out of memory. */
bool *reach_placed(const world *w);

/* FATHOM_BAD_INPUT if an instance moves rays out of the range, or its transform cannot be inverted in float.
 * Warns of instances that Embree leaves out because they are too far away. placed: from reach_placed(). */
fathom_status reach_find(fathom_context *context, const world *w, const bool *placed, trace_reach *out);

/* The same check without building anything. */
fathom_status reach_check(fathom_context *context, const world *w);
