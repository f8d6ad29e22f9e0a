/* BSDFs for path tracing: blocks, values and densities, and sampled directions. */
#include "material/kernels/matte.h"

static void evaluate(const surface_block *s, const shader_block *b, const lanes3 l, float (*f)[LANES],
                     float density[LANES]) {
    incidence at;
    if (is_matte(s, b->lobes)) {
        evaluate_matte(s, b, l, f, density);
        return;
    }
    judge_sides(s, b, l, &at);
    add_lobes(s, b, l, &at, f, density);
}

/* ---- sampling ---- */

/* The lobe whose part of [0,1) holds u. If rounding leaves u beyond all parts, the last lobe is taken; but a
 * hole that is the only lobe is taken by its own part alone. */
static void choose_lobes(const shader_block *b, const float u[LANES], uint32_t *restrict lobe) {
    if (b->lobes == SHADER_DIFFUSE) {
        for (int i = 0; i < LANES; ++i)
            lobe[i] = b->take[SHADER_TAKE_DIFFUSE][i] > 0 ? SHADER_TAKE_DIFFUSE : SHADER_TAKES;
        return;
    }
    for (int i = 0; i < LANES; ++i) {
        float end = 0;
        uint32_t found = SHADER_TAKES;
        for (uint32_t k = 0; k < SHADER_TAKES; ++k) {
            float start = end, p = b->take[k][i];
            end += p;
            uint32_t open = ((found == SHADER_TAKES) | (u[i] >= start)) & (p > 0) ? ~0u : 0;
            found = (k & open) | (found & ~open);
        }
        const uint32_t past = (u[i] >= end) & (end == b->take[SHADER_TAKE_STRAIGHT][i]) ? ~0u : 0;
        lobe[i] = (SHADER_TAKES & past) | (found & ~past);
    }
}

static inline float root(float x) { return sqrtf(x > 0 ? x : 0); }

/* Samples proportionally to the cosine. */
static void sample_cosine(const uint32_t lobe[LANES], const lanes3 u, float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float r = sqrtf(u[0][i]), z = root(1 - u[0][i]), cosine, sine;
        turn_by(u[1][i], &cosine, &sine);
        l[0][i] = r * cosine, l[1][i] = r * sine;
        l[2][i] = chosen(lobe[i] == SHADER_TAKE_BEHIND ? ~0u : 0, -z, z);
    }
}

/* Samples uniformly over the hemisphere. */
static void sample_evenly(const lanes3 u, float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float r = sqrtf(u[0][i] * (2 - u[0][i])), cosine, sine;
        turn_by(u[1][i], &cosine, &sine);
        l[0][i] = r * cosine, l[1][i] = r * sine, l[2][i] = 1 - u[0][i];
    }
}

static inline void mirror_about(const lanes3 v, int i, float x, float y, float z, lanes3 l) {
    float twice = 2 * (v[0][i] * x + v[1][i] * y + v[2][i] * z);
    l[0][i] = twice * x - v[0][i];
    l[1][i] = twice * y - v[1][i];
    l[2][i] = twice * z - v[2][i];
}

/* Visible normals by spherical caps (Dupuy & Benyoub 2023). In the space where the distribution is a
 * hemisphere, h = cap + v, with the cap's z + v.z = (1-u)(1+v.z). The sine uses 1 - z computed from x and y,
 * because a difference of squares would cancel. */
static void sample_facets(const lanes3 v, const float along[LANES], const float alphas[LANES], const lanes3 u,
                          float (*restrict h)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float ax = along[i], ay = alphas[i], cosine, sine;
        float x = ax * v[0][i], y = ay * v[1][i], z = v[2][i];
        float unit = 1 / sqrtf(x * x + y * y + z * z);
        x *= unit, y *= unit, z *= unit;
        float up = (1 - u[1][i]) * (1 + z);
        float below = (x * x + y * y) / (1 + z); /* 1 - z */
        float r = root(u[1][i] * (1 + z) * (below + up));
        turn_by(u[0][i], &cosine, &sine);
        float hx = ax * (x + r * cosine), hy = ay * (y + r * sine);
        float square = hx * hx + hy * hy + up * up;
        float scale = 1 / sqrtf(square > 0x1p-120f ? square : 0x1p-120f);
        h[0][i] = hx * scale, h[1][i] = hy * scale, h[2][i] = up * scale;
    }
}

/* Through a thin wall: the mirrored direction, mirrored again by the wall. Through a solid: refracted about
 * the facet by Snell's law. On total reflection the result is v, which has a density of 0. */
