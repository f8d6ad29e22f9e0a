/* Rough glass with `multiscatter`: the light that leaves it after more than one scattering (M of shader.h),
 * and directions for SHADER_GLASS, where reflection, refraction and that light are sampled together:
 *
 * A visible facet is sampled. It reflects with the probability L of Schlick's layer, otherwise it refracts.
 * The direction is kept with the probability G2/G1. All others, M of them, are replaced by a direction on
 * either side, nearly proportional to M(l) n·l: between two nodes of M's curve the density is that of a
 * cosine. So the density is nearly the BSDF of white glass, and weights stay close to 1. Lobes chosen
 * beforehand would have weights above 1, whose product over the bounces inside a ball grows: at a roughness
 * of 0.7, the noise of a ball would be fourteen times as much.
 *
 * The fraction that is replaced is exactly M(v), whereas values and densities have the M(v) of tables
 * (energy.h): the light of this part may be off by their error. */
#pragma once

#include "material/kernels/facets.h"
#include "math/mix.h"
#include "math/turn.h"

static inline bool is_glass(const shader_block *b, int i) { return b->at[i]->lobes & SHADER_GLASS; }

/* 0: viewed from outside; 1: from inside. */
static inline int glass_side(const surface_block *s, int i) { return s->entering[i] ? 0 : 1; }

/* ---- values and densities ---- */

/* The squared cosine at a node of the curves. */
static inline float node_square(int k) { return power8((float)k * (1.0f / ENERGY_STEPS)); }

/* M in a direction. */
static inline float missing_at(const shader *m, int side, const lanes3 d, int i) {
    if (!(m->lobes & SHADER_STRETCHED)) return curve_at(m->glass_missing[side], d[2][i]);
    const energy_glass_stretch *g = &m->glass_stretch;
    const float ax = fabsf(d[0][i]), ay = fabsf(d[1][i]),
                t = (ax + ay > 0 ? ay / (ax + ay) : 0) * ENERGY_TURNS;
    const float w = sqrtf(sqrtf(fabsf(d[2][i]))) * ENERGY_GLASS_STEPS;
    const int j = (int)t < ENERGY_TURNS - 1 ? (int)t : ENERGY_TURNS - 1;
    const int k = (int)w < ENERGY_GLASS_STEPS - 1 ? (int)w : ENERGY_GLASS_STEPS - 1;
    const float x = t - (float)j, y = w - (float)k;
    const float low = (1 - y) * energy_glass_node(g, side, j, k) + y * energy_glass_node(g, side, j, k + 1);
    const float high =
        (1 - y) * energy_glass_node(g, side, j + 1, k) + y * energy_glass_node(g, side, j + 1, k + 1);
    return low + x * (high - low);
}

/* The density of M's directions on a side, without their azimuth. */
static inline float missing_density(const shader *m, int side, float z) {
    float unused;
    const int k = node_at(z, &unused);
    const float share = m->glass_sums[side][k + 1] - m->glass_sums[side][k];
    return share / (node_square(k + 1) - node_square(k)) * fabsf(z) * (1 / PI);
}

static inline void weigh_glass(const surface_block *s, int i, shader_block *restrict out) {
    const shader *m = out->at[i];
    const int side = glass_side(s, i);
    if (is_glass(out, i)) {
        const float layer = glass_share(out, true, i, out->v[2][i], schlick(out->v[2][i], out->eta[i]));
        if (!(m->lobes & SHADER_INNER_METAL)) out->take[SHADER_TAKE_GGX][i] = 0;
        out->take[SHADER_TAKE_CROSS][i] = side ? m->glass_part : layer + (1 - layer) * m->glass_part;
    }
}

/* missing: the density of the light that was scattered more than once. Refraction's density is in
 * add_refraction(). */
static inline void add_glass_density(const shader_block *b, const incidence *at, int i, const lanes3 h,
                                     float rise, float missing, float *density) {
    float unused, facets = 0;
    if (at->reflected[i])
        facets =
            glass_share(b, true, i, along_half(b, h, i), rise) * facets_of(b, true, i, at->l, h, &unused);
    *density += b->take[SHADER_TAKE_CROSS][i] * (facets + missing);
}

