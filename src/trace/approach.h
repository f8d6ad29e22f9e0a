/* Where rays from far away start. Rounding a ray to float moves its line by up to 2^-24 of the distance from
 * its start, so a ray whose origin is far from the scene is traced from a point just before the scene. */
#pragma once

#include "scene/world/world.h"

typedef struct trace_approach {
    const world *world;
    vec3_f64 center; /* of everything but planes, in the world's coordinates */
    double radius;   /* infinite: there are only planes */
} trace_approach;

/* The world must outlive the result. Fails only if out of memory. */
fathom_status trace_approach_find(const world *w, trace_approach *out);
/* The point is so far away that rays from it to the scene start elsewhere. */
bool trace_approach_is_far(const trace_approach *a, vec3_f64 org);
/* The t at which the ray org + t dir should start: no surface lies between `least` and there. `least` if the
 * origin is not far away. least <= 0. dir need not be unit. */
double trace_approach_start(const trace_approach *a, vec3_f64 org, vec3_f64 dir, double least);
