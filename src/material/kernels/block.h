/* From surface points and materials to a block of BSDFs. */
#pragma once

#include "material/kernels/glass.h"
#include "material/kernels/lobes.h"
#include "math/limit.h"

static inline float mean(const lanes3 x, int i) { return (x[0][i] + x[1][i] + x[2][i]) * (1 / 3.0f); }

/* ---- the block ---- */

static inline void set_colour(const float from[3], int i, float (*restrict to)[LANES]) {
    for (int c = 0; c < 3; ++c) to[c][i] = from[c];
}

static inline void set_lane(const shader *m, int i, shader_block *restrict out) {
    set_colour(m->diffuse, i, out->diffuse);
    set_colour(m->f0, i, out->f0);
    out->alpha[i] = m->alpha;
    out->f90[i] = m->f90;
    out->layer0[i] = m->layer0;
    out->layer90[i] = m->layer90;
    out->from_behind[i] = m->from_behind;
}

static inline void set_highlight(const shader *m, int i, shader_block *restrict out) {
    set_colour(m->highlight, i, out->highlight);
    out->shininess[i] = m->shininess;
    out->blinn[i] = m->blinn;
}

static inline void set_again(const shader *m, int i, shader_block *restrict out) {
    set_colour(m->again, i, out->again);
    set_colour(m->again_cross, i, out->again_cross);
}

/* The base has no layer over it. */
static inline void view_from_inside(const shader *m, int i, shader_block *restrict out) {
    const bool rough = m->lobes & SHADER_GGX;
    for (int c = 0; c < 3; ++c) {
        out->diffuse[c][i] *= m->mean_under;
        out->f0[c][i] -= rough ? m->base_f0[c] : 0;
    }
    for (int c = 0; c < 3 && m->lobes & SHADER_EVEN; ++c) out->again[c][i] -= m->base_again[c];
    out->f90[i] -= rough ? m->base_f90 : 0;
    out->even[i] = ~0u;
}

/* Surfaces that transmit smoothly have no rough facets to cross. */
static inline void set_cross(const shader *m, int i, uint32_t entering, shader_block *restrict out) {
    const uint32_t rough = m->lobes & (SHADER_THIN | SHADER_REFRACT) ? ~0u : 0;
    for (int c = 0; c < 3; ++c) out->cross[c][i] = chosen(rough, m->cross[c], 0);
    out->eta[i] = chosen(entering, m->eta, 1 / m->eta);
    out->even[i] = m->even & (out->eta[i] == m->eta ? ~0u : 0);
    out->inside[i] = (m->lobes & SHADER_SOLID) && !entering ? ~0u : 0;
    if (out->inside[i])
        view_from_inside(m, i, out);
    else
        for (int c = 0; c < 3; ++c) out->diffuse[c][i] *= chosen(out->even[i], 1, m->mean_under);
}

/* The index of the path's channel; an index of 1 would make it a thin wall. Inside a denser volume it is
 * below 1. */
static inline float dispersed_eta(const shader *m, uint32_t channel) {
    float eta = m->eta + ((float)channel - 2) * m->eta_spread;
    eta = m->eta > 1 ? most(eta, 1.0001f) : least(eta, 0.9999f);
    return m->lobes & SHADER_DISPERSIVE && channel ? eta : m->eta;
}

static inline void set_dispersion(const shader *m, int i, uint32_t entering, shader_block *restrict out) {
    float eta = dispersed_eta(m, out->channel[i]);
    out->eta[i] = chosen(m->lobes & SHADER_DISPERSIVE ? ~0u : 0, chosen(entering, eta, 1 / eta), out->eta[i]);
}

static inline void set_coat(const shader *m, int i, shader_block *restrict out) {
    out->coat[i] = m->coat;
    out->coat_alpha[i] = m->coat_alpha;
}

#define CROSSING (SHADER_THIN | SHADER_REFRACT | SHADER_PASS | SHADER_SOLID)

