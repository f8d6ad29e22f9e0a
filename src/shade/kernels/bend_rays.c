#include "shade/kernels/kernel.h"
#include "shade/limit.h"

#include <math.h>
#include <stdbool.h>

/* Unpolarised reflectance between dielectrics; eta = n1/n2, both cosines >= 0 (Fresnel's equations). Along
 * the surface all is reflected. */
static float fresnel_reflectance(float eta, float cos_in, float cos_out) {
    if (!(cos_in > 0)) return 1;
    float parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    float across = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    return 0.5f * (parallel * parallel + across * across);
}

static float dot_lane(const lanes3 a, const lanes3 b, int i) {
    return a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
}

/* The normal to bend about: the shading normal, or the geometric one where the viewer, or the mirrored ray,
 * would lie behind the shading normal's horizon. r·ng = 2 (n·v)(n·ng) - v·ng. */
static void choose_normal(const surface_block *s, int i, float n[3]) {
    float n_dot_v = dot_lane(s->ns, s->v, i);
    bool usable = n_dot_v > 0 && 2 * n_dot_v * dot_lane(s->ns, s->ng, i) > dot_lane(s->v, s->ng, i);
    for (int c = 0; c < 3; ++c) n[c] = usable ? s->ns[c][i] : s->ng[c][i];
}

static void set_origin(const surface_block *s, int i, float side, bend_block *out) {
    for (int c = 0; c < 3; ++c) {
        out->origin[c][i] = surface_start(s->p[c][i], side * s->offset[i], s->ng[c][i]);
    }
}

static void set_unit(bend_block *out, int i, const float d[3]) {
    float inverse = 1 / sqrtf(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int c = 0; c < 3; ++c) out->direction[c][i] = d[c] * inverse;
}

/* The squared cosine of Snell's angle, 1 - eta^2 sin^2; negative on total internal reflection. Near the
 * normal the sine is what is known well; away from it the cosine, and for eta = 1 nothing may be lost at
 * grazing angles: 1 - eta^2 + eta^2 cos^2. Each eta by itself: its square may be out of range. */
static float snell_cos2(float eta, float cos_in, float sin2) {
    if (sin2 < 0.5f) return 1 - eta * (eta * sin2);
    return (1 - eta) * (1 + eta) + eta * cos_in * (eta * cos_in);
}

/* Without `fresnel`, total internal reflection adds k_t to what is mirrored. With it, the shares k_r F and
 * k_t (1 - F) hold there as everywhere: F reaches 1 at the critical angle, so nothing jumps. */
static void set_weights(const surface_block *s, const material_block *m, int i, bool total, float reflectance,
                        bend_block *mirrored, bend_block *refracted) {
    const bool fresnel = m->fresnel[i] != 0;
    for (int c = 0; c < 3; ++c) {
        float k_r = m->k_r[c][i], k_t = m->k_t[c][i];
        float r = fresnel ? k_r * reflectance : (total ? limited(k_r + k_t) : k_r);
        float t = fresnel ? k_t * (1 - reflectance) : k_t;
        mirrored->weight[c][i] = limited(s->weight[c][i] * r);
        refracted->weight[c][i] = total ? 0 : limited(s->weight[c][i] * t);
    }
}

static void bend_lane(const surface_block *s, const material_block *m, int i, bend_block *mirrored,
                      bend_block *refracted) {
    float n[3], mirror[3], through[3], aside[3];
    choose_normal(s, i, n);
    float cos_in = n[0] * s->v[0][i] + n[1] * s->v[1][i] + n[2] * s->v[2][i];
    cos_in = cos_in > 1 ? 1 : (cos_in > 0 ? cos_in : 0);
    /* Past 2^100 only the normal itself gets through, and squares would leave the range of float. */
    float ratio = s->entering[i] ? 1 / m->ior[i] : m->ior[i], eta = ratio < 0x1p100f ? ratio : 0x1p100f;
    /* The sine from the part of v along the surface: 1 - cos^2 loses all angles below 2^-12. */
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
    /* A shading normal can bend the ray back to the viewer's side: then the way is along the geometric
     * normal's far side. */
    if (!total && along >= 0) {
        for (int c = 0; c < 3; ++c) through[c] -= 2 * along * s->ng[c][i];
    }
    set_origin(s, i, 1, mirrored);
    set_origin(s, i, -1, refracted);
    set_unit(mirrored, i, mirror);
    if (total) {
        for (int c = 0; c < 3; ++c) refracted->direction[c][i] = -s->v[c][i];
    } else {
        set_unit(refracted, i, through);
    }
    set_weights(s, m, i, total, total ? 1 : fresnel_reflectance(eta, cos_in, cos_out), mirrored, refracted);
}

void KERNEL(bend_rays)(const surface_block *s, const material_block *m, bend_block *mirrored,
                       bend_block *refracted) {
    for (int i = 0; i < LANES; ++i) bend_lane(s, m, i, mirrored, refracted);
}
