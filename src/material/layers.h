/* Layers of metallicRoughness whose preparation computes curves: fibres and thin films. */
#ifndef MATERIAL_LAYERS_H
#define MATERIAL_LAYERS_H

#include "material/shader.h"

/* Sets the members for SHADER_SHEEN. sheen_color must not be black. */
void prepare_sheen(const fathom_material *m, shader *out);

/* Sets the members for SHADER_FILM, and sets layer0 and layer90 to a Schlick reflectance that is at no
 * angle below the film's. layer: F0 of the dielectric. Call this once f0, f90 and the layer of the surface
 * without a film are set, and before opacity is applied. */
void prepare_film(const fathom_material *m, const float layer[3], shader *out);
/* The mean over a hemisphere, weighted by the cosine. */
float film_mean(const float curve[FILM_STEPS + 1]);

#endif