static void sample_cross(const shader_block *b, const lanes3 h, float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float inverse = 1 / b->eta[i];
        float cosine = b->v[0][i] * h[0][i] + b->v[1][i] * h[1][i] + b->v[2][i] * h[2][i];
        float far2 = 1 - (1 - cosine) * (1 + cosine) * (inverse * inverse), far = root(far2);
        float thin = 2 * cosine, solid = cosine * inverse - far;
        uint32_t wall = b->eta[i] == 1 ? ~0u : 0, total = far2 > 0 ? 0 : ~0u;
        float of_h = chosen(wall, thin, solid), of_v = chosen(wall, 1, inverse);
        for (int c = 0; c < 3; ++c) {
            float d = of_h * h[c][i] - of_v * b->v[c][i];
            l[c][i] = chosen(total & ~wall, b->v[c][i], d);
        }
        l[2][i] = chosen(wall, -l[2][i], l[2][i]);
    }
}

/* 1 - u^k for the cosine of a power lobe, k = 2/(n+1) <= 2; u = 1 - d. If the exponent is small, a series
 * gives the exponential minus 1, so that a cosine near 1 keeps an accurate sine. */
static inline float one_less_power(float d, float k) {
    double y = power_exponent(d, k), x = y * 0.69314718055994531, plain = 1 - (double)power_exp2(y);
    double small =
        -x * (1 + x * (1 / 2.0 + x * (1 / 6.0 + x * (1 / 24.0 + x * (1 / 120.0 + x * (1 / 720.0))))));
    double is_small = x > -0.1 ? 1.0 : 0.0; /* a factor, because a conditional would become a branch */
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
        mirror_about(b->v, i, x, y, z, l);
        l[0][i] = chosen(b->blinn[i], l[0][i], t[0] * x + a[0] * y + mx * z);
        l[1][i] = chosen(b->blinn[i], l[1][i], t[1] * x + a[1] * y + my * z);
        l[2][i] = chosen(b->blinn[i], l[2][i], t[2] * x + a[2] * y + mz * z);
    }
}

static void take_lanes(const uint32_t lobe[LANES], uint32_t first, uint32_t last, const lanes3 from,
                       float (*restrict to)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        uint32_t mask = (lobe[i] >= first) & (lobe[i] <= last) ? ~0u : 0;
        for (int c = 0; c < 3; ++c) to[c][i] = chosen(mask, from[c][i], to[c][i]);
    }
}

static void sample_coat(const shader_block *b, const lanes3 u, float (*restrict l)[LANES]) {
    const bool turned = b->lobes & SHADER_TURNED;
    lanes3 h, own;
    const float(*v)[LANES] = turned ? b->coat_v : b->v;
    sample_facets(v, b->coat_alpha, b->coat_alpha, u, h);
    for (int i = 0; i < LANES; ++i) mirror_about(v, i, h[0][i], h[1][i], h[2][i], turned ? own : l);
    if (turned) out_of_coat(b, own, l);
}