static inline void add_glass_again(const surface_block *s, const shader_block *b, const incidence *at,
                                   const lanes3 h, const float rise[LANES], float (*restrict f)[LANES],
                                   float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        const shader *m = b->at[i];
        const int side = glass_side(s, i), other = at->cross[i] ? !side : side;
        if (!is_glass(b, i) || !(at->reflected[i] | at->cross[i])) continue;
        const float z = fabsf(at->l[2][i]), missing = missing_at(m, side, b->v, i);
        const float value = missing * missing_at(m, other, at->l, i) * z;
        for (int c = 0; c < 3; ++c)
            f[c][i] += value * (at->cross[i] ? m->glass_again_cross[side][c] : m->glass_again[side]);
        const float part = at->cross[i] ? m->glass_through[side] : 1 - m->glass_through[side];
        add_glass_density(b, at, i, h, rise[i], missing * part * missing_density(m, other, z), &density[i]);
    }
}

/* ---- directions ---- */

/* True with the probability p, decided by the uniform number *u, which becomes a new uniform number. */
static inline bool happens(float p, float *u) {
    const bool yes = *u < p;
    *u = yes ? *u / p : (*u - p) / (1 - p);
    return yes;
}

/* Two new numbers in [0,1), made from three. */
static inline void two_more(const lanes3 u, int i, float out[2]) {
    uint32_t bits[3];
    for (int c = 0; c < 3; ++c) memcpy(&bits[c], &u[c][i], sizeof bits[c]);
    const uint64_t hash = mix_bits(mix_bits((uint64_t)bits[0] << 32 | bits[1]) ^ bits[2]);
    out[0] = (float)(hash >> 40) * 0x1p-24f, out[1] = (float)(hash & 0xffffff) * 0x1p-24f;
}

/* The facet's reflected or refracted direction; false: the facet sends nothing to that side. */
static inline bool leave_facet(const shader_block *b, int i, const lanes3 h, bool reflects, float l[3]) {
    const float cosine = along_half(b, h, i), inverse = 1 / b->eta[i];
    const float far2 = 1 - (1 - cosine) * (1 + cosine) * (inverse * inverse);
    const float of_h = reflects ? 2 * cosine : cosine * inverse - sqrtf(far2 > 0 ? far2 : 0);
    for (int c = 0; c < 3; ++c) l[c] = of_h * h[c][i] - (reflects ? 1 : inverse) * b->v[c][i];
    return reflects ? l[2] > 0 : far2 > 0 && l[2] < 0;
}

/* G2/G1 of the direction. */
static inline float left_of_facets(const shader_block *b, int i, const float l[3]) {
    const float z = b->v[2][i], lz = fabsf(l[2]);
    const float to = smith_of(b, true, i, b->v[0][i], b->v[1][i], z),
                from = smith_of(b, true, i, l[0], l[1], lz);
    return lz * (z + to) / (z * from + lz * to);
}

/* A direction's squared cosine. */
static inline float missing_square(const shader *m, int side, float u) {
    const float *sums = m->glass_sums[side];
    int k = 0;
    for (int step = ENERGY_STEPS / 2; step > 0; step /= 2) k += sums[k + step] <= u ? step : 0;
    const float low = node_square(k), high = node_square(k + 1), share = sums[k + 1] - sums[k];
    return low + (high - low) * (share > 0 ? (u - sums[k]) / share : 0);
}

/* x: the third number, within the lobe's part of [0,1). */
static inline void glass_direction(const surface_block *s, const shader_block *b, int i, const lanes3 u,
                                   const lanes3 h, float x, float l[3]) {
    const float cosine = along_half(b, h, i),
                layer = glass_share(b, true, i, cosine, schlick(cosine, b->eta[i]));
    float more[2], x_of, y_of;
    if (leave_facet(b, i, h, happens(layer, &x), l) && happens(left_of_facets(b, i, l), &x)) return;
    const shader *m = b->at[i];
    const int side = glass_side(s, i);
    const bool through = happens(m->glass_through[side], &x);
    two_more(u, i, more);
    const float square = missing_square(m, through ? !side : side, more[0]);
    const float r = sqrtf(1 - square), z = sqrtf(square);
    turn_by(more[1], &x_of, &y_of);
    l[0] = r * x_of, l[1] = r * y_of, l[2] = through ? -z : z;
}

static inline void sample_glass(const surface_block *s, const shader_block *b, const lanes3 u, const lanes3 h,
                                const uint32_t lobe[LANES], lanes3 out) {
    for (int i = 0; i < LANES; ++i) {
        if (!is_glass(b, i) || lobe[i] != SHADER_TAKE_CROSS) continue;
        float start = 0, l[3];
        for (int k = 0; k < SHADER_TAKE_CROSS; ++k) start += b->take[k][i];
        const float x = (u[2][i] - start) / b->take[SHADER_TAKE_CROSS][i];
        glass_direction(s, b, i, u, h, x < 1 ? (x > 0 ? x : 0) : 0x1.fffffep-1f, l);
        for (int c = 0; c < 3; ++c) out[c][i] = l[c];
    }
}
