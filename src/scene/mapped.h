/* A textured material as one without textures, for decisions about the whole surface before any lookup. */
#pragma once

#include <fathom/scene.h>

/* *out reflects, transmits and emits light in every way in which some point of the textured surface does.
 * Each number that an image changes gets a value inside its range, not an end at which a lobe vanishes. An
 * image multiplies a number, or raises it towards 1 (fathom_map.inverted). Without images, *out is the
 * material itself. */
void mapped_between(const fathom_material *material, fathom_material *out);
/* The same by the classic model. */
void mapped_between_classic(const fathom_material *material, fathom_material *out);
