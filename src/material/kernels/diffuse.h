/* Lambert's lobes, on both sides. */
#pragma once

#include "material/kernels/facets.h"

/* |cosine| / pi in lanes where `lit` is set, else 0. */
static inline float lambert(uint32_t lit, float z) { return chosen(lit, fabsf(z) * (1 / PI), 0); }

static inline float cosine_density(float take, float z) { return take * fabsf(z) * (1 / PI); }

/* Lambert's lobe, multiplied by the light that the dielectric layer transmits. */
static inline __attribute__((always_inline)) void add_diffuse(const shader_block *b, bool rare,
                                                              const incidence *at, const lanes3 h,
                                                              const float rise[LANES],
                                                              float (*restrict f)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        uint32_t lit = at->reflected[i] | (at->cross[i] & b->from_behind[i]);
        float cosine = lambert(lit, at->cosine[i]);
        for (int c = 0; c < 3; ++c) {
            float under = b->under[i] * at->under[i];
            if (is_under_film(b, rare, i)) under = film_through(b, at, i, c);
            float left = chosen(b->even[i], under, 1 - layer_of(b, rare, i, c, along_half(b, h, i), rise[i]));
            f[c][i] += b->diffuse[c][i] * left * cosine;
        }
    }
}

/* The same for light that crosses the surface: the layer's factor is that of l mirrored to the viewer's
 * side. */
static inline void add_leaf(const shader_block *b, const incidence *at, float (*restrict f)[LANES]) {
    lanes3 l, h;
    float rise[LANES];
    set_mirrored(b, at, l, h, rise);
    for (int i = 0; i < LANES; ++i) {
        const shader *m = b->at[i];
        if (!(m->lobes & SHADER_LEAF)) continue;
        for (int c = 0; c < 3; ++c) {
            float once = m->mean_under * (1 - layer_of(b, true, i, c, along_half(b, h, i), rise[i]));
            float under = b->under[i] * at->under[i];
            if (is_under_film(b, true, i)) under = film_through(b, at, i, c);
            float left = chosen(b->even[i] & ~b->inside[i], under, once);
            float value = lambert(at->cross[i], left * at->cosine[i]);
            f[c][i] += m->leaf[c] * value;
        }
    }
}

static inline void add_cosines(const shader_block *b, const incidence *at, float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float take = chosen(at->reflected[i], b->take[SHADER_TAKE_DIFFUSE][i],
                            chosen(at->cross[i], b->take[SHADER_TAKE_BEHIND][i], 0));
        density[i] += cosine_density(take, at->l[2][i]);
    }
}
