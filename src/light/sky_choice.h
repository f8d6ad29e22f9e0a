/* Which texel of an image of the sky a surface asks for: by the light that comes from there, times about the
 * cosine to the surface's normal. */
#ifndef LIGHT_SKY_CHOICE_H
#define LIGHT_SKY_CHOICE_H

#include "math/lanes.h"
#include "math/vec.h"

#include <stdint.h>

typedef struct sky_choice sky_choice;

/* Takes an equirectangular image whose first row is around +y, and whose centre lies towards -z. radiance: of
 * its texels, by row; neither negative nor infinite. NULL: out of memory. */
sky_choice *sky_choice_create(uint32_t width, uint32_t height, const float (*radiance)[3]);
void sky_choice_destroy(sky_choice *c);

/* Luminance times solid angle of all texels. */
double sky_choice_power(const sky_choice *c);

/* A texel a lane. */
typedef struct sky_texels {
    uint32_t column[LANES], row[LANES];
} sky_texels;

/* Texels for the unit normals of `lanes`, or for all directions alike where n is 0. u chooses along the rows,
 * v among them, both in [0,1); they come to be places in the texel. Texels without light are never chosen.
 * Returns the lanes that have one: others face no light. */
unsigned sky_choice_take(const sky_choice *c, unsigned lanes, const lanes3_f64 n, double u[LANES],
                         double v[LANES], sky_texels *out);

/* The densities per solid angle, over the texels' luminance, with which they are taken. */
void sky_choice_densities(const sky_choice *c, unsigned lanes, const lanes3_f64 n, const sky_texels *texels,
                          double density[LANES]);

double sky_luminance(const float rgb[3]);
/* The direction of the place (u, v) in [0,1]² of the image. */
vec3_f64 sky_direction(double u, double v);

#endif
