/* The classic material: Lambert's diffuse reflection, a Phong or Blinn highlight, and the mirrored and
 * refracted rays of a smooth dielectric. */
#include "material/kernels/glass.h"
#include "material/kernels/highlight.h"
#include "material/material.h"
#include "math/limit.h"

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

/* Most blocks have one material: a loop over lanes that copies the same numbers vectorises. */
static void make(const bsdf *const at[LANES], bsdf_block *restrict out) {
    bool differ = false;
    for (int i = 1; i < LANES; ++i) differ |= at[i] != at[0];
    if (differ) {
        for (int i = 0; i < LANES; ++i) set_lane(at[i], i, out);
    } else {
        const bsdf m = *at[0];
        for (int i = 0; i < LANES; ++i) set_lane(&m, i, out);
    }
}

/* ---- light from one direction ---- */

/* An opaque surface gets no light from its far side. On smooth meshes the facets approximate a round surface,
 * and the shading normal decides the side (Hanika 2021); lit_from_behind accepts both sides. With a normal
 * map, both the normal without the map and the mapped one must face the light. */
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
    for (uint32_t left = s->mapped; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        float side = l[0][i] * s->base[0][i] + l[1][i] * s->base[1][i] + l[2][i] * s->base[2][i];
        if (!(side > 0) && !m->from_behind[i]) out->cosine[i] = 0;
    }
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
    highlight(s->ns, s->v, m->phong, m->blinn, m->shininess, l, n_dot_l, rho_s);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) out->f[c][i] = limited(m->k_d[c][i] + m->k_s[c][i] * rho_s[i]);
    }
    return true;
}

/* ---- mirrored and refracted rays ---- */

static void set_origin(const surface_block *s, int i, float side, scatter_block *out) {
    for (int c = 0; c < 3; ++c) {
        out->origin[c][i] = surface_start(s->p[c][i], side * s->offset[i], s->ng[c][i]);
    }
}

static void scatter_lane(const surface_block *s, const bsdf_block *m, int i, scatter_block *mirrored,
                         scatter_block *refracted) {
    const glass g = {{m->k_r[0][i], m->k_r[1][i], m->k_r[2][i]},
                     {m->k_t[0][i], m->k_t[1][i], m->k_t[2][i]},
                     m->ior[i],
                     m->fresnel[i]};
    set_origin(s, i, 1, mirrored);
    set_origin(s, i, -1, refracted);
    glass_scatter(s, i, &g, mirrored->direction, mirrored->share, refracted->direction, refracted->share);
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
