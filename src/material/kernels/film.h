/* Reflectances of thin films, from the curves of their materials. */
#pragma once

#include "material/kernels/incidence.h"
#include "material/layers.h"
#include "math/limit.h"

/* The cosine outside the film's solid: in the thinner medium, as in schlick(). */
static inline float film_cosine(float cosine, float eta) {
    float near = cosine < 1 ? (cosine > 0 ? cosine : 0) : 1;
    float far2 = 1 - (1 - near) * (1 + near) / (eta * eta);
    return eta < 1 ? sqrtf(far2 > 0 ? far2 : 0) : near;
}

static inline float film_at(const shader_block *b, int i, const float curve[FILM_STEPS + 1], float cosine) {
    const float value = film_read(curve, film_cosine(cosine, b->eta[i]));
    return value < 1 ? (value > 0 ? value : 0) : 1;
}

static inline __attribute__((always_inline)) bool is_filmed(const shader_block *b, bool rare, int i) {
    return rare && b->at[i]->lobes & SHADER_FILM;
}

/* The reflectance of metal and dielectric together, at this cosine; rise: the dielectric's Schlick factor
 * there. f0 and f90: without a film. */
static inline __attribute__((always_inline)) float reflectance_at(const shader_block *b, bool rare, int i,
                                                                  int c, float cosine, float rise, float f0,
                                                                  float f90) {
    float plain = f0 + (f90 - f0) * rise;
    if (rare && b->at[i]->lobes & SHADER_INNER_METAL) {
        plain += b->at[i]->metal_rise[c] * (power5(1 - least(cosine, 1)) - rise);
        plain = plain > 0 ? plain : 0; /* rounding may leave less than 0 */
    }
    if (!is_filmed(b, rare, i)) return plain;
    const float film = film_at(b, i, b->at[i]->film[c], cosine);
    if (!b->inside[i]) return film;
    const float base = b->at[i]->base_f90 * film_at(b, i, b->at[i]->film_kept[c], cosine);
    return film > base ? film - base : 0;
}

/* The fraction of a channel's light that the layer keeps from the base, at this cosine; rise: its Schlick
 * factor. */
static inline __attribute__((always_inline)) float layer_of(const shader_block *b, bool rare, int i, int c,
                                                            float cosine, float rise) {
    if (is_filmed(b, rare, i)) return film_at(b, i, b->at[i]->film_kept[c], cosine);
    return layer_share(b, i, rise);
}

/* True if the base lies under a film that is even. */
static inline __attribute__((always_inline)) bool is_under_film(const shader_block *b, bool rare, int i) {
    return is_filmed(b, rare, i) && b->even[i] && !b->inside[i];
}

/* The fraction of a channel's light that reaches the base and leaves it, if it is under a film. */
static inline float film_through(const shader_block *b, const incidence *at, int i, int c) {
    return b->film_under[c][i] * at->film_under[c][i] * b->at[i]->film_lift[c];
}
