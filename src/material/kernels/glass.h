/* A smooth dielectric: its mirrored and refracted directions, one lane at a time. */
#pragma once

#include "math/limit.h"
#include "surface/surface.h"

#include <math.h>
#include <stdbool.h>

typedef struct glass {
    float k_r[3], k_t[3], ior;
    uint32_t fresnel; /* 0: k_r and k_t are used unchanged */
} glass;

/* Unpolarised reflectance between dielectrics; eta = n1/n2, both cosines >= 0 (Fresnel's equations). 1 at
 * grazing incidence. */
static inline float fresnel_reflectance(float eta, float cos_in, float cos_out) {
    if (!(cos_in > 0)) return 1;
    float parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    float across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    return 0.5f * (parallel * parallel + across * across);
}

static inline float dot_lane(const lanes3 a, const lanes3 b, int i) {
    return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
}

/* The normal to scatter about: the shading normal, or the geometric normal if the viewer or the mirrored ray
 * would lie behind the shading normal's horizon. r·ng = 2 (n·v)(n·ng) - v·ng. */
static inline void choose_normal(const surface_block *s, int i, float n[3]) {
    float n_dot_v = dot_lane(s->ns, s->v, i);
    bool usable = n_dot_v > 0 && 2 * n_dot_v * dot_lane(s->ns, s->ng, i) > dot_lane(s->v, s->ng, i);
    for (int c = 0; c < 3; ++c) n[c] = usable ? s->ns[c][i] : s->ng[c][i];
}

static inline void set_unit(lanes3 out, int i, const float d[3]) {
    float inverse = 1 / sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int c = 0; c < 3; ++c) out[c][i] = d[c] * inverse;
}

/* The squared cosine of Snell's angle, 1 - eta^2 sin^2; negative on total internal reflection. Near the
 * normal the sine is accurate; elsewhere the cosine is, and the form 1 - eta^2 + eta^2 cos^2 has no rounding
 * error for eta = 1 at grazing angles. eta is multiplied in twice, because its square may be out of range. */
static inline float snell_cos2(float eta, float cos_in, float sin2) {
    if (sin2 < 0.5f) return 1 - eta * (eta * sin2);
    return (1 - eta) * (1 + eta) + eta * cos_in * (eta * cos_in);
}

/* Without `fresnel`, total internal reflection adds k_t to the mirrored weight. With `fresnel`, the weights
 * k_r F and k_t (1 - F) hold everywhere: F reaches 1 at the critical angle, so the weights are continuous. */
static inline void set_shares(const glass *g, int i, bool total, float reflectance, lanes3 mirrored,
                              lanes3 refracted) {
    for (int c = 0; c < 3; ++c) {
        float k_r = g->k_r[c], k_t = g->k_t[c];
        float r = g->fresnel ? k_r * reflectance : (total ? limited(k_r + k_t) : k_r);
        float t = g->fresnel ? k_t * (1 - reflectance) : k_t;
        mirrored[c][i] = r;
        refracted[c][i] = total ? 0 : t;
    }
}

/* Directions are unit. On total internal reflection the refracted direction is -v, and its weight is 0. */
static inline void glass_scatter(const surface_block *s, int i, const glass *g, lanes3 mirrored,
                                 lanes3 mirrored_share, lanes3 refracted, lanes3 refracted_share) {
    float n[3], mirror[3], through[3], aside[3];
    choose_normal(s, i, n);
    float cos_in = n[0] * s->v[0][i] + n[1] * s->v[1][i] + n[2] * s->v[2][i];
    cos_in = cos_in > 1 ? 1 : (cos_in > 0 ? cos_in : 0);
    /* For a larger eta only light along the normal is transmitted, and squares would overflow float. */
    float ratio = s->entering[i] ? 1 / g->ior : g->ior, eta = ratio < 0x1p100f ? ratio : 0x1p100f;
    /* The sine comes from v's component along the surface: 1 - cos^2 loses all angles below 2^-12. */
    float sin2 = 0;
    for (int c = 0; c < 3; ++c) {
        aside[c] = s->v[c][i] - cos_in * n[c];
        sin2 += aside[c] * aside[c];
    }
    float cos2 = snell_cos2(eta, cos_in, sin2);
    bool total = !(cos2 > 0);
    float cos_out = total ? 0 : sqrtf(cos2);
    float along = 0;
    for (int c = 0; c < 3; ++c) {
        mirror[c] = -s->v[c][i] + 2 * cos_in * n[c];
        through[c] = -eta * aside[c] - cos_out * n[c];
        along += through[c] * s->ng[c][i];
    }
    /* A shading normal can refract the ray back to the viewer's side: then mirror it at the geometric
     * surface. */
    if (!total && along >= 0) {
        for (int c = 0; c < 3; ++c) through[c] -= 2 * along * s->ng[c][i];
    }
    set_unit(mirrored, i, mirror);
    if (total) {
        for (int c = 0; c < 3; ++c) refracted[c][i] = -s->v[c][i];
    } else {
        set_unit(refracted, i, through);
    }
    set_shares(g, i, total, total ? 1 : fresnel_reflectance(eta, cos_in, cos_out), mirrored_share,
               refracted_share);
}
