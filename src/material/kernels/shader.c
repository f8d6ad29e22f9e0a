/* BSDFs under path tracing: blocks, values and densities, and sampled directions. */
#include "material/shader.h"
#include "base/kernel.h"
#include "material/kernels/glass.h"
#include "material/kernels/highlight.h"
#include "math/limit.h"
#include "math/turn.h"

#include <math.h>

#define PI 3.14159265f

static inline float mean(const lanes3 x, int i) { return (x[0][i] + x[1][i] + x[2][i]) * (1 / 3.0f); }

static inline float power5(float x) {
    float x2 = x * x;
    return x2 * x2 * x;
}

/* ---- the block ---- */

static inline void set_lane(const shader *m, int i, shader_block *out) {
    for (int c = 0; c < 3; ++c) {
        out->diffuse[c][i] = m->diffuse[c];
        out->highlight[c][i] = m->highlight[c];
        out->f0[c][i] = m->f0[c];
    }
    out->shininess[i] = m->shininess;
    out->alpha[i] = m->alpha;
    out->f90[i] = m->f90;
    out->layer0[i] = m->layer0;
    out->layer90[i] = m->layer90;
    out->phong[i] = m->phong;
    out->blinn[i] = m->blinn;
    out->from_behind[i] = m->from_behind;
}

/* Most blocks see one material: a loop over lanes that copies the same numbers vectorises. */
static void set_materials(const shader *table, const surface_block *s, shader_block *restrict out) {
    uint32_t differ = 0;
    for (int i = 1; i < LANES; ++i) differ |= s->material[i] ^ s->material[0];
    if (differ) {
        out->lobes = 0;
        for (int i = 0; i < LANES; ++i) {
            out->lobes |= table[s->material[i]].lobes;
            set_lane(&table[s->material[i]], i, out);
        }
    } else {
        const shader m = table[s->material[0]];
        out->lobes = m.lobes;
        for (int i = 0; i < LANES; ++i) set_lane(&m, i, out);
    }
}

/* Two axes across n (Duff et al., JCGT 2017). */
static inline void across(float x, float y, float z, float t[3], float b[3]) {
    float sign = copysignf(1, z), a = -1 / (sign + z), xy = x * y * a;
    t[0] = 1 + sign * x * x * a, t[1] = sign * xy, t[2] = -sign * x;
    b[0] = xy, b[1] = sign + y * y * a, b[2] = -y;
}

/* A viewer on the very horizon is lifted off it by float's roundoff. */
static void set_frames(const surface_block *s, shader_block *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float up = 0, t[3], b[3];
        for (int c = 0; c < 3; ++c) up += s->ns[c][i] * s->v[c][i];
        uint32_t seen = up > 0 ? ~0u : 0;
        for (int c = 0; c < 3; ++c) out->n[c][i] = chosen(seen, s->ns[c][i], s->ng[c][i]);
        across(out->n[0][i], out->n[1][i], out->n[2][i], t, b);
        float x = 0, y = 0, z = 0;
        for (int c = 0; c < 3; ++c) {
            out->t[c][i] = t[c], out->b[c][i] = b[c];
            x += t[c] * s->v[c][i], y += b[c] * s->v[c][i], z += out->n[c][i] * s->v[c][i];
        }
        out->v[0][i] = x, out->v[1][i] = y, out->v[2][i] = z > 0x1p-23f ? z : 0x1p-23f;
    }
}

/* Directions and shares of the smooth lobes. */
static void set_smooth(const shader *table, const surface_block *s, shader_block *out) {
    memset(out->mirror_share, 0, sizeof out->mirror_share);
    memset(out->cross_share, 0, sizeof out->cross_share);
    if (!(out->lobes & (SHADER_CLASSIC | SHADER_MIRROR))) return;
    for (int i = 0; i < LANES; ++i) {
        const shader *m = &table[s->material[i]];
        glass g = {{m->k_r[0], m->k_r[1], m->k_r[2]}, {m->k_t[0], m->k_t[1], m->k_t[2]}, m->ior, m->fresnel};
        if (m->lobes & SHADER_MIRROR) {
            float rise = power5(1 - fminf(out->v[2][i], 1));
            for (int c = 0; c < 3; ++c) g.k_r[c] = m->mirror0[c] + (m->mirror90 - m->mirror0[c]) * rise;
        }
        glass_scatter(s, i, &g, out->mirror, out->mirror_share, out->cross, out->cross_share);
    }
}

