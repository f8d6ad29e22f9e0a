/* GGX: reflection, transmission through walls, refraction, and multiple scattering. */
#pragma once

#include "material/kernels/film.h"
#include "material/kernels/stretch.h"
#include "math/limit.h"

/* s = sqrt(cos^2 + alpha^2 sin^2): Smith's masking is G1 = 2 cos / (cos + s), and for both directions
 * together G2 / (4 cos cos') = 1 / (2 (cos s' + cos' s)) (Heitz 2014). */
static inline float smith(float a2, float x, float y, float z) { return sqrtf(a2 * (x * x + y * y) + z * z); }

/* Trowbridge & Reitz's distribution. It uses the sine of h, which keeps its digits if alpha is small. */
static inline float ggx(float a2, float hx, float hy, float hz) {
    float t = hx * hx + hy * hy + a2 * (hz * hz);
    return a2 / (PI * t * t);
}

/* The half vector, and Schlick's factor for it. Opposite directions have no half vector, and get a zero
 * vector. */
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

/* D G2 / (4 n·v n·l) times n·l, and the density of l when visible normals are sampled: D G1 / (4 n·v). z and
 * lz are the cosines of v and l, to and from their values of smith(). */
static inline float both_ways(float d, float z, float lz, float to, float from, float *density) {
    *density = d / (2 * (z + to));
    return d * lz / (2 * (z * from + lz * to));
}

static inline float mirrored_facets(const lanes3 v, float alpha, int i, const lanes3 l, const lanes3 h,
                                    float *density) {
    float a2 = alpha * alpha, z = v[2][i], lz = l[2][i];
    float to = smith(a2, v[0][i], v[1][i], z), from = smith(a2, l[0][i], l[1][i], lz);
    float d = ggx(a2, h[0][i], h[1][i], h[2][i]);
    return both_ways(d, z, lz, to, from, density);
}

/* smith(), ggx() and mirrored_facets() of the base. rare: some lane may be anisotropic. */
static inline __attribute__((always_inline)) float smith_of(const shader_block *b, bool rare, int i, float x,
                                                            float y, float z) {
    if (is_stretched(b, rare, i)) return smith_stretched(b, i, x, y, z);
    return smith(b->alpha[i] * b->alpha[i], x, y, z);
}

static inline __attribute__((always_inline)) float ggx_of(const shader_block *b, bool rare, int i, float hx,
                                                          float hy, float hz) {
    if (is_stretched(b, rare, i)) return ggx_stretched(b, i, hx, hy, hz);
    return ggx(b->alpha[i] * b->alpha[i], hx, hy, hz);
}

static inline __attribute__((always_inline)) float facets_of(const shader_block *b, bool rare, int i,
                                                             const lanes3 l, const lanes3 h, float *density) {
    if (!is_stretched(b, rare, i)) return mirrored_facets(b->v, b->alpha[i], i, l, h, density);
    float z = b->v[2][i], lz = l[2][i], to = smith_stretched(b, i, b->v[0][i], b->v[1][i], z);
    float from = smith_stretched(b, i, l[0][i], l[1][i], lz);
    return both_ways(ggx_stretched(b, i, h[0][i], h[1][i], h[2][i]), z, lz, to, from, density);
}

/* The probability with which a facet of rough glass reflects, see rough_glass.h: close to its reflectance. */
static inline __attribute__((always_inline)) float glass_share(const shader_block *b, bool rare, int i,
                                                               float cosine, float rise) {
    if (!is_filmed(b, rare, i)) return layer_share(b, i, rise);
    float sum = 0;
    for (int c = 0; c < 3; ++c) sum += layer_of(b, rare, i, c, cosine, rise);
    return sum * (1 / 3.0f);
}

/* The layer's transmittance under a film. */
static inline void film_curves(const shader_block *b, const lanes3 d, float (*restrict under)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        const shader *m = b->at[i];
        const float z = least(fabsf(d[2][i]), 1);
        float all, edge;
        if (!(m->lobes & SHADER_FILM) || !m->even) continue;
        if (m->lobes & SHADER_STRETCHED)
            stretch_albedos(m, d[0][i], d[1][i], z, &all, &edge);
        else
            plain_albedos(m, z, &all, &edge);
        for (int c = 0; c < 3; ++c) under[c][i] = film_under(m, c, all, edge, film_read(m->film_rest[c], z));
    }
}

