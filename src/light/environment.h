/* Light from all around, by an equirectangular image: its texels are patches of the sky of constant radiance.
 * So the density of a direction is exactly in proportion to what comes from there. */
#ifndef LIGHT_ENVIRONMENT_H
#define LIGHT_ENVIRONMENT_H

#include "base/status.h"
#include "math/vec.h"

#include <fathom/scene.h>

typedef struct environment environment;

/* FATHOM_BAD_INPUT, with file and texel, when the image cannot be read, has no colours or is not linear, or
 * holds a NaN or an infinity. Negative texels count as 0, with a warning. Release with environment_destroy().
 */
fathom_status environment_create(fathom_context *context, const fathom_light *light, environment **out);
/* The built-in studio (studio.h), for a viewer who looks along -z of these axes; `up` is a unit vector. */
fathom_status environment_studio(fathom_context *context, vec3_f64 z, vec3_f64 up, environment **out);
void environment_destroy(environment *e);

/* Luminance times solid angle, over all directions. */
double environment_power(const environment *e);
/* The largest of each channel. */
void environment_brightest(const environment *e, float out[3]);

/* Radiance from a unit direction, and the density with which it is sampled. */
double environment_at(const environment *e, vec3_f64 direction, float radiance[3]);

/* u chooses along the image's rows, v among them; both in [0,1). Some texel must shine. */
vec3_f64 environment_sample(const environment *e, double u, double v);

#endif