/* About what the rough lobe reflects: all lobes must be able to find what they carry, so none of them gets
 * less than its share of the reflectance. */
static inline float rough_weight(const shader_block *b, int i) {
    float rise = power5(1 - fminf(b->v[2][i], 1)), n = b->shininess[i];
    float spread = chosen(b->phong[i], 2 / (n + 2), chosen(b->blinn[i], 8 / (n + 8), 0));
    float f0 = mean(b->f0, i);
    return mean(b->highlight, i) * spread + f0 + (b->f90[i] - f0) * rise;
}

static void set_chances(shader_block *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float behind = chosen(out->from_behind[i], mean(out->highlight, i), 0);
        out->take[SHADER_TAKE_DIFFUSE][i] = mean(out->diffuse, i) + behind;
        out->take[SHADER_TAKE_ROUGH][i] = rough_weight(out, i);
        out->take[SHADER_TAKE_MIRROR][i] = mean(out->mirror_share, i);
        out->take[SHADER_TAKE_REFRACT][i] = mean(out->cross_share, i);
    }
    for (int i = 0; i < LANES; ++i) {
        float sum = 0x1p-126f;
        for (int k = 0; k < SHADER_TAKES; ++k) sum += out->take[k][i];
        for (int k = 0; k < SHADER_TAKES; ++k) out->take[k][i] /= sum;
    }
}

static void make(const shader *table, const surface_block *s, shader_block *out) {
    set_materials(table, s, out);
    set_frames(s, out);
    set_smooth(table, s, out);
    set_chances(out);
}

/* ---- light from one direction ---- */

typedef struct incidence {
    _Alignas(64) lanes3 l;                   /* in the block's frame */
    uint32_t reflected[LANES], cross[LANES]; /* all ones: l is on the viewer's side, or on the other */
} incidence;

static void judge_sides(const surface_block *s, const shader_block *b, const lanes3 l,
                        incidence *restrict out) {
    for (int i = 0; i < LANES; ++i) {
        float x = 0, y = 0, z = 0, side = 0;
        for (int c = 0; c < 3; ++c) {
            x += b->t[c][i] * l[c][i], y += b->b[c][i] * l[c][i], z += b->n[c][i] * l[c][i];
            side += s->ng[c][i] * l[c][i];
        }
        side = chosen(s->smooth[i], z, side);
        out->l[0][i] = x, out->l[1][i] = y, out->l[2][i] = z;
        out->reflected[i] = (z > 0 ? ~0u : 0) & (side > 0 ? ~0u : 0);
        out->cross[i] = (z < 0 ? ~0u : 0) & (side < 0 ? ~0u : 0);
    }
}

/* The half vector, and Schlick's (1 - v·h)^5. Opposite directions have none, and get the normal. */
static void set_half(const shader_block *b, const incidence *at, lanes3 h, float *restrict rise) {
    for (int i = 0; i < LANES; ++i) {
        float x = b->v[0][i] + at->l[0][i], y = b->v[1][i] + at->l[1][i], z = b->v[2][i] + at->l[2][i];
        float square = x * x + y * y + z * z, unit = 1 / sqrtf(square > 0x1p-60f ? square : 0x1p-60f);
        h[0][i] = x * unit, h[1][i] = y * unit, h[2][i] = z * unit;
        float cosine = b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
        cosine = cosine < 1 ? (cosine > 0 ? cosine : 0) : 1;
        rise[i] = power5(1 - cosine);
    }
}

/* sqrt(cos^2 + alpha^2 sin^2): Smith's masking is G1 = 2 cos / (cos + it), and of both directions together
 * G2 / (4 cos cos') = 1 / (2 (cos it' + cos' it)) (Heitz 2014). */
static inline float smith(float a2, float x, float y, float z) { return sqrtf(a2 * (x * x + y * y) + z * z); }

/* Trowbridge & Reitz's distribution, from the sine of h, which keeps its digits where alpha is small. */
static inline float ggx(float a2, float hx, float hy, float hz) {
    float t = hx * hx + hy * hy + a2 * (hz * hz);
    return a2 / (PI * t * t);
}