/* Sets the constants that the block's lobes read. Most blocks have one material: then the loops over lanes
 * copy the same numbers and vectorise. */
static inline void set_parts(const surface_block *s, const shader *const at[LANES], uint32_t lobes,
                             shader_block *restrict out) {
    for (int i = 0; i < LANES; ++i) set_lane(at[i], i, out);
    if (lobes & SHADER_HIGHLIGHT) {
        for (int i = 0; i < LANES; ++i) set_highlight(at[i], i, out);
    }
    if (lobes & SHADER_EVEN) {
        for (int i = 0; i < LANES; ++i) set_again(at[i], i, out);
    }
    if (lobes & SHADER_COATED) {
        for (int i = 0; i < LANES; ++i) set_coat(at[i], i, out);
    }
    if (lobes & CROSSING) {
        for (int i = 0; i < LANES; ++i) set_cross(at[i], i, s->entering[i], out);
    } else {
        for (int i = 0; i < LANES; ++i) out->eta[i] = 1, out->even[i] = at[i]->even, out->inside[i] = 0;
    }
    if (lobes & SHADER_DISPERSIVE) {
        for (int i = 0; i < LANES; ++i) set_dispersion(at[i], i, s->entering[i], out);
    }
}

static void set_materials(const surface_block *s, shader_block *restrict out) {
    uint32_t lobes = 0;
    bool differ = false;
    for (int i = 1; i < LANES; ++i) differ |= out->at[i] != out->at[0];
    if (differ) {
        const shader *at[LANES];
        for (int i = 0; i < LANES; ++i) at[i] = out->at[i], lobes |= at[i]->lobes;
        set_parts(s, at, lobes, out);
    } else {
        const shader *m = out->at[0];
        const shader *const at[LANES] = {m, m, m, m, m, m, m, m, m, m, m, m, m, m, m, m};
        lobes = m->lobes;
        set_parts(s, at, lobes, out);
    }
    out->lobes = lobes;
}

/* Two axes orthogonal to n (Duff et al., JCGT 2017). */
static inline void across(float x, float y, float z, float t[3], float b[3]) {
    float sign = copysignf(1, z), a = -1 / (sign + z), xy = x * y * a;
    t[0] = 1 + sign * x * x * a, t[1] = sign * xy, t[2] = -sign * x;
    b[0] = xy, b[1] = sign + y * y * a, b[2] = -y;
}

/* Rough facets lose light where a map tilts the normal n so far that it mirrors the viewer v behind the
 * surface. Returns the smallest t >= 0 for which N = n + t g, with g the normal without the map, mirrors v to
 * a cosine of at least h, a little above the horizon of g: 2 v·N g·N = (v·g + h) N·N, for h < v·g. Each light
 * above n and g is above N, too. */
static inline float lift_by(float n_dot_v, float n_dot_g, float g_dot_v) {
    const float h = least(0.5f * g_dot_v, 0x1p-6f), lean = n_dot_v - h * n_dot_g;
    const float below = g_dot_v + h - 2 * n_dot_v * n_dot_g;
    return below > 0 && h > 0 ? below / (lean + sqrtf(lean * lean + (g_dot_v - h) * below)) : 0;
}

static void lift_normals(const surface_block *s, shader_block *restrict out) {
    for (uint32_t left = s->mapped; left; left &= left - 1) {
        const int i = __builtin_ctz(left);
        float n[3], square = 0;
        const float up = dot_lane(out->n, s->v, i);
        if (!(out->at[i]->lobes & SHADER_GGX) || !(up > 0)) continue;
        const float by = lift_by(up, dot_lane(out->n, s->base, i), dot_lane(s->base, s->v, i));
        if (!(by > 0)) continue;
        for (int c = 0; c < 3; ++c) {
            n[c] = out->n[c][i] + by * s->base[c][i];
            square += n[c] * n[c];
        }
        for (int c = 0; c < 3; ++c) out->n[c][i] = n[c] / sqrtf(square);
    }
}