/* In the block's frame; the normal, if no rough lobe is chosen. */
static void sample_rough(const surface_block *s, const shader_block *b, const lanes3 u,
                         const uint32_t lobe[LANES], lanes3 out) {
    lanes3 l, h;
    const uint32_t lobes = b->lobes;
    for (int i = 0; i < LANES; ++i) out[0][i] = out[1][i] = 0, out[2][i] = 1;
    if (lobes & (SHADER_DIFFUSE | SHADER_BEHIND | SHADER_EVEN | SHADER_LEAF)) {
        sample_cosine(lobe, u, l);
        take_lanes(lobe, SHADER_TAKE_DIFFUSE, SHADER_TAKE_BEHIND, l, out);
    }
    if (lobes & SHADER_HIGHLIGHT) {
        sample_highlight(b, u, l);
        take_lanes(lobe, SHADER_TAKE_HIGHLIGHT, SHADER_TAKE_HIGHLIGHT, l, out);
    }
    if (lobes & SHADER_SHEEN) {
        sample_evenly(u, l);
        take_lanes(lobe, SHADER_TAKE_SHEEN, SHADER_TAKE_SHEEN, l, out);
    }
    if (lobes & SHADER_COAT) {
        sample_coat(b, u, l);
        take_lanes(lobe, SHADER_TAKE_COAT, SHADER_TAKE_COAT, l, out);
    }
    if (!(lobes & (SHADER_GGX | SHADER_THIN | SHADER_REFRACT))) return;
    if (lobes & SHADER_STRETCHED) {
        float along[LANES];
        for (int i = 0; i < LANES; ++i) along[i] = is_stretched(b, true, i) ? b->at[i]->along : b->alpha[i];
        sample_facets(b->v, along, b->alpha, u, h);
    } else {
        sample_facets(b->v, b->alpha, b->alpha, u, h);
    }
    for (int i = 0; i < LANES; ++i) mirror_about(b->v, i, h[0][i], h[1][i], h[2][i], l);
    take_lanes(lobe, SHADER_TAKE_GGX, SHADER_TAKE_GGX, l, out);
    if (!(lobes & (SHADER_THIN | SHADER_REFRACT))) return;
    sample_cross(b, h, l);
    take_lanes(lobe, SHADER_TAKE_CROSS, SHADER_TAKE_CROSS, l, out);
    if (lobes & SHADER_GLASS) sample_glass(s, b, u, h, lobe, out);
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

#define SMOOTH (SHADER_CLASSIC | SHADER_MIRROR | SHADER_PASS | SHADER_STRAIGHT)

static void take_smooth(const surface_block *s, const shader_block *b, const uint32_t lobe[LANES],
                        shader_sample *out) {
    for (int i = 0; i < LANES; ++i) {
        if (lobe[i] < SHADER_TAKE_MIRROR || lobe[i] == SHADER_TAKES) continue;
        const bool cross = lobe[i] == SHADER_TAKE_PASS, past = lobe[i] == SHADER_TAKE_STRAIGHT;
        const float chance = b->take[lobe[i]][i];
        for (int c = 0; c < 3; ++c) {
            const float share = past ? b->at[i]->hole : cross ? b->pass_share[c][i] : b->mirror_share[c][i];
            const bool straight = past || (cross && b->at[i]->clear);
            out->direction[c][i] = straight ? -s->v[c][i] : cross ? b->pass[c][i] : b->mirror[c][i];
            out->weight[c][i] = limited(share / chance);
        }
        out->density[i] = INFINITY;
        out->through[i] = cross || past ? ~0u : 0;
        out->pane[i] = cross && b->at[i]->clear ? ~0u : 0;
        out->straight[i] = past ? ~0u : out->pane[i];
    }
}

static inline uint32_t is(uint32_t lobe, uint32_t take) { return lobe == take ? ~0u : 0; }

/* True if the direction is on the side of its lobe. A sampled facet may give the wrong side, and a half
 * vector behind the viewer (Blinn) the opposite one; the densities of other lobes do not count then. */
static inline uint32_t meant(const shader_block *b, const incidence *at, uint32_t lobe, int i) {
    uint32_t front = is(lobe, SHADER_TAKE_DIFFUSE) | is(lobe, SHADER_TAKE_GGX) | is(lobe, SHADER_TAKE_SHEEN);
    uint32_t coat = is(lobe, SHADER_TAKE_COAT);
    uint32_t back = is(lobe, SHADER_TAKE_BEHIND) | is(lobe, SHADER_TAKE_CROSS);
    if (b->lobes & SHADER_GLASS && is_glass(b, i)) front |= is(lobe, SHADER_TAKE_CROSS);
    const uint32_t half = ~b->blinn[i] | (at->l[2][i] + b->v[2][i] > 0 ? ~0u : 0);
    return (front & at->reflected[i]) | (coat & at->coated[i]) | (back & at->cross[i]) |
           (is(lobe, SHADER_TAKE_HIGHLIGHT) & half);
}

static void sample(const surface_block *s, const shader_block *b, const lanes3 u,
                   shader_sample *restrict out) {
    uint32_t lobe[LANES];
    lanes3 l;
    incidence at;
    if (is_matte(s, b->lobes)) {
        sample_matte(s, b, u, out);
        return;
    }
    choose_lobes(b, u[2], lobe);
    sample_rough(s, b, u, lobe, l);
    to_world(b, l, out->direction);
    judge_sides(s, b, out->direction, &at);
    add_lobes(s, b, out->direction, &at, out->weight, out->density);
    for (int i = 0; i < LANES; ++i) {
        uint32_t some = (out->density[i] > 0 ? ~0u : 0) & meant(b, &at, lobe[i], i);
        float inverse = chosen(some, 1 / (out->density[i] + 0x1p-126f), 0);
        out->density[i] = chosen(some, out->density[i], 0);
        for (int c = 0; c < 3; ++c) out->weight[c][i] = limited(out->weight[c][i] * inverse);
        out->through[i] = at.cross[i], out->straight[i] = out->pane[i] = 0;
    }
    if (b->lobes & SMOOTH) take_smooth(s, b, lobe, out);
}

static void make_any(const surface_block *s, shader_block *out) {
    if (!make_matte(s, out)) make(s, out);
}

const shader_kernels KERNEL(shader_kernels) = {
    .make = make_any,
    .evaluate = evaluate,
    .sample = sample,
};
