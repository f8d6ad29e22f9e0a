/* The classic material: Lambert's diffuse reflection, a Phong or Blinn highlight, and the mirrored and
 * refracted rays of a smooth dielectric. */
#include "base/kernel.h"
#include "material/material.h"
#include "math/limit.h"
#include "math/power.h"

#include <math.h>
#include <stdbool.h>

/* ---- the block ---- */

static void set_lane(const bsdf *m, int i, bsdf_block *out) {
    for (int c = 0; c < 3; ++c) {
        out->k_d[c][i] = m->k_d[c];
        out->k_s[c][i] = m->k_s[c];
        out->k_r[c][i] = m->k_r[c];
        out->k_t[c][i] = m->k_t[c];
        out->emission[c][i] = m->emission[c];
    }
    out->shininess[i] = m->shininess;
    out->ior[i] = m->ior;
    out->phong[i] = m->phong;
    out->blinn[i] = m->blinn;
    out->fresnel[i] = m->fresnel;
    out->from_behind[i] = m->from_behind;
}

/* Most blocks see one material: a loop over lanes that copies the same numbers vectorises. */
static void make(const bsdf *table, const surface_block *s, bsdf_block *restrict out) {
    uint32_t differ = 0;
    for (int i = 1; i < LANES; ++i) differ |= s->material[i] ^ s->material[0];
    if (differ) {
        for (int i = 0; i < LANES; ++i) set_lane(&table[s->material[i]], i, out);
    } else {
        const bsdf m = table[s->material[0]];
        for (int i = 0; i < LANES; ++i) set_lane(&m, i, out);
    }
}

/* ---- light from one direction ---- */

/* Opaque: a light on the far side counts nothing. On smooth meshes the facets stand for a round surface,
 * whose side the shading normal tells (Hanika 2021); lit_from_behind takes either side. */
static void judge_sides(const surface_block *s, const bsdf_block *m, const lanes3 l, float n_dot_l[LANES],
                        bsdf_value *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float side = l[0][i] * s->ng[0][i] + l[1][i] * s->ng[1][i] + l[2][i] * s->ng[2][i];
        float cosine = l[0][i] * s->ns[0][i] + l[1][i] * s->ns[1][i] + l[2][i] * s->ns[2][i];
        uint32_t unlit = cosine > 0 ? 0 : ~0u, away = side > 0 ? 0 : ~0u, either = m->from_behind[i];
        uint32_t behind = (s->smooth[i] & unlit) | (~s->smooth[i] & away);
        float facing = chosen(behind | unlit, 0, cosine);
        n_dot_l[i] = cosine;
        out->behind[i] = behind;
        out->cosine[i] = chosen(either, fabsf(cosine), facing);
    }
}

/* k_s max(0, v·r)^n with r = -l + 2(n·l)n, or k_s max(0, n·h)^n with h = (l+v)/|l+v|. The cosine of two unit
 * vectors is 1 less half the square of their difference: that keeps the angle's digits where the cosine
 * itself would round to 1, and exponents in the millions need them. */
static void apart_phong(const surface_block *s, const lanes3 l, const float n_dot_l[LANES],
                        float *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        out[i] = 0;
        for (int c = 0; c < 3; ++c) {
            float r = -l[c][i] + 2 * n_dot_l[i] * s->ns[c][i], apart = s->v[c][i] - r;
            out[i] += apart * apart;
        }
    }
}

static void apart_blinn(const surface_block *s, const lanes3 l, float *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float h[3], h2 = 0;
        for (int c = 0; c < 3; ++c) {
            h[c] = l[c][i] + s->v[c][i];
            h2 += h[c] * h[c];
        }
        float unit = 1 / sqrtf(h2);
        out[i] = 0;
        for (int c = 0; c < 3; ++c) {
            float apart = s->ns[c][i] - h[c] * unit;
            out[i] += apart * apart;
        }
    }
}

