/* The built-in studio, which lights models that have no light of their own. */
#pragma once

#include "math/vec.h"

#define STUDIO_PANELS 4

/* A light panel seen from the model; the panel is dark wherever the cosine to its centre is at most
 * `least`. */
typedef struct studio_panel {
    vec3_f64 centre, across, rise;
    double least;
} studio_panel;

typedef struct studio {
    studio_panel panels[STUDIO_PANELS];
} studio;

void studio_open(studio *out);
/* Radiance from a unit direction. y is up, and the viewer stands towards z; x is the viewer's right. */
void studio_radiance(const studio *s, vec3_f64 direction, float radiance[3]);
