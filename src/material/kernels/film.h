/* Reflectances of thin films, from the curves of their materials. */
#ifndef MATERIAL_KERNELS_FILM_H
#define MATERIAL_KERNELS_FILM_H

#include "material/kernels/incidence.h"

/* The angle outside of the film's solid: of the thinner medium, as in schlick(). */
static inline float film_cosine(float cosine, float eta) {
    float near = cosine < 1 ? (cosine > 0 ? cosine : 0) : 1;
    float far2 = 1 - (1 - near) * (1 + near) / (eta * eta);
    return eta < 1 ? sqrtf(far2 > 0 ? far2 : 0) : near;
}

/* c: a channel, or 3 for what does not reach the base. */
static inline float film_at(const shader_block *b, int i, int c, float cosine) {
    float x = sqrtf(film_cosine(cosine, b->eta[i])) * FILM_STEPS;
    int k = (int)x < FILM_STEPS - 1 ? (int)x : FILM_STEPS - 1;
    const float *curve = b->at[i]->film[c];
    return curve[k] + (x - (float)k) * (curve[k + 1] - curve[k]);
}

/* `plain`, unless the lane has a film. rare: some may have. */
static inline float film_or(const shader_block *b, bool rare, int i, int c, float cosine, float plain) {
    return rare && b->at[i]->lobes & SHADER_FILM ? film_at(b, i, c, cosine) : plain;
}

/* What the layer takes from the base, at this cosine and Schlick's factor of it. */
static inline float layer_of(const shader_block *b, bool rare, int i, float cosine, float rise) {
    return film_or(b, rare, i, 3, cosine, layer_share(b, i, rise));
}

#endif