static void highlight(const surface_block *s, const bsdf_block *m, const lanes3 l, const float n_dot_l[LANES],
                      float *restrict out) {
    float phong[LANES] = {0}, blinn[LANES] = {0}, less[LANES];
    uint32_t any_phong = 0, any_blinn = 0;
    for (int i = 0; i < LANES; ++i) any_phong |= m->phong[i], any_blinn |= m->blinn[i];
    if (!(any_phong | any_blinn)) return;
    if (any_phong) apart_phong(s, l, n_dot_l, phong);
    if (any_blinn) apart_blinn(s, l, blinn);
    for (int i = 0; i < LANES; ++i) {
        /* Light from straight behind leaves no half vector: no highlight. */
        float half = 0.5f * chosen(m->phong[i], phong[i], blinn[i]);
        less[i] = half < 1 ? half : 1;
    }
    double exponent[LANES];
    for (int i = 0; i < LANES; ++i) exponent[i] = power_exponent(less[i], m->shininess[i]);
    for (int i = 0; i < LANES; ++i) out[i] = power_finish(less[i], exponent[i]);
}

static bool any_lit(const bsdf_value *value, const float arriving[LANES]) {
    uint32_t lit = 0;
    for (int i = 0; i < LANES; ++i) lit |= value->cosine[i] * arriving[i] > 0 ? ~0u : 0;
    return lit != 0;
}

static bool evaluate(const surface_block *s, const bsdf_block *m, const lanes3 l, const float arriving[LANES],
                     bsdf_value *restrict out) {
    float n_dot_l[LANES], rho_s[LANES] = {0};
    judge_sides(s, m, l, n_dot_l, out);
    if (!any_lit(out, arriving)) return false;
    highlight(s, m, l, n_dot_l, rho_s);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) out->f[c][i] = limited(m->k_d[c][i] + m->k_s[c][i] * rho_s[i]);
    }
    return true;
}

/* ---- mirrored and refracted rays ---- */

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

/* The normal to scatter about: the shading normal, or the geometric one where the viewer, or the mirrored
 * ray, would lie behind the shading normal's horizon. r·ng = 2 (n·v)(n·ng) - v·ng. */
static void choose_normal(const surface_block *s, int i, float n[3]) {
    float n_dot_v = dot_lane(s->ns, s->v, i);
    bool usable = n_dot_v > 0 && 2 * n_dot_v * dot_lane(s->ns, s->ng, i) > dot_lane(s->v, s->ng, i);
    for (int c = 0; c < 3; ++c) n[c] = usable ? s->ns[c][i] : s->ng[c][i];
}

static void set_origin(const surface_block *s, int i, float side, scatter_block *out) {
    for (int c = 0; c < 3; ++c) {
        out->origin[c][i] = surface_start(s->p[c][i], side * s->offset[i], s->ng[c][i]);
    }
}

static void set_unit(scatter_block *out, int i, const float d[3]) {
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
static void set_shares(const bsdf_block *m, int i, bool total, float reflectance, scatter_block *mirrored,
                       scatter_block *refracted) {
    const bool fresnel = m->fresnel[i] != 0;
    for (int c = 0; c < 3; ++c) {
        float k_r = m->k_r[c][i], k_t = m->k_t[c][i];
        float r = fresnel ? k_r * reflectance : (total ? limited(k_r + k_t) : k_r);
        float t = fresnel ? k_t * (1 - reflectance) : k_t;
        mirrored->share[c][i] = r;
        refracted->share[c][i] = total ? 0 : t;
    }
}

static void scatter_lane(const surface_block *s, const bsdf_block *m, int i, scatter_block *mirrored,
                         scatter_block *refracted) {
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
    /* A shading normal can send the ray back to the viewer's side: then the way is along the geometric
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
    set_shares(m, i, total, total ? 1 : fresnel_reflectance(eta, cos_in, cos_out), mirrored, refracted);
}

static void scatter(const surface_block *s, const bsdf_block *m, scatter_block *restrict mirrored,
                    scatter_block *restrict refracted) {
    for (int i = 0; i < LANES; ++i) scatter_lane(s, m, i, mirrored, refracted);
}

const material_kernels KERNEL(material_kernels) = {
    .make = make,
    .evaluate = evaluate,
    .scatter = scatter,
};