static void set_normals(const surface_block *s, shader_block *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float up = 0;
        for (int c = 0; c < 3; ++c) up += s->ns[c][i] * s->v[c][i];
        uint32_t seen = up > 0 ? ~0u : 0;
        for (int c = 0; c < 3; ++c) out->n[c][i] = chosen(seen, s->ns[c][i], s->ng[c][i]);
    }
    if (s->mapped) lift_normals(s, out);
}

/* A viewer exactly on the horizon is raised by float's rounding error. */
static void set_frames(const surface_block *s, shader_block *restrict out) {
    set_normals(s, out);
    for (int i = 0; i < LANES; ++i) {
        float t[3], b[3], x = 0, y = 0, z = 0;
        across(out->n[0][i], out->n[1][i], out->n[2][i], t, b);
        for (int c = 0; c < 3; ++c) {
            out->t[c][i] = t[c], out->b[c][i] = b[c];
            x += t[c] * s->v[c][i], y += b[c] * s->v[c][i], z += out->n[c][i] * s->v[c][i];
        }
        out->v[0][i] = x, out->v[1][i] = y, out->v[2][i] = z > 0x1p-23f ? z : 0x1p-23f;
    }
}

/* Aligns the frames with the surface's tangent, in anisotropic lanes that have one. */
static void stretch_frames(const surface_block *s, shader_block *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float t[3], n[3] = {out->n[0][i], out->n[1][i], out->n[2][i]}, square = 0, x = 0, y = 0;
        if (!(out->at[i]->lobes & SHADER_STRETCHED) || !(s->directed >> i & 1)) continue;
        const float up = dot_lane(s->along, out->n, i);
        for (int c = 0; c < 3; ++c) {
            t[c] = s->along[c][i] - up * n[c];
            square += t[c] * t[c];
        }
        if (!(square > 0x1p-40f)) continue;
        const float unit = 1 / sqrtf(square);
        for (int c = 0; c < 3; ++c) out->t[c][i] = t[c] * unit;
        for (int c = 0; c < 3; ++c) {
            const int d = (c + 1) % 3, e = (c + 2) % 3;
            out->b[c][i] = n[d] * out->t[e][i] - n[e] * out->t[d][i];
        }
        for (int c = 0; c < 3; ++c) {
            x += out->t[c][i] * s->v[c][i], y += out->b[c][i] * s->v[c][i];
        }
        out->v[0][i] = x, out->v[1][i] = y;
    }
}

/* The coat's normal, chosen as for smooth lobes: the first of its own normal, the surface's normal without a
 * map and the geometric normal that mirrors the viewer to no direction behind the surface. */
static const lanes3 *coat_normal(const surface_block *s, int i) {
    const lanes3 *const normals[2] = {&s->coat, &s->base};
    for (int k = 0; k < 2; ++k) {
        const float up = 2 * dot_lane(*normals[k], s->v, i);
        const bool above = up * dot_lane(*normals[k], s->ng, i) > dot_lane(s->v, s->ng, i) &&
                           up * dot_lane(*normals[k], s->base, i) > dot_lane(s->v, s->base, i);
        if (up > 0 && above) return normals[k];
    }
    return &s->ng;
}

/* The coats' own frames, if they have any; otherwise those of the block. */
static void turn_coats(const surface_block *s, shader_block *restrict out) {
    memset(out->coat_axes, 0, sizeof out->coat_axes);
    for (int i = 0; i < LANES; ++i) {
        for (int k = 0; k < 3; ++k) out->coat_axes[k][k][i] = 1;
        if (!(out->at[i]->lobes & SHADER_TURNED) || !(s->coated >> i & 1)) continue;
        const lanes3 *normal = coat_normal(s, i);
        float n[3] = {dot_lane(out->t, *normal, i), dot_lane(out->b, *normal, i),
                      dot_lane(out->n, *normal, i)};
        float t[3], b[3];
        across(n[0], n[1], n[2], t, b);
        for (int c = 0; c < 3; ++c)
            out->coat_axes[0][c][i] = t[c], out->coat_axes[1][c][i] = b[c], out->coat_axes[2][c][i] = n[c];
    }
    into_coat(out, out->v, out->coat_v);
    for (int i = 0; i < LANES; ++i) {
        out->coat_v[2][i] = out->coat_v[2][i] > 0x1p-23f ? out->coat_v[2][i] : 0x1p-23f;
        out->below_coat[i] = below_coat_at(out->at[i], out->coat_v[2][i]);
    }
}

