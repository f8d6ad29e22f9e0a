/* Reflectances of thin films, from the curves of their materials. */
#ifndef MATERIAL_KERNELS_FILM_H
#define MATERIAL_KERNELS_FILM_H

#include "material/kernels/incidence.h"

/* The cosine outside the film's solid: in the thinner medium, as in schlick(). */
static inline float film_cosine(float cosine, float eta) {
    float near = cosine < 1 ? (cosine > 0 ? cosine : 0) : 1;
    float far2 = 1 - (1 - near) * (1 + near) / (eta * eta);
    return eta < 1 ? sqrtf(far2 > 0 ? far2 : 0) : near;
}

/* c: a channel, or 3 for the fraction that does not reach the base. */
static inline float film_at(const shader_block *b, int i, int c, float cosine) {
    float x = sqrtf(film_cosine(cosine, b->eta[i])) * FILM_STEPS;
    int k = (int)x < FILM_STEPS - 1 ? (int)x : FILM_STEPS - 1;
    const float *curve = b->at[i]->film[c] + k, t = x - (float)k;
    /* Catmull and Rom's cubic; past the ends, the curve is continued linearly. */
    float before = k > 0 ? curve[-1] : 2 * curve[0] - curve[1];
    float after = k < FILM_STEPS - 1 ? curve[2] : 2 * curve[1] - curve[0];
    float first = curve[1] - before, third = 3 * (curve[0] - curve[1]) + after - before;
    float value =
        curve[0] + 0.5f * t * (first + t * (2 * before - 5 * curve[0] + 4 * curve[1] - after + t * third));
    return value < 1 ? (value > 0 ? value : 0) : 1;
}

/* The film's value in lanes with a film, else `plain`. rare: some lane may have a film. */
static inline __attribute__((always_inline)) float film_or(const shader_block *b, bool rare, int i, int c,
                                                           float cosine, float plain) {
    return rare && b->at[i]->lobes & SHADER_FILM ? film_at(b, i, c, cosine) : plain;
}

/* The reflectance of metal and dielectric together, at this cosine; rise: the dielectric's Schlick factor
 * there. f0 and f90: without a film. */
static inline __attribute__((always_inline)) float reflectance_at(const shader_block *b, bool rare, int i,
                                                                  int c, float cosine, float rise, float f0,
                                                                  float f90) {
    float plain = f0 + (f90 - f0) * rise;
    if (rare && b->at[i]->lobes & SHADER_INNER_METAL) {
        plain += b->at[i]->metal_rise[c] * (power5(1 - fminf(cosine, 1)) - rise);
        plain = plain > 0 ? plain : 0; /* rounding may leave less than 0 */
    }
    return film_or(b, rare, i, c, cosine, plain);
}

/* The fraction of light that the layer keeps from the base, at this cosine; rise: its Schlick factor. */
static inline __attribute__((always_inline)) float layer_of(const shader_block *b, bool rare, int i,
                                                            float cosine, float rise) {
    return film_or(b, rare, i, 3, cosine, layer_share(b, i, rise));
}

#endif
