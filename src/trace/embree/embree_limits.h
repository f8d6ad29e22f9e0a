/* Limits of Embree, checked before anything is built: the range of coordinates, and memory. */
#ifndef TRACE_EMBREE_LIMITS_H
#define TRACE_EMBREE_LIMITS_H

#include "scene/world/world.h"

/* ---- memory ---- */

typedef struct trace_need {
    double kept;   /* bytes of Embree's finished structure, beyond the meshes themselves */
    double passed; /* held in addition while it is built */
} trace_need;

/* Within a fifth for meshes of a million triangles and more. */
trace_need trace_need_of(const world *w, bool compact);

/* ---- range ---- */

/* Embree drops primitives whose coordinates are not below this; half of it leaves room for sums. */
#define REACH_LARGEST 1.844e18f

/* The largest coordinates of rays, as magnitudes. */
typedef struct trace_reach {
    float origin, direction;
} trace_reach;

bool reach_usable(vec3_f32 p);

/* A flag for each group that is placed and holds something that can be hit; set for the root. Release with
 * free(). NULL when out of memory. */
bool *reach_placed(const world *w);

/* FATHOM_BAD_INPUT where an instance takes rays out of the range, or has a frame that Embree cannot invert in
 * float; warns of instances too far out to be seen. placed: from reach_placed(). */
fathom_status reach_find(fathom_context *context, const world *w, const bool *placed, trace_reach *out);

/* The same check without building anything. */
fathom_status reach_check(fathom_context *context, const world *w);

#endif
