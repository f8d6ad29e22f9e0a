/* Light from all directions, given by an equirectangular image; see sky.h. */
#pragma once

#include "base/status.h"
#include "light/sky.h"

#include <fathom/scene.h>

typedef struct environment environment;

/* Returns FATHOM_BAD_INPUT, with file and texel, if the image cannot be read, has no colour channels, is not
 * linear or holds a NaN or an infinity. Negative texels become 0, with a warning. Release with
 * environment_destroy(). */
fathom_status environment_create(fathom_context *context, const fathom_light *light, environment **out);
/* The same for an environment of the scene; a message also has the place in the scene's file. */
fathom_status environment_open(fathom_context *context, const fathom_scene *scene, fathom_id id,
                               environment **out);
/* Reads all environments, because some faults are only in texels. FATHOM_BAD_INPUT as environment_open(). */
fathom_status environment_check(fathom_context *context, const fathom_scene *scene);
/* The bytes that environment_open() takes at most, for all environments of the scene, by the headers of their
 * images. FATHOM_BAD_INPUT as environment_open(), if a name or header shows it. */
fathom_status environment_measure(fathom_context *context, const fathom_scene *scene, uint64_t *bytes);
/* The built-in studio (studio.h), for a camera that looks along -z; `up` is a unit vector. */
fathom_status environment_studio(fathom_context *context, vec3_f64 z, vec3_f64 up, environment **out);
/* The same radiance from all directions. */
fathom_status environment_even(fathom_context *context, const float radiance[3], environment **out);
void environment_destroy(environment *e);

/* The image itself; valid as long as the environment. */
const sky_image *environment_sky(const environment *e);

/* Luminance times solid angle, over all directions. */
double environment_power(const environment *e);
/* The maximum of each channel. */
void environment_brightest(const environment *e, float out[3]);

/* As sky_learn(). */
bool environment_learn(environment *e, const sky_ray *rays, size_t count);

/* Radiance from unit directions, and their densities for surfaces at p with the normals n (unit or 0). lanes:
 * bits; other lanes are not written. */
void environment_at(const environment *e, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                    const lanes3_f64 direction, sky_light *out);
/* Radiance from one direction, without a density. */
void environment_radiance(const environment *e, vec3_f64 direction, float radiance[3]);

/* Samples directions for surfaces at p with the normals n; 0: no preferred side. u chooses along the image's
 * rows, v between rows; both in [0,1). Some texel must not be black. *out is for the sampled direction;
 * density 0: there is no light on that side. A direction stays in its cell when it is rounded to float,
 * except close to the poles, where it may leave the cell by about 1e-7. */
void environment_sample(const environment *e, unsigned lanes, const lanes3 p, const lanes3_f64 n,
                        const float u[LANES], const float v[LANES], lanes3_f64 direction, sky_light *out);

/* Reads the image alone: sets *out to width, height and texels of an equirectangular image, times the light's
 * intensity; everything else is 0. The caller frees the texels. The light's file is such an image, or holds
 * the faces of a cube (cube.h), or names six files of them (base/file.h). Negative texels count as 0, with a
 * warning. FATHOM_BAD_INPUT, with the file: it cannot be read, has no colours or is not linear; or with the
 * texel: a NaN or an infinity. */
fathom_status environment_read(fathom_context *context, const fathom_light *light, sky_image *out);