/* `film_under` at the viewer, and `under` as their mean. */
static inline void set_films(shader_block *out) {
    film_curves(out, out->v, out->film_under);
    for (int i = 0; i < LANES; ++i) {
        const shader *m = out->at[i];
        if (!(m->lobes & SHADER_FILM) || !m->even || out->inside[i]) continue;
        out->under[i] = 0;
        for (int c = 0; c < 3; ++c) out->under[i] += out->film_under[c][i] * m->film_lift[c] * (1 / 3.0f);
    }
}

static inline float along_half(const shader_block *b, const lanes3 h, int i) {
    return b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
}

static inline __attribute__((always_inline)) void add_ggx(const shader_block *b, bool rare,
                                                          const incidence *at, const lanes3 h,
                                                          const float rise[LANES], float (*restrict f)[LANES],
                                                          float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float d, value = facets_of(b, rare, i, at->l, h, &d);
        value = chosen(at->reflected[i], value, 0);
        if (rare && !(b->at[i]->lobes & SHADER_GGX)) value = 0; /* other lanes have no f0 and f90 there */
        for (int c = 0; c < 3; ++c) {
            f[c][i] +=
                value * reflectance_at(b, rare, i, c, along_half(b, h, i), rise[i], b->f0[c][i], b->f90[i]);
        }
        density[i] += chosen(at->reflected[i], b->take[SHADER_TAKE_GGX][i] * d, 0);
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

/* l mirrored to the viewer's side, and its half vector. */
static inline void set_mirrored(const shader_block *b, const incidence *at, lanes3 l, lanes3 h,
                                float rise[LANES]) {
    for (int i = 0; i < LANES; ++i)
        l[0][i] = at->l[0][i], l[1][i] = at->l[1][i], l[2][i] = fabsf(at->l[2][i]);
    set_half(b, l, h, rise);
}

/* Light through a thin wall: the reflection of l mirrored to the viewer's side, multiplied by the layer's
 * transmittance. */
static inline __attribute__((always_inline)) void add_thin(const shader_block *b, bool rare,
                                                           const incidence *at, float (*restrict f)[LANES],
                                                           float *restrict density) {
    lanes3 l, h;
    float rise[LANES];
    set_mirrored(b, at, l, h, rise);
    for (int i = 0; i < LANES; ++i) {
        uint32_t open = at->cross[i] & (b->eta[i] == 1 ? ~0u : 0);
        float d, value = facets_of(b, rare, i, l, h, &d);
        for (int c = 0; c < 3; ++c) {
            float left = 1 - layer_of(b, rare, i, c, along_half(b, h, i), rise[i]);
            f[c][i] += b->cross[c][i] * chosen(open, value * left, 0);
        }
        density[i] += chosen(open, b->take[SHADER_TAKE_CROSS][i] * d, 0);
    }
}

/* Walter et al. (2007), for radiance divided by the squared index, hence the factor eta^2. h = ±(v + eta l),
 * whose length is v·h + eta l·h. */
static inline __attribute__((always_inline)) void add_refraction(const shader_block *b, bool rare,
                                                                 const incidence *at,
                                                                 float (*restrict f)[LANES],
                                                                 float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float eta = b->eta[i], h[3], square = 0, vh = 0, lh = 0;
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
        float to = smith_of(b, rare, i, b->v[0][i], b->v[1][i], z);
        float from = smith_of(b, rare, i, at->l[0][i], at->l[1][i], lz);
        float d = 2 * ggx_of(b, rare, i, h[0], h[1], h[2]) * vh * lh * (eta * eta) / square;
        float rise = power5(1 - least(eta < 1 ? lh : vh, 1));
        for (int c = 0; c < 3; ++c) {
            float left = 1 - layer_of(b, rare, i, c, vh, rise);
            f[c][i] += b->cross[c][i] * chosen(open, left * d * lz / (z * from + lz * to), 0);
        }
        float value =
            chosen(open, (1 - glass_share(b, rare, i, vh, rise)) * d * lz / (z * from + lz * to), 0);
        const bool whole = b->at[i]->lobes & SHADER_GLASS; /* see rough_glass.h */
        density[i] += b->take[SHADER_TAKE_CROSS][i] * (whole ? value : chosen(open, d / (z + to), 0));
    }
}
