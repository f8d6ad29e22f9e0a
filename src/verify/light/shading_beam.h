/* One path in double, and how far the renderer's, in float, may be from it.
 *
 * `aside` bounds the distance between the two lines at right angles to them: how far apart they meet a
 * surface at a slant does not grow it, as the line that leaves is as near again. `turned` bounds the
 * difference of the unit directions. Both count to first order in u = 2^-24. */
#ifndef EXTREMES_SHADING_BEAM_H
#define EXTREMES_SHADING_BEAM_H

#include "math/vec.h"

typedef struct beam {
    vec3_f64 at, along; /* unit */
    double aside, turned;
} beam;

/* A camera's ray: each part of its direction is rounded once. */
beam beam_start(vec3_f64 eye, vec3_f64 direction);

/* To distance t, onto a surface whose coordinates are below `size`. The point found is recomputed from the
 * primitive and the next ray begins beside it. */
void beam_go(beam *b, double t, double size);

/* Mirrored about the unit normal, itself known to `normal_error`. */
void beam_mirror(beam *b, vec3_f64 normal, double normal_error);

/* Refracted by Snell's law with eta = n1/n2 about the unit normal against the beam. False on total internal
 * reflection: nothing has changed then. */
bool beam_bend(beam *b, vec3_f64 normal, double normal_error, double eta);
/* How near the square of Snell's cosine is to zero, in units of what float may be wrong by: below 1 in size,
 * either answer is right. */
double beam_doubt(const beam *b, vec3_f64 normal, double normal_error, double eta);

/* A Lambert surface of albedo 1 as a ruler: what a point light of intensity 1 at height h over the plane, and
 * at the distance r from the point, makes of it is h / r^3; and the bound of its error where the beam lands
 * under the angle with this cosine. */
double beam_radiance(const beam *b, vec3_f64 light, vec3_f64 normal, double size, double *bound);

#endif
