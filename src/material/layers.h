/* Layers of metallicRoughness that are prepared by curves: fibres and thin films. */
#ifndef MATERIAL_LAYERS_H
#define MATERIAL_LAYERS_H

#include "material/shader.h"

/* Sets the parts of SHADER_SHEEN. sheen_color is not black. */
void prepare_sheen(const fathom_material *m, shader *out);

/* Sets the parts of SHADER_FILM, and makes layer0 and layer90 those of a Schlick's reflectance that is
 * nowhere below the film's. layer: F0 of the dielectric. Call once f0, f90 and the layer of the surface
 * without a film are set, and before opacity counts. */
void prepare_film(const fathom_material *m, const float layer[3], shader *out);
/* The mean over a hemisphere, weighted by the cosine. */
float film_mean(const float curve[FILM_STEPS + 1]);

#endif
