/* The clear coat. */
#pragma once

#include "material/kernels/facets.h"
#include "material/kernels/glass.h"

/* From the block's frame to the coat's. */
static inline void into_coat(const shader_block *b, const lanes3 from, float (*restrict to)[LANES]) {
    for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < LANES; ++i) {
            const lanes3 *axis = &b->coat_axes[k];
            to[k][i] = (*axis)[0][i] * from[0][i] + (*axis)[1][i] * from[1][i] + (*axis)[2][i] * from[2][i];
        }
    }
}

static inline void out_of_coat(const shader_block *b, const lanes3 from, float (*restrict to)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i)
            to[c][i] = b->coat_axes[0][c][i] * from[0][i] + b->coat_axes[1][c][i] * from[1][i] +
                       b->coat_axes[2][c][i] * from[2][i];
    }
}

/* Multiplies f by the clear coat's transmittance in both directions, and adds the light that the coat
 * reflects; v, l and h in the coat's frame. front: all ones if l is on the viewer's side of the surface below
 * the coat. */
static inline void add_coat_as(const shader_block *b, incidence *at, const uint32_t front[LANES],
                               const lanes3 v, const lanes3 l, const lanes3 h, const float below[LANES],
                               const float rise[LANES], float (*restrict f)[LANES], float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float d, value = mirrored_facets(v, b->coat_alpha[i], i, l, h, &d);
        uint32_t open = front[i] & (b->at[i]->lobes & SHADER_COAT ? ~0u : 0) & (l[2][i] > 0 ? ~0u : 0);
        at->coated[i] = open;
        value = chosen(open, value * b->coat[i] * (0.04f + 0.96f * rise[i]), 0);
        for (int c = 0; c < 3; ++c) f[c][i] = f[c][i] * (b->below_coat[i] * below[i]) + value;
        density[i] += chosen(open, b->take[SHADER_TAKE_COAT][i] * d, 0);
    }
}

/* For a coat with its own normal, the normal of the surface below does not count: a map may have rotated
 * it. */
static inline void judge_coats(const surface_block *s, const lanes3 l, const incidence *at,
                               uint32_t front[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        const bool above = dot_lane(s->ng, l, i) > 0 && dot_lane(s->base, l, i) > 0;
        front[i] = s->coated >> i & 1 ? (above ? ~0u : 0) : at->reflected[i];
    }
}

/* l: in world space. */
static inline void add_coat(const surface_block *s, const shader_block *b, incidence *at, const lanes3 l,
                            const lanes3 h, const float rise[LANES], float (*restrict f)[LANES],
                            float *restrict density) {
    lanes3 own_l, own_h;
    float below[LANES];
    uint32_t front[LANES];
    if (!(b->lobes & SHADER_TURNED)) {
        add_coat_as(b, at, at->reflected, b->v, at->l, h, at->below_coat, rise, f, density);
        return;
    }
    judge_coats(s, l, at, front);
    into_coat(b, at->l, own_l);
    into_coat(b, h, own_h);
    for (int i = 0; i < LANES; ++i) below[i] = below_coat_at(b->at[i], own_l[2][i]);
    add_coat_as(b, at, front, b->coat_v, own_l, own_h, below, rise, f, density);
}
