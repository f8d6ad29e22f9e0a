/* Values and densities of all lobes but the smooth ones, of light from one direction a lane. */
#ifndef MATERIAL_KERNELS_LOBES_H
#define MATERIAL_KERNELS_LOBES_H

#include "base/kernel.h"
#include "material/kernels/highlight.h"
#include "material/shader.h"
#include "math/limit.h"

#include <math.h>

#define PI 3.14159265f

static inline float power5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

/* ---- the direction ---- */

typedef struct incidence {
    _Alignas(64) lanes3 l;                   /* in the block's frame */
    uint32_t reflected[LANES], cross[LANES]; /* all ones: l is on the viewer's side, or on the other */
    float missing[LANES], under[LANES], below_coat[LANES]; /* of the materials, at l */
} incidence;

/* Light and viewer are on the same side of the surface without its normal map, too. */
static inline void judge_mapped(const surface_block *s, const lanes3 l, incidence *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float side = s->base[0][i] * l[0][i] + s->base[1][i] * l[1][i] + s->base[2][i] * l[2][i];
        uint32_t plain = s->mapped >> i & 1 ? 0 : ~0u;
        out->reflected[i] &= plain | (side > 0 ? ~0u : 0);
        out->cross[i] &= plain | (side < 0 ? ~0u : 0);
    }
}

static inline void judge_sides(const surface_block *s, const shader_block *b, const lanes3 l,
                               incidence *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float x = 0, y = 0, z = 0, side = 0;
        for (int c = 0; c < 3; ++c) {
            x += b->t[c][i] * l[c][i], y += b->b[c][i] * l[c][i], z += b->n[c][i] * l[c][i];
            side += s->ng[c][i] * l[c][i];
        }
        out->l[0][i] = x, out->l[1][i] = y, out->l[2][i] = z;
        out->reflected[i] = (z > 0 ? ~0u : 0) & (side > 0 ? ~0u : 0);
        out->cross[i] = (z < 0 ? ~0u : 0) & (side < 0 ? ~0u : 0);
    }
    if (s->mapped) judge_mapped(s, l, out);
}

static inline float curve_at(const float curve[ENERGY_NODES], float cosine) {
    float x = sqrtf(sqrtf(fabsf(cosine))) * ENERGY_STEPS;
    int k = (int)x < ENERGY_STEPS - 1 ? (int)x : ENERGY_STEPS - 1;
    return curve[k] + (x - (float)k) * (curve[k + 1] - curve[k]);
}

/* The materials' curves at the cosines. */
static inline void read_curves(const shader_block *b, const float cosine[LANES], float *restrict missing,
                               float *restrict under, float *restrict below_coat) {
    for (int i = 0; i < LANES; ++i) {
        missing[i] = curve_at(b->at[i]->missing, cosine[i]);
        under[i] = curve_at(b->at[i]->under, cosine[i]);
        below_coat[i] = curve_at(b->at[i]->below_coat, cosine[i]);
    }
}

/* ---- Schlick ---- */

/* (1 - cos)^5, of the angle in the thinner medium: 1 at total reflection. eta: of the far side over the near
 * one. */
static inline float schlick(float cosine, float eta) {
    float near = cosine < 1 ? (cosine > 0 ? cosine : 0) : 1;
    float far2 = 1 - (1 - near) * (1 + near) / (eta * eta), far = sqrtf(far2 > 0 ? far2 : 0);
    return power5(1 - (eta < 1 ? far : near));
}

static inline float layer_share(const shader_block *b, int i, float rise) {
    return b->layer0[i] + (b->layer90[i] - b->layer0[i]) * rise;
}

/* ---- facets ---- */

/* sqrt(cos^2 + alpha^2 sin^2): Smith's masking is G1 = 2 cos / (cos + it), and of both directions together
 * G2 / (4 cos cos') = 1 / (2 (cos it' + cos' it)) (Heitz 2014). */
static inline float smith(float a2, float x, float y, float z) { return sqrtf(a2 * (x * x + y * y) + z * z); }

/* Trowbridge & Reitz's distribution, from the sine of h, which keeps its digits where alpha is small. */
static inline float ggx(float a2, float hx, float hy, float hz) {
    float t = hx * hx + hy * hy + a2 * (hz * hz);
    return a2 / (PI * t * t);
}