static void add_ggx(const shader_block *b, const incidence *at, const lanes3 h, const float rise[LANES],
                    float (*restrict f)[LANES], float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        float a2 = b->alpha[i] * b->alpha[i], z = b->v[2][i], lz = at->l[2][i];
        float to = smith(a2, b->v[0][i], b->v[1][i], z), from = smith(a2, at->l[0][i], at->l[1][i], lz);
        float d = ggx(a2, h[0][i], h[1][i], h[2][i]);
        float value = chosen(at->reflected[i], d * lz / (2 * (z * from + lz * to)), 0);
        for (int c = 0; c < 3; ++c) f[c][i] += (b->f0[c][i] + (b->f90[i] - b->f0[c][i]) * rise[i]) * value;
        float chance = chosen(b->phong[i] | b->blinn[i], 0, b->take[SHADER_TAKE_ROUGH][i]);
        density[i] += chosen(at->reflected[i], chance * d / (2 * (z + to)), 0);
    }
}

/* Lambert's lobe under what the dielectric layer leaves. */
static void add_diffuse(const shader_block *b, const incidence *at, const float rise[LANES],
                        float (*restrict f)[LANES], float *restrict density) {
    for (int i = 0; i < LANES; ++i) {
        uint32_t lit = at->reflected[i] | (at->cross[i] & b->from_behind[i]);
        float cosine = chosen(lit, fabsf(at->l[2][i]) * (1 / PI), 0);
        float left = 1 - (b->layer0[i] + (b->layer90[i] - b->layer0[i]) * rise[i]);
        for (int c = 0; c < 3; ++c) f[c][i] += b->diffuse[c][i] * left * cosine;
        density[i] += b->take[SHADER_TAKE_DIFFUSE][i] * chosen(b->from_behind[i], 0.5f, 1) * cosine;
    }
}

/* Phong's lobe is sampled by (n+1)/2pi (r·l)^n about the mirrored viewer, Blinn's by the same of the half
 * vector, whose solid angle is 1 / (4 v·h) of the direction's. */
static void add_highlight(const surface_block *s, const shader_block *b, const incidence *at, const lanes3 l,
                          const lanes3 h, float (*restrict f)[LANES], float *restrict density) {
    float rho[LANES] = {0};
    highlight(b->n, s->v, b->phong, b->blinn, b->shininess, l, at->l[2], rho);
    for (int i = 0; i < LANES; ++i) {
        uint32_t lit = at->reflected[i] | (at->cross[i] & b->from_behind[i]);
        float value = chosen(lit, rho[i] * (1 / PI) * fabsf(at->l[2][i]), 0);
        for (int c = 0; c < 3; ++c) f[c][i] += b->highlight[c][i] * value;
        float cosine = b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
        float wide = chosen(b->blinn[i], 4 * (cosine > 0x1p-23f ? cosine : 0x1p-23f), 1);
        float d = rho[i] * (b->shininess[i] + 1) / (2 * PI * wide);
        uint32_t has = lit & (b->phong[i] | b->blinn[i]);
        density[i] += chosen(has, b->take[SHADER_TAKE_ROUGH][i] * d, 0);
    }
}

static void add_lobes(const surface_block *s, const shader_block *b, const lanes3 l, const incidence *at,
                      float (*restrict f)[LANES], float *restrict density) {
    lanes3 h = {{0}};
    float rise[LANES] = {0};
    for (int i = 0; i < LANES; ++i) f[0][i] = f[1][i] = f[2][i] = density[i] = 0;
    if (b->lobes & (SHADER_LAYER | SHADER_GGX | SHADER_HIGHLIGHT)) set_half(b, at, h, rise);
    if (b->lobes & (SHADER_DIFFUSE | SHADER_HIGHLIGHT)) add_diffuse(b, at, rise, f, density);
    if (b->lobes & SHADER_HIGHLIGHT) add_highlight(s, b, at, l, h, f, density);
    if (b->lobes & SHADER_GGX) add_ggx(b, at, h, rise, f, density);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) f[c][i] = limited(f[c][i]);
    }
}

static void evaluate(const surface_block *s, const shader_block *b, const lanes3 l, float (*f)[LANES],
                     float density[LANES]) {
    incidence at;
    judge_sides(s, b, l, &at);
    add_lobes(s, b, l, &at, f, density);
}

/* ---- sampling ---- */

