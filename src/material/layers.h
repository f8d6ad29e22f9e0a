/* Layers of metallicRoughness whose preparation computes curves: fibres and thin films. */
#pragma once

#include "material/shader.h"

#include <math.h>

/* Sets the members for SHADER_SHEEN. sheen_color must not be black. */
void prepare_sheen(const fathom_material *m, shader *out);

/* Cosine-weighted means over the hemisphere: the reflectances of dielectric and metal under a film, and the
 * fraction that does not reach the base. */
typedef struct film_means {
    float dielectric[3], metal[3], kept[3];
} film_means;
/* Sets the members for SHADER_FILM, and sets layer0 and layer90 to a Schlick reflectance close to the film's.
 * layer: F0 of the dielectric. Call this once f0, f90 and the layer of the surface without a film are set,
 * and before opacity is applied. */
void prepare_film(const fathom_material *m, const float layer[3], shader *out, film_means *means);
/* Sets the members for SHADER_FILM with SHADER_EVEN, except for film_lift. mean: of the facets' albedo. */
void prepare_film_base(const film_means *means, float mean, shader *out);
/* The fraction of a channel's light that the layer transmits to the base, from its facets' albedos at a
 * cosine. rest: film_rest at this cosine. */
static inline float film_under(const shader *m, int c, float all, float edge, float rest) {
    const float under =
        1 - (m->film_low[c] * (all - edge) + m->film_high * edge + m->film_again[c] * (1 - all) + rest);
    return under > 0 ? under : 0;
}
/* The value of a curve of a film at a cosine in [0, 1], without bounds. */
static inline float film_read(const float curve[FILM_STEPS + 1], float cosine) {
    float x = sqrtf(cosine) * FILM_STEPS;
    int k = (int)x < FILM_STEPS - 1 ? (int)x : FILM_STEPS - 1;
    const float *from = curve + k, t = x - (float)k;
    /* Catmull and Rom's cubic; past the ends, the curve is continued linearly. */
    float before = k > 0 ? from[-1] : 2 * from[0] - from[1];
    float after = k < FILM_STEPS - 1 ? from[2] : 2 * from[1] - from[0];
    float first = from[1] - before, third = 3 * (from[0] - from[1]) + after - before;
    return from[0] + 0.5f * t * (first + t * (2 * before - 5 * from[0] + 4 * from[1] - after + t * third));
}