/* Glass of the classic model, as MODEL.md describes it. */
static void set_classic(const surface_block *s, int i, shader_block *out) {
    const shader *m = out->at[i];
    const glass g = {
        {m->k_r[0], m->k_r[1], m->k_r[2]}, {m->k_t[0], m->k_t[1], m->k_t[2]}, m->ior, m->fresnel};
    glass_scatter(s, i, &g, out->mirror, out->mirror_share, out->pass, out->pass_share);
}

/* Attenuates transmission by the coat, and adds the mirror of a smooth coat. */
static void coat_flat(const shader *m, int i, shader_block *out) {
    const float rise = schlick(out->v[2][i], 1), far = dot_lane(out->n, out->pass, i);
    const float coat = m->lobes & SHADER_COAT ? 0 : m->coat * (0.04f + 0.96f * rise);
    for (int c = 0; c < 3; ++c) {
        out->mirror_share[c][i] += coat;
        out->pass_share[c][i] *= out->below_coat[i] * below_coat_at(m, least(fabsf(far), 1));
    }
}

/* Attenuates the smooth lobes by the fibres. */
static void sheen_flat(const shader *m, int i, shader_block *out) {
    float unused;
    const float far = sheen_left(m, dot_lane(out->n, out->pass, i), &unused);
    for (int c = 0; c < 3; ++c) {
        out->mirror_share[c][i] *= out->below_sheen[i];
        out->pass_share[c][i] *= least(out->below_sheen[i], far);
    }
}

/* The smooth lobes, of a facet parallel to the surface. Rough surfaces that transmit smoothly transmit the
 * light that their layer does not reflect at any order of scattering. */
static void set_flat(const surface_block *s, int i, shader_block *out) {
    const shader *m = out->at[i];
    const glass g = {.k_r = {1, 1, 1}, .k_t = {1, 1, 1}, .ior = dispersed_eta(m, out->channel[i])};
    const float eta = out->eta[i], up = out->v[2][i], rise = schlick(up, eta);
    const bool rare = m->lobes & SHADER_RARE;
    const bool rough = m->lobes & SHADER_GGX;
    const float coated = out->below_coat[i];
    glass_scatter(s, i, &g, out->mirror, out->mirror_share, out->pass, out->pass_share);
    for (int c = 0; c < 3; ++c) {
        const bool total = !(out->pass_share[c][i] > 0);
        float open = 1 - layer_of(out, rare, i, c, up, rise);
        if (rough && out->even[i] && !out->inside[i])
            open = is_filmed(out, rare, i) ? out->film_under[c][i] : out->under[i];
        const float f0 = m->mirror0[c] - (out->inside[i] && !rough ? m->base_f0[c] : 0);
        const float f90 = m->mirror90 - (out->inside[i] && !rough ? m->base_f90 : 0);
        const float mirror = reflectance_at(out, rare && !rough, i, c, up, rise, f0, f90);
        out->mirror_share[c][i] = mirror * coated * coated;
        out->pass_share[c][i] = m->lobes & SHADER_PASS && !total ? m->cross[c] * open : 0;
        if (eta == 1) out->pass[c][i] = -s->v[c][i];
    }
    if (m->lobes & SHADER_SHEEN) sheen_flat(m, i, out);
    if (m->lobes & SHADER_COATED) coat_flat(m, i, out);
}

