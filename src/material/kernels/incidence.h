/* Incident directions, the materials' curves at their cosines, and Schlick's factor. */
#pragma once

#include "base/kernel.h"
#include "material/shader.h"
#include "math/power.h"

#include <math.h>

#define PI 3.14159265f

/* ---- the direction ---- */

typedef struct incidence {
    _Alignas(64) lanes3 l;                   /* in the block's frame */
    float cosine[LANES];                     /* to Lambert's normal */
    uint32_t reflected[LANES], cross[LANES]; /* all ones: l is on the viewer's side; on the other side */
    uint32_t coated[LANES];                  /* the clear coat reflects l */
    float missing[LANES], under[LANES], below_coat[LANES]; /* of the materials, at l */
    lanes3 film_under;                                     /* the same with SHADER_FILM, by channel */
} incidence;

/* Light and viewer must also be on the same side of the surface without its normal map (cross: on opposite
 * sides). Lambert's lobe takes the map's normal as it is; see lift_by(). */
static inline void judge_mapped(const surface_block *s, const lanes3 l, incidence *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float side = 0, z = 0;
        for (int c = 0; c < 3; ++c) side += s->base[c][i] * l[c][i], z += s->ns[c][i] * l[c][i];
        uint32_t plain = s->mapped >> i & 1 ? 0 : ~0u;
        out->reflected[i] &= plain | (side > 0 ? ~0u : 0);
        out->cross[i] &= plain | (side < 0 ? ~0u : 0);
        z = z * out->l[2][i] > 0 ? z : 0;
        out->cosine[i] = chosen(plain, out->l[2][i], z);
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
        out->l[0][i] = x, out->l[1][i] = y, out->l[2][i] = out->cosine[i] = z;
        out->reflected[i] = (z > 0 ? ~0u : 0) & ((side > 0 ? ~0u : 0) | s->smooth[i]);
        out->cross[i] = (z < 0 ? ~0u : 0) & (side < 0 ? ~0u : 0);
    }
    if (s->mapped) judge_mapped(s, l, out);
}

/* The node of the curves below a cosine, and the fraction of the interval to the next node. */
static inline int node_at(float cosine, float *part) {
    const float x = sqrtf(sqrtf(fabsf(cosine))) * ENERGY_STEPS;
    const int k = (int)x < ENERGY_STEPS - 1 ? (int)x : ENERGY_STEPS - 1;
    *part = x - (float)k;
    return k;
}

static inline float curve_at(const float curve[ENERGY_NODES], float cosine) {
    float t;
    const int k = node_at(cosine, &t);
    return curve[k] + t * (curve[k + 1] - curve[k]);
}

static inline float below_coat_at(const shader *m, float cosine) {
    float t;
    const int k = node_at(cosine, &t);
    const float low = shader_below_coat(m, k), high = shader_below_coat(m, k + 1);
    return low + t * (high - low);
}

/* Albedos of facets that are not anisotropic. */
static inline void plain_albedos(const shader *m, float cosine, float *all, float *edge) {
    float t;
    const int k = node_at(cosine, &t);
    *all = energy_all(&m->facets, k) + t * (energy_all(&m->facets, k + 1) - energy_all(&m->facets, k));
    *edge = energy_edge(&m->facets, k) + t * (energy_edge(&m->facets, k + 1) - energy_edge(&m->facets, k));
}

/* The materials' curves at the cosines. */
static inline void read_curves(const shader_block *b, const float cosine[LANES], float *restrict missing,
                               float *restrict under, float *restrict below_coat) {
    for (int i = 0; i < LANES && b->lobes & SHADER_EVEN; ++i) {
        const shader *m = b->at[i];
        float t, all[2], edge[2];
        const int k = node_at(cosine[i], &t);
        for (int j = 0; j < 2; ++j)
            all[j] = energy_all(&m->facets, k + j), edge[j] = energy_edge(&m->facets, k + j);
        const float low = shader_under(m, all[0], edge[0]), high = shader_under(m, all[1], edge[1]);
        missing[i] = (1 - all[0]) + t * ((1 - all[1]) - (1 - all[0]));
        under[i] = low + t * (high - low);
    }
    for (int i = 0; i < LANES && b->lobes & SHADER_COATED; ++i)
        below_coat[i] = below_coat_at(b->at[i], cosine[i]);
}

/* Viewed from inside a solid, the base has no layer. */
static inline void open_inside(const shader_block *b, float *restrict under) {
    for (int i = 0; i < LANES; ++i) under[i] = chosen(b->inside[i], 1, under[i]);
}

/* ---- Schlick ---- */

/* (1 - cos)^5 of the angle in the thinner medium; 1 at total reflection. eta: index of the far side divided
 * by that of the near side. */
static inline float schlick(float cosine, float eta) {
    float near = cosine < 1 ? (cosine > 0 ? cosine : 0) : 1;
    float far2 = 1 - (1 - near) * (1 + near) / (eta * eta), far = sqrtf(far2 > 0 ? far2 : 0);
    return power5(1 - (eta < 1 ? far : near));
}

static inline float layer_share(const shader_block *b, int i, float rise) {
    return b->layer0[i] + (b->layer90[i] - b->layer0[i]) * rise;
}