/* The lobe whose part of [0,1) holds u, and where in that part it is. Where rounding leaves u beyond all
 * parts, the last lobe is taken. */
static void choose_lobes(const shader_block *b, const float u[LANES], uint32_t *restrict lobe,
                         float *restrict within) {
    for (int i = 0; i < LANES; ++i) {
        float end = 0, from = 0, chance = 1;
        uint32_t found = SHADER_TAKES;
        for (uint32_t k = 0; k < SHADER_TAKES; ++k) {
            float start = end, p = b->take[k][i];
            end += p;
            uint32_t open = (found == SHADER_TAKES || u[i] >= start) && p > 0 ? ~0u : 0;
            found = (k & open) | (found & ~open);
            from = chosen(open, start, from);
            chance = chosen(open, p, chance);
        }
        float part = (u[i] - from) / chance;
        lobe[i] = found;
        within[i] = part < 0x1.fffffep-1f ? part : 0x1.fffffep-1f;
    }
}

static inline float root(float x) { return sqrtf(x > 0 ? x : 0); }

/* By the cosine; half of them behind, where light from there counts. */
static void sample_diffuse(const shader_block *b, const lanes3 u, const float within[LANES],
                           float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float r = sqrtf(u[0][i]), cosine, sine;
        turn_by(u[1][i], &cosine, &sine);
        uint32_t behind = (within[i] >= 0.5f ? ~0u : 0) & b->from_behind[i];
        float z = root(1 - u[0][i]);
        l[0][i] = r * cosine, l[1][i] = r * sine, l[2][i] = chosen(behind, -z, z);
    }
}

static inline void mirror_about(const shader_block *b, int i, float x, float y, float z, lanes3 l) {
    float twice = 2 * (b->v[0][i] * x + b->v[1][i] * y + b->v[2][i] * z);
    l[0][i] = twice * x - b->v[0][i];
    l[1][i] = twice * y - b->v[1][i];
    l[2][i] = twice * z - b->v[2][i];
}

/* Visible normals by spherical caps (Dupuy & Benyoub 2023). In the space where the distribution is a
 * hemisphere, h = cap + v with the cap's z + v.z = (1-u)(1+v.z); sines come from what is left of 1, not from
 * squares that cancel. */
static void sample_ggx(const shader_block *b, const lanes3 u, float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float alpha = b->alpha[i], cosine, sine;
        float x = alpha * b->v[0][i], y = alpha * b->v[1][i], z = b->v[2][i];
        float unit = 1 / sqrtf(x * x + y * y + z * z);
        x *= unit, y *= unit, z *= unit;
        float up = (1 - u[1][i]) * (1 + z);
        float below = (x * x + y * y) / (1 + z); /* 1 - z */
        float r = root(u[1][i] * (1 + z) * (below + up));
        turn_by(u[0][i], &cosine, &sine);
        float hx = alpha * (x + r * cosine), hy = alpha * (y + r * sine);
        float square = hx * hx + hy * hy + up * up;
        float scale = 1 / sqrtf(square > 0x1p-120f ? square : 0x1p-120f);
        mirror_about(b, i, hx * scale, hy * scale, up * scale, l);
    }
}

/* 1 - u^k for the cosine of a power lobe, k = 2/(n+1) <= 2; u = 1 - d. The exponential less 1 by its series
 * where it is small, so that a cosine near 1 has its sine. */
static inline float one_less_power(float d, float k) {
    double y = power_exponent(d, k), x = y * 0.69314718055994531, plain = 1 - (double)power_exp2(y);
    double small =
        -x * (1 + x * (1 / 2.0 + x * (1 / 6.0 + x * (1 / 24.0 + x * (1 / 120.0 + x * (1 / 720.0))))));
    double is_small = x > -0.1 ? 1.0 : 0.0; /* a factor, where a choice would become a branch */
    return (float)(is_small * small + (1 - is_small) * plain);
}

static void sample_highlight(const shader_block *b, const lanes3 u, float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float square = one_less_power(u[0][i], 2 / (b->shininess[i] + 1)), cosine, sine, t[3], a[3];
        square = square < 1 ? square : 1;
        turn_by(u[1][i], &cosine, &sine);
        float x = root(square) * cosine, y = root(square) * sine, z = root(1 - square);
        float mx = -b->v[0][i], my = -b->v[1][i], mz = b->v[2][i];
        across(mx, my, mz, t, a);
        mirror_about(b, i, x, y, z, l);
        l[0][i] = chosen(b->phong[i], t[0] * x + a[0] * y + mx * z, l[0][i]);
        l[1][i] = chosen(b->phong[i], t[1] * x + a[1] * y + my * z, l[1][i]);
        l[2][i] = chosen(b->phong[i], t[2] * x + a[2] * y + mz * z, l[2][i]);
    }
}