static void set_smooth(const surface_block *s, shader_block *out) {
    memset(out->mirror_share, 0, sizeof out->mirror_share);
    memset(out->pass_share, 0, sizeof out->pass_share);
    if (!(out->lobes & (SHADER_CLASSIC | SHADER_MIRROR | SHADER_PASS))) return;
    for (int i = 0; i < LANES; ++i) {
        if (out->at[i]->lobes & SHADER_CLASSIC) set_classic(s, i, out);
        if (out->at[i]->lobes & (SHADER_MIRROR | SHADER_PASS)) set_flat(s, i, out);
    }
}

/* Approximate light that each lobe scatters to the viewer. A lobe that carries light never has a probability
 * of 0. Rough transmission keeps at least a tenth of its weight, even if a facet parallel to the surface
 * would transmit nothing. */
static void weigh_lobes(const surface_block *s, shader_block *restrict out) {
    for (int k = 0; k < SHADER_TAKES; ++k) {
        for (int i = 0; i < LANES; ++i) out->take[k][i] = 0;
    }
    for (int i = 0; i < LANES; ++i) {
        float d = mean(out->diffuse, i), open = chosen(out->even[i], out->under[i], 1);
        out->take[SHADER_TAKE_DIFFUSE][i] = d * (open > 0.1f ? open : 0.1f);
        out->take[SHADER_TAKE_BEHIND][i] = chosen(out->from_behind[i], d, 0);
        float f0 = mean(out->f0, i), rise = schlick(out->v[2][i], out->eta[i]);
        out->take[SHADER_TAKE_GGX][i] = f0 + (out->f90[i] - f0) * rise;
    }
    if (out->lobes & SHADER_FILM) {
        for (int i = 0; i < LANES; ++i) {
            if ((out->at[i]->lobes & (SHADER_FILM | SHADER_GGX)) != (SHADER_FILM | SHADER_GGX)) continue;
            const float up = out->v[2][i];
            float share = 0.02f; /* other angles may reflect more */
            for (int c = 0; c < 3; ++c) share += film_at(out, i, out->at[i]->film[c], up) * (1 / 3.0f);
            out->take[SHADER_TAKE_GGX][i] = share;
        }
    }
    if (out->lobes & SHADER_LEAF) {
        for (int i = 0; i < LANES; ++i) {
            const shader *m = out->at[i];
            float open = chosen(out->even[i], most(out->under[i], 0.1f), 1);
            if (m->lobes & SHADER_LEAF)
                out->take[SHADER_TAKE_BEHIND][i] +=
                    (m->leaf[0] + m->leaf[1] + m->leaf[2]) * (1 / 3.0f) * open;
        }
    }
    if (out->lobes & SHADER_SHEEN) {
        for (int i = 0; i < LANES; ++i) {
            const shader *m = out->at[i];
            if (m->lobes & SHADER_SHEEN) out->take[SHADER_TAKE_SHEEN][i] = 1.02f - out->below_sheen[i];
        }
    }
    if (out->lobes & SHADER_HIGHLIGHT) {
        for (int i = 0; i < LANES; ++i) {
            float n = out->shininess[i], spread = chosen(out->blinn[i], 8 / (n + 8), 2 / (n + 2));
            out->take[SHADER_TAKE_HIGHLIGHT][i] = mean(out->highlight, i) * spread;
        }
    }
    if (out->lobes & SHADER_EVEN) {
        for (int i = 0; i < LANES; ++i) {
            out->take[SHADER_TAKE_DIFFUSE][i] += out->at[i]->missing_share * out->missing[i];
            out->take[SHADER_TAKE_BEHIND][i] += out->at[i]->again_cross[1] > 0 ? out->missing[i] : 0;
        }
    }
    if (out->lobes & (SHADER_THIN | SHADER_REFRACT)) {
        for (int i = 0; i < LANES; ++i) {
            float open = 1 - layer_share(out, i, schlick(out->v[2][i], out->eta[i]));
            uint32_t rough = out->at[i]->lobes & (SHADER_THIN | SHADER_REFRACT) ? ~0u : 0;
            out->take[SHADER_TAKE_CROSS][i] = chosen(rough, mean(out->cross, i) * most(open, 0.1f), 0);
        }
    }
    if (out->lobes & SHADER_GLASS) {
        for (int i = 0; i < LANES; ++i) weigh_glass(s, i, out);
    }
    if (out->lobes & SHADER_COAT) {
        for (int i = 0; i < LANES; ++i) {
            float coat = out->at[i]->lobes & SHADER_COAT ? out->coat[i] : 0;
            out->take[SHADER_TAKE_COAT][i] = coat * (0.04f + 0.96f * schlick(out->v[2][i], 1));
        }
    }
    for (int i = 0; i < LANES; ++i) {
        out->take[SHADER_TAKE_MIRROR][i] = mean(out->mirror_share, i);
        out->take[SHADER_TAKE_PASS][i] = mean(out->pass_share, i);
    }
}

