/* The integrals behind the tables of albedos: light by visible GGX facets. */
#pragma once

#include "material/energy.h"

/* v: the unit vector to the viewer, v[2] > 0; ax, ay: the alphas of its first two axes. Facets are sampled
 * around v at `around` azimuths: of half a turn if v[1] is 0, because then both halves are equal. */
typedef struct energy_view {
    float ax, ay, v[3];
    int around;
} energy_view;

typedef struct energy_kernels {
    /* The albedo of facets that reflect all light [0], and the same with the factor (1 - v·h)^5 [1]. */
    void (*mirror)(const energy_view *view, float out[2]);
    /* The parts of an albedo f0 [0] + f90 [1] + [2] of facets that reflect and refract, for Schlick's
     * reflectance, with the factor 1 at total reflection. eta: index of the far side divided by that of the
     * viewer's side. */
    void (*glass)(const energy_view *view, float eta, float out[3]);
    /* The albedo by v·h, times `part`: adds to nodes at cosines (k / ENERGY_FACETS_STEPS)^2. */
    void (*facets)(const energy_view *view, float part, float out[ENERGY_FACETS_STEPS + 1]);
} energy_kernels;

const energy_kernels *energy_kernels_best(void);
