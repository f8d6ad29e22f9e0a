/* Light from all around, by an equirectangular image; see sky.h. */
#ifndef LIGHT_ENVIRONMENT_H
#define LIGHT_ENVIRONMENT_H

#include "base/status.h"
#include "light/sky.h"

#include <fathom/scene.h>

typedef struct environment environment;

/* FATHOM_BAD_INPUT, with file and texel, when the image cannot be read, has no colours or is not linear, or
 * holds a NaN or an infinity. Negative texels count as 0, with a warning. Release with environment_destroy().
 */
fathom_status environment_create(fathom_context *context, const fathom_light *light, environment **out);
/* The built-in studio (studio.h), for a viewer who looks along -z of these axes; `up` is a unit vector. */
fathom_status environment_studio(fathom_context *context, vec3_f64 z, vec3_f64 up, environment **out);
void environment_destroy(environment *e);

/* The image itself; lives as long as the environment. */
const sky_image *environment_sky(const environment *e);

/* Luminance times solid angle, over all directions. */
double environment_power(const environment *e);
/* The largest of each channel. */
void environment_brightest(const environment *e, float out[3]);

/* Radiance from unit directions, as surfaces with the normals n, unit or 0, ask for them. lanes: bits; others
 * are left. */
void environment_at(const environment *e, unsigned lanes, const lanes3_f64 n, const lanes3_f64 direction,
                    sky_light *out);
/* From one, for whoever asks for no density. */
void environment_radiance(const environment *e, vec3_f64 direction, float radiance[3]);

/* Directions for surfaces with the normals n; 0: all directions alike. u chooses along the image's rows, v
 * among them; both in [0,1). Some texel must shine. *out is of the place chosen; density 0: none shines on
 * that side. A direction stays in its cell when it is rounded to float; close to the poles it may leave it by
 * some 1e-7. */
void environment_sample(const environment *e, unsigned lanes, const lanes3_f64 n, const double u[LANES],
                        const double v[LANES], lanes3_f64 direction, sky_light *out);

#endif