/* The half vector, and Schlick's factor there. Opposite directions have none, and get a zero vector. */
static inline void set_half(const shader_block *b, const lanes3 l, lanes3 h, float *restrict rise) {
    for (int i = 0; i < LANES; ++i) {
        float x = b->v[0][i] + l[0][i], y = b->v[1][i] + l[1][i], z = b->v[2][i] + l[2][i];
        float square = x * x + y * y + z * z, unit = 1 / sqrtf(square > 0x1p-60f ? square : 0x1p-60f);
        h[0][i] = x * unit, h[1][i] = y * unit, h[2][i] = z * unit;
        float cosine = b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
        rise[i] = power5(1 - (cosine < 1 ? (cosine > 0 ? cosine : 0) : 1));
    }
    if (!(b->lobes & SHADER_SOLID)) return;
    for (int i = 0; i < LANES; ++i) {
        float cosine = b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
        rise[i] = schlick(cosine, b->eta[i]);
    }
}

/* D G2 / (4 n·v n·l) times n·l, and the density of l by visible normals: D G1 / (4 n·v). */
static inline float mirrored_facets(const shader_block *b, float alpha, int i, const lanes3 l, const lanes3 h,
                                    float *density) {
    float a2 = alpha * alpha, z = b->v[2][i], lz = l[2][i];
    float to = smith(a2, b->v[0][i], b->v[1][i], z), from = smith(a2, l[0][i], l[1][i], lz);
    float d = ggx(a2, h[0][i], h[1][i], h[2][i]);
    *density = d / (2 * (z + to));
    return d * lz / (2 * (z * from + lz * to));
}

static inline void add_ggx(const shader_block *b, const incidence *at, const lanes3 h,
                           const float rise[LANES], float (*restrict f)[LANES], float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float d, value = mirrored_facets(b, b->alpha[i], i, at->l, h, &d);
        value = chosen(at->reflected[i], value, 0);
        for (int c = 0; c < 3; ++c) f[c][i] += (b->f0[c][i] + (b->f90[i] - b->f0[c][i]) * rise[i]) * value;
        density[i] += chosen(at->reflected[i], b->take[SHADER_TAKE_GGX][i] * d, 0);
    }
}

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

/* Light that left the facets after more than one scattering. */
static inline void add_again(const shader_block *b, const incidence *at, float (*restrict f)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float value = b->missing[i] * at->missing[i] * fabsf(at->l[2][i]);
        for (int c = 0; c < 3; ++c) {
            float factor =
                chosen(at->reflected[i], b->again[c][i], chosen(at->cross[i], b->again_cross[c][i], 0));
            f[c][i] += factor * value;
        }
    }
}

/* Through a thin wall: what l mirrored to the viewer's side would reflect, times what the layer lets
 * through. */
static inline void add_thin(const shader_block *b, const incidence *at, float (*restrict f)[LANES],
                            float *restrict density) {
    lanes3 l, h;
    float rise[LANES];
    for (int i = 0; i < LANES; ++i)
        l[0][i] = at->l[0][i], l[1][i] = at->l[1][i], l[2][i] = fabsf(at->l[2][i]);
    set_half(b, l, h, rise);
    for (int i = 0; i < LANES; ++i) {
        uint32_t open = at->cross[i] & (b->eta[i] == 1 ? ~0u : 0);
        float d, value = mirrored_facets(b, b->alpha[i], i, l, h, &d);
        value = chosen(open, value * (1 - layer_share(b, i, rise[i])), 0);
        for (int c = 0; c < 3; ++c) f[c][i] += b->cross[c][i] * value;
        density[i] += chosen(open, b->take[SHADER_TAKE_CROSS][i] * d, 0);
    }
}

/* Walter et al. (2007), of radiance over the squared index: times eta^2. h = ±(v + eta l), whose length is
 * v·h + eta l·h. */