/* A hole is taken with the probability of its area, whatever the lobes reflect: the fraction of paths that
 * end at the surface is its coverage, which AOVs count. If no lobe carries light, the chances add up to less
 * than 1. */
static void share_holes(shader_block *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        const float hole = out->at[i]->hole;
        if (!(hole > 0)) continue;
        for (int k = 0; k < SHADER_TAKES; ++k) out->take[k][i] *= 1 - hole;
        out->take[SHADER_TAKE_STRAIGHT][i] = hole;
    }
}

/* Chances that add up to 1, or to 0; see share_holes(). */
static void share_lobes(shader_block *restrict out) {
    float sum[LANES];
    for (int i = 0; i < LANES; ++i) sum[i] = 0x1p-126f;
    for (int k = 0; k < SHADER_TAKES; ++k) {
        for (int i = 0; i < LANES; ++i) sum[i] += out->take[k][i];
    }
    for (int k = 0; k < SHADER_TAKES; ++k) {
        for (int i = 0; i < LANES; ++i) out->take[k][i] /= sum[i];
    }
    if (out->lobes & SHADER_STRAIGHT) share_holes(out);
}

/* weigh_lobes() and share_lobes() for the diffuse lobe alone. */
static void take_diffuse(shader_block *restrict out) {
    memset(out->take, 0, sizeof out->take);
    for (int i = 0; i < LANES; ++i) {
        const float d = mean(out->diffuse, i);
        out->take[SHADER_TAKE_DIFFUSE][i] = d / (0x1p-126f + d);
    }
}

static void make(const surface_block *s, shader_block *out) {
    set_materials(s, out);
    set_frames(s, out);
    if (out->lobes == SHADER_DIFFUSE) {
        take_diffuse(out);
        return;
    }
    if (out->lobes & SHADER_STRETCHED) stretch_frames(s, out);
    for (int i = 0; i < LANES; ++i) out->missing[i] = out->under[i] = 0, out->below_coat[i] = 1;
    if (out->lobes & (SHADER_EVEN | SHADER_COATED))
        read_curves(out, out->v[2], out->missing, out->under, out->below_coat);
    if (out->lobes & SHADER_TURNED) turn_coats(s, out);
    if (out->lobes & SHADER_STRETCHED) stretch_curves(out, out->v, out->missing, out->under);
    if (out->lobes & SHADER_FILM) set_films(out);
    if (out->lobes & SHADER_SOLID) open_inside(out, out->under);
    if (out->lobes & SHADER_SHEEN) {
        for (int i = 0; i < LANES; ++i) {
            const bool fibres = out->at[i]->lobes & SHADER_SHEEN;
            out->below_sheen[i] = sheen_left(out->at[i], out->v[2][i], &out->sheen_part[i]);
            out->sheen_lambda[i] = fibres ? sheen_lambda(out->at[i], out->v[2][i]) : 0;
        }
    }
    set_smooth(s, out);
    weigh_lobes(s, out);
    share_lobes(out);
}