static void take_lanes(const uint32_t take[LANES], const lanes3 from, float (*restrict to)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) to[c][i] = chosen(take[i], from[c][i], to[c][i]);
    }
}

/* In the block's frame; the normal, where no rough lobe is chosen. */
static void sample_rough(const shader_block *b, const lanes3 u, const uint32_t lobe[LANES],
                         const float within[LANES], lanes3 out) {
    uint32_t mask[LANES];
    lanes3 l;
    for (int i = 0; i < LANES; ++i) out[0][i] = out[1][i] = 0, out[2][i] = 1;
    if (b->lobes & (SHADER_DIFFUSE | SHADER_HIGHLIGHT)) {
        for (int i = 0; i < LANES; ++i) mask[i] = lobe[i] == SHADER_TAKE_DIFFUSE ? ~0u : 0;
        sample_diffuse(b, u, within, l);
        take_lanes(mask, l, out);
    }
    for (int i = 0; i < LANES; ++i) mask[i] = lobe[i] == SHADER_TAKE_ROUGH ? ~0u : 0;
    if (b->lobes & SHADER_GGX) {
        sample_ggx(b, u, l);
        take_lanes(mask, l, out);
    }
    if (b->lobes & SHADER_HIGHLIGHT) {
        for (int i = 0; i < LANES; ++i) mask[i] &= b->phong[i] | b->blinn[i];
        sample_highlight(b, u, l);
        take_lanes(mask, l, out);
    }
}

static void to_world(const shader_block *b, const lanes3 l, float (*restrict out)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float d[3], square = 0;
        for (int c = 0; c < 3; ++c) {
            d[c] = b->t[c][i] * l[0][i] + b->b[c][i] * l[1][i] + b->n[c][i] * l[2][i];
            square += d[c] * d[c];
        }
        float unit = 1 / sqrtf(square);
        for (int c = 0; c < 3; ++c) out[c][i] = d[c] * unit;
    }
}

static void take_smooth(const shader_block *b, const uint32_t lobe[LANES], shader_sample *out) {
    for (int i = 0; i < LANES; ++i) {
        if (lobe[i] != SHADER_TAKE_MIRROR && lobe[i] != SHADER_TAKE_REFRACT) continue;
        const bool cross = lobe[i] == SHADER_TAKE_REFRACT;
        const float chance = b->take[lobe[i]][i];
        for (int c = 0; c < 3; ++c) {
            out->direction[c][i] = cross ? b->cross[c][i] : b->mirror[c][i];
            out->weight[c][i] = limited((cross ? b->cross_share[c][i] : b->mirror_share[c][i]) / chance);
        }
        out->density[i] = INFINITY;
        out->through[i] = cross ? ~0u : 0;
    }
}

static void sample(const surface_block *s, const shader_block *b, const lanes3 u,
                   shader_sample *restrict out) {
    uint32_t lobe[LANES];
    float within[LANES];
    lanes3 l;
    incidence at;
    choose_lobes(b, u[2], lobe, within);
    sample_rough(b, u, lobe, within, l);
    to_world(b, l, out->direction);
    judge_sides(s, b, out->direction, &at);
    add_lobes(s, b, out->direction, &at, out->weight, out->density);
    for (int i = 0; i < LANES; ++i) {
        uint32_t some = out->density[i] > 0 && lobe[i] < SHADER_TAKES ? ~0u : 0;
        float inverse = chosen(some, 1 / (out->density[i] + 0x1p-126f), 0);
        for (int c = 0; c < 3; ++c) out->weight[c][i] = limited(out->weight[c][i] * inverse);
        out->through[i] = at.cross[i];
    }
    if (b->lobes & (SHADER_CLASSIC | SHADER_MIRROR)) take_smooth(b, lobe, out);
}

const shader_kernels KERNEL(shader_kernels) = {
    .make = make,
    .evaluate = evaluate,
    .sample = sample,
};
