/* The built-in studio, which lights models that bring no light. */
#ifndef LIGHT_STUDIO_H
#define LIGHT_STUDIO_H

#include "math/vec.h"

/* Radiance from a unit direction. y is up, and the viewer stands towards z; x is the viewer's right. */
void studio_radiance(vec3_f64 direction, float radiance[3]);

#endif
