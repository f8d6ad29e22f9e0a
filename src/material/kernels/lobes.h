/* Values and densities of all lobes except the smooth ones, for light from one direction per lane. */
#pragma once

#include "material/kernels/coat.h"
#include "material/kernels/diffuse.h"
#include "material/kernels/highlight.h"
#include "material/kernels/rough_glass.h"
#include "material/kernels/sheen.h"
#include "math/limit.h"

/* Phong's lobe is sampled with the density (n+1)/2pi (r·l)^n about the mirrored viewer, Blinn's with the same
 * density of the half vector, whose solid angle is 1 / (4 v·h) of the direction's. */
static inline void add_highlight(const surface_block *s, const shader_block *b, const incidence *at,
                                 const lanes3 l, const lanes3 h, float (*restrict f)[LANES],
                                 float *restrict density) {
    float rho[LANES] = {0};
    uint32_t phong[LANES];
    for (int i = 0; i < LANES; ++i) phong[i] = ~b->blinn[i];
    highlight(b->n, s->v, phong, b->blinn, b->shininess, l, at->l[2], rho);
    for (int i = 0; i < LANES; ++i) {
        uint32_t lit = at->reflected[i] | (at->cross[i] & b->from_behind[i]);
        float value = chosen(lit, rho[i] * (1 / PI) * fabsf(at->l[2][i]), 0);
        for (int c = 0; c < 3; ++c) f[c][i] += b->highlight[c][i] * value;
        float cosine = b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
        float wide = chosen(b->blinn[i], 4 * (cosine > 0x1p-23f ? cosine : 0x1p-23f), 1);
        float d = rho[i] * (b->shininess[i] + 1) / (2 * PI * wide);
        density[i] += chosen(lit, b->take[SHADER_TAKE_HIGHLIGHT][i] * d, 0);
    }
}

/* ---- all of them ---- */

/* rare: some lane is SHADER_RARE. It is a compile-time constant: blocks without such lanes get simpler
 * loops. */
__attribute__((always_inline)) static inline __attribute__((always_inline)) void
add_lobes_as(const surface_block *s, const shader_block *b, bool rare, const lanes3 l, incidence *at,
             float (*restrict f)[LANES], float *restrict density) {
    lanes3 h = {{0}};
    float rise[LANES] = {0};
    const uint32_t lobes = b->lobes;
    for (int i = 0; i < LANES; ++i) f[0][i] = f[1][i] = f[2][i] = density[i] = 0;
    for (int i = 0; i < LANES; ++i) {
        at->missing[i] = at->under[i] = 0, at->below_coat[i] = 1;
        at->coated[i] = 0;
    }
    if (lobes & (SHADER_EVEN | SHADER_COATED))
        read_curves(b, at->l[2], at->missing, at->under, at->below_coat);
    if (lobes & SHADER_STRETCHED) stretch_curves(b, at->l, at->missing, at->under);
    if (lobes & SHADER_FILM) film_curves(b, at->l, at->film_under);
    if (lobes & SHADER_SOLID) open_inside(b, at->under);
    if (lobes & (SHADER_LAYER | SHADER_GGX | SHADER_HIGHLIGHT | SHADER_COATED | SHADER_SHEEN | SHADER_GLASS))
        set_half(b, at->l, h, rise);
    if (lobes & (SHADER_DIFFUSE | SHADER_BEHIND)) add_diffuse(b, rare, at, h, rise, f);
    if (lobes & SHADER_LEAF) add_leaf(b, at, f);
    if (lobes & (SHADER_DIFFUSE | SHADER_BEHIND | SHADER_EVEN | SHADER_LEAF)) add_cosines(b, at, density);
    if (lobes & SHADER_HIGHLIGHT) add_highlight(s, b, at, l, h, f, density);
    if (lobes & SHADER_GGX) add_ggx(b, rare, at, h, rise, f, density);
    if (lobes & SHADER_EVEN) add_again(b, at, f);
    if (lobes & SHADER_GLASS) add_glass_again(s, b, at, h, rise, f, density);
    if (lobes & SHADER_THIN) add_thin(b, rare, at, f, density);
    if (lobes & SHADER_REFRACT) add_refraction(b, rare, at, f, density);
    if (lobes & SHADER_SHEEN) add_sheen(b, at, h, f, density);
    if (lobes & SHADER_COATED) add_coat(s, b, at, l, h, rise, f, density);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) f[c][i] = limited(f[c][i]);
    }
}

static inline void add_lobes(const surface_block *s, const shader_block *b, const lanes3 l, incidence *at,
                             float (*restrict f)[LANES], float *restrict density) {
    if (b->lobes & SHADER_RARE)
        add_lobes_as(s, b, true, l, at, f, density);
    else
        add_lobes_as(s, b, false, l, at, f, density);
}
