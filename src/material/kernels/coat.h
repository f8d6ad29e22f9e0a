/* The clear coat. */
#ifndef MATERIAL_KERNELS_COAT_H
#define MATERIAL_KERNELS_COAT_H

#include "material/kernels/facets.h"

/* The light that passes the clear coat twice, and the light that it reflects. */
static inline void add_coat(const shader_block *b, const incidence *at, const lanes3 h,
                            const float rise[LANES], float (*restrict f)[LANES], float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float d, value = mirrored_facets(b, b->coat_alpha[i], i, at->l, h, &d);
        uint32_t open = at->reflected[i] & (b->at[i]->lobes & SHADER_COAT ? ~0u : 0);
        value = chosen(open, value * b->coat[i] * (0.04f + 0.96f * rise[i]), 0);
        for (int c = 0; c < 3; ++c) f[c][i] = f[c][i] * (b->below_coat[i] * at->below_coat[i]) + value;
        density[i] += chosen(open, b->take[SHADER_TAKE_COAT][i] * d, 0);
    }
}

#endif