static inline void add_refraction(const shader_block *b, const incidence *at, float (*restrict f)[LANES],
                                  float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float a2 = b->alpha[i] * b->alpha[i], eta = b->eta[i], h[3], square = 0, vh = 0, lh = 0;
        for (int c = 0; c < 3; ++c) {
            h[c] = b->v[c][i] + eta * at->l[c][i];
            square += h[c] * h[c];
        }
        square = square > 0x1p-40f ? square : 0x1p-40f;
        float unit = copysignf(1 / sqrtf(square), h[2]);
        for (int c = 0; c < 3; ++c) {
            h[c] *= unit;
            vh += b->v[c][i] * h[c], lh -= at->l[c][i] * h[c];
        }
        uint32_t open = at->cross[i] & (eta != 1 ? ~0u : 0) & (vh > 0 ? ~0u : 0) & (lh > 0 ? ~0u : 0);
        float z = b->v[2][i], lz = fabsf(at->l[2][i]);
        float to = smith(a2, b->v[0][i], b->v[1][i], z), from = smith(a2, at->l[0][i], at->l[1][i], lz);
        float d = 2 * ggx(a2, h[0], h[1], h[2]) * vh * lh * (eta * eta) / square;
        float rise = power5(1 - fminf(eta < 1 ? lh : vh, 1));
        float value = chosen(open, (1 - layer_share(b, i, rise)) * d * lz / (z * from + lz * to), 0);
        for (int c = 0; c < 3; ++c) f[c][i] += b->cross[c][i] * value;
        density[i] += chosen(open, b->take[SHADER_TAKE_CROSS][i] * d / (z + to), 0);
    }
}

/* ---- diffuse and classic lobes ---- */

/* Lambert's lobe under what the dielectric layer leaves. */
static inline void add_diffuse(const shader_block *b, const incidence *at, const float rise[LANES],
                               float (*restrict f)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        uint32_t lit = at->reflected[i] | (at->cross[i] & b->from_behind[i]);
        float cosine = chosen(lit, fabsf(at->l[2][i]) * (1 / PI), 0);
        float left = chosen(b->even[i], b->under[i] * at->under[i], 1 - layer_share(b, i, rise[i]));
        for (int c = 0; c < 3; ++c) f[c][i] += b->diffuse[c][i] * left * cosine;
    }
}

static inline void add_cosines(const shader_block *b, const incidence *at, float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float take = chosen(at->reflected[i], b->take[SHADER_TAKE_DIFFUSE][i],
                            chosen(at->cross[i], b->take[SHADER_TAKE_BEHIND][i], 0));
        density[i] += take * fabsf(at->l[2][i]) * (1 / PI);
    }
}

/* Phong's lobe is sampled by (n+1)/2pi (r·l)^n about the mirrored viewer, Blinn's by the same of the half
 * vector, whose solid angle is 1 / (4 v·h) of the direction's. */
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

static inline void add_lobes(const surface_block *s, const shader_block *b, const lanes3 l, incidence *at,
                             float (*restrict f)[LANES], float *restrict density) {
    lanes3 h = {{0}};
    float rise[LANES] = {0};
    const uint32_t lobes = b->lobes;
    for (int i = 0; i < LANES; ++i) f[0][i] = f[1][i] = f[2][i] = density[i] = 0;
    for (int i = 0; i < LANES; ++i) at->missing[i] = at->under[i] = 0, at->below_coat[i] = 1;
    if (lobes & (SHADER_EVEN | SHADER_COATED))
        read_curves(b, at->l[2], at->missing, at->under, at->below_coat);
    if (lobes & (SHADER_LAYER | SHADER_GGX | SHADER_HIGHLIGHT | SHADER_COATED)) set_half(b, at->l, h, rise);
    if (lobes & (SHADER_DIFFUSE | SHADER_BEHIND)) add_diffuse(b, at, rise, f);
    if (lobes & (SHADER_DIFFUSE | SHADER_BEHIND | SHADER_EVEN)) add_cosines(b, at, density);
    if (lobes & SHADER_HIGHLIGHT) add_highlight(s, b, at, l, h, f, density);
    if (lobes & SHADER_GGX) add_ggx(b, at, h, rise, f, density);
    if (lobes & SHADER_EVEN) add_again(b, at, f);
    if (lobes & SHADER_THIN) add_thin(b, at, f, density);
    if (lobes & SHADER_REFRACT) add_refraction(b, at, f, density);
    if (lobes & SHADER_COATED) add_coat(b, at, h, rise, f, density);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) f[c][i] = limited(f[c][i]);
    }
}

#endif
