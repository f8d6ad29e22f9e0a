/* BSDFs under path tracing: blocks, values and densities, and sampled directions. */
#include "material/kernels/glass.h"
#include "material/kernels/lobes.h"
#include "math/turn.h"

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

/* A viewer inside a solid sees its base as without what scatters again. */
static inline void set_cross(const shader *m, int i, uint32_t entering, shader_block *restrict out) {
    set_colour(m->cross, i, out->cross);
    out->eta[i] = chosen(entering, m->eta, 1 / m->eta);
    out->even[i] = m->even & (out->eta[i] == m->eta ? ~0u : 0);
}

static inline void set_coat(const shader *m, int i, shader_block *restrict out) {
    out->coat[i] = m->coat;
    out->coat_alpha[i] = m->coat_alpha;
}

#define CROSSING (SHADER_THIN | SHADER_REFRACT | SHADER_PASS | SHADER_SOLID)

/* The constants that the block's lobes read. Most blocks see one material: loops over lanes that copy the
 * same numbers vectorise. */
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
        for (int i = 0; i < LANES; ++i) out->eta[i] = 1, out->even[i] = at[i]->even;
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

/* Glass of the classic model: as MODEL.md has it. */
static void set_classic(const surface_block *s, int i, shader_block *out) {
    const shader *m = out->at[i];
    const glass g = {
        {m->k_r[0], m->k_r[1], m->k_r[2]}, {m->k_t[0], m->k_t[1], m->k_t[2]}, m->ior, m->fresnel};
    glass_scatter(s, i, &g, out->mirror, out->mirror_share, out->pass, out->pass_share);
}

/* Light through the coat, and the mirror of a smooth one. */
static void coat_flat(const shader *m, int i, shader_block *out) {
    const float rise = schlick(out->v[2][i], 1), far = dot_lane(out->n, out->pass, i);
    const float coat = m->lobes & SHADER_COAT ? 0 : m->coat * (0.04f + 0.96f * rise);
    for (int c = 0; c < 3; ++c) {
        out->mirror_share[c][i] += coat;
        out->pass_share[c][i] *= out->below_coat[i] * curve_at(m->below_coat, fminf(fabsf(far), 1));
    }
}

/* A facet that lies in the surface. Rough surfaces that transmit smoothly let through what their layer does
 * not reflect in all. */
static void set_flat(const surface_block *s, int i, shader_block *out) {
    const shader *m = out->at[i];
    const glass g = {.k_r = {1, 1, 1}, .k_t = {1, 1, 1}, .ior = m->eta};
    const float eta = out->eta[i], rise = schlick(out->v[2][i], eta);
    const bool rough = m->lobes & SHADER_GGX;
    const float coated = out->below_coat[i];
    float open = 1 - layer_share(out, i, rise);
    if (rough && out->even[i]) open = out->under[i];
    glass_scatter(s, i, &g, out->mirror, out->mirror_share, out->pass, out->pass_share);
    for (int c = 0; c < 3; ++c) {
        const bool total = !(out->pass_share[c][i] > 0);
        out->mirror_share[c][i] = (m->mirror0[c] + (m->mirror90 - m->mirror0[c]) * rise) * coated * coated;
        out->pass_share[c][i] = m->lobes & SHADER_PASS && !total ? m->cross[c] * open : 0;
        if (eta == 1) out->pass[c][i] = -s->v[c][i];
    }
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

/* About what each lobe sends to the viewer. None that carries light has a chance of 0, and rough transmission
 * keeps a tenth of its own where a facet along the surface would send nothing through. */
static void weigh_lobes(shader_block *restrict out) {
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
            out->take[SHADER_TAKE_CROSS][i] = chosen(rough, mean(out->cross, i) * fmaxf(open, 0.1f), 0);
        }
    }
    if (out->lobes & SHADER_COAT) {
        for (int i = 0; i < LANES; ++i) {
            float coat = out->at[i]->lobes & SHADER_COAT ? out->coat[i] : 0;
            out->take[SHADER_TAKE_COAT][i] = coat * (0.04f + 0.96f * schlick(out->v[2][i], 1));
        }
    }
    for (int i = 0; i < LANES; ++i) {
        out->take[SHADER_TAKE_STRAIGHT][i] = out->at[i]->hole;
        out->take[SHADER_TAKE_MIRROR][i] = mean(out->mirror_share, i);
        out->take[SHADER_TAKE_PASS][i] = mean(out->pass_share, i);
    }
}

static void make(const surface_block *s, shader_block *out) {
    set_materials(s, out);
    set_frames(s, out);
    for (int i = 0; i < LANES; ++i) out->missing[i] = out->under[i] = 0, out->below_coat[i] = 1;
    if (out->lobes & (SHADER_EVEN | SHADER_COATED))
        read_curves(out, out->v[2], out->missing, out->under, out->below_coat);
    set_smooth(s, out);
    weigh_lobes(out);
    for (int i = 0; i < LANES; ++i) {
        float sum = 0x1p-126f;
        for (int k = 0; k < SHADER_TAKES; ++k) sum += out->take[k][i];
        for (int k = 0; k < SHADER_TAKES; ++k) out->take[k][i] /= sum;
    }
}

static void evaluate(const surface_block *s, const shader_block *b, const lanes3 l, float (*f)[LANES],
                     float density[LANES]) {
    incidence at;
    judge_sides(s, b, l, &at);
    add_lobes(s, b, l, &at, f, density);
}

/* ---- sampling ---- */

/* The lobe whose part of [0,1) holds u. Where rounding leaves u beyond all parts, the last lobe is taken. */
static void choose_lobes(const shader_block *b, const float u[LANES], uint32_t *restrict lobe) {
    for (int i = 0; i < LANES; ++i) {
        float end = 0;
        uint32_t found = SHADER_TAKES;
        for (uint32_t k = 0; k < SHADER_TAKES; ++k) {
            float start = end, p = b->take[k][i];
            end += p;
            uint32_t open = ((found == SHADER_TAKES) | (u[i] >= start)) & (p > 0) ? ~0u : 0;
            found = (k & open) | (found & ~open);
        }
        lobe[i] = found;
    }
}

static inline float root(float x) { return sqrtf(x > 0 ? x : 0); }

/* By the cosine. */
static void sample_cosine(const uint32_t lobe[LANES], const lanes3 u, float (*restrict l)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float r = sqrtf(u[0][i]), z = root(1 - u[0][i]), cosine, sine;
        turn_by(u[1][i], &cosine, &sine);
        l[0][i] = r * cosine, l[1][i] = r * sine;
        l[2][i] = chosen(lobe[i] == SHADER_TAKE_BEHIND ? ~0u : 0, -z, z);
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
static void sample_facets(const shader_block *b, const float alphas[LANES], const lanes3 u,
                          float (*restrict h)[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float alpha = alphas[i], cosine, sine;
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
        h[0][i] = hx * scale, h[1][i] = hy * scale, h[2][i] = up * scale;
    }
}

/* Through a thin wall: the mirrored direction, mirrored again by the wall. Through a solid: by Snell's law
 * about the facet; straight back where it reflects all, which no density has. */
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

/* In the block's frame; the normal, where no rough lobe is chosen. */
static void sample_rough(const shader_block *b, const lanes3 u, const uint32_t lobe[LANES], lanes3 out) {
    lanes3 l, h;
    const uint32_t lobes = b->lobes;
    for (int i = 0; i < LANES; ++i) out[0][i] = out[1][i] = 0, out[2][i] = 1;
    if (lobes & (SHADER_DIFFUSE | SHADER_BEHIND | SHADER_EVEN)) {
        sample_cosine(lobe, u, l);
        take_lanes(lobe, SHADER_TAKE_DIFFUSE, SHADER_TAKE_BEHIND, l, out);
    }
    if (lobes & SHADER_HIGHLIGHT) {
        sample_highlight(b, u, l);
        take_lanes(lobe, SHADER_TAKE_HIGHLIGHT, SHADER_TAKE_HIGHLIGHT, l, out);
    }
    if (lobes & SHADER_COAT) {
        sample_facets(b, b->coat_alpha, u, h);
        for (int i = 0; i < LANES; ++i) mirror_about(b, i, h[0][i], h[1][i], h[2][i], l);
        take_lanes(lobe, SHADER_TAKE_COAT, SHADER_TAKE_COAT, l, out);
    }
    if (!(lobes & (SHADER_GGX | SHADER_THIN | SHADER_REFRACT))) return;
    sample_facets(b, b->alpha, u, h);
    for (int i = 0; i < LANES; ++i) mirror_about(b, i, h[0][i], h[1][i], h[2][i], l);
    take_lanes(lobe, SHADER_TAKE_GGX, SHADER_TAKE_GGX, l, out);
    if (!(lobes & (SHADER_THIN | SHADER_REFRACT))) return;
    sample_cross(b, h, l);
    take_lanes(lobe, SHADER_TAKE_CROSS, SHADER_TAKE_CROSS, l, out);
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
            out->direction[c][i] = past ? -s->v[c][i] : cross ? b->pass[c][i] : b->mirror[c][i];
            out->weight[c][i] = limited(share / chance);
        }
        out->density[i] = INFINITY;
        out->through[i] = cross || past ? ~0u : 0;
        out->straight[i] = past ? ~0u : 0;
    }
}

/* Whether the direction is on the side that its lobe is for; a facet's may not be, and other lobes' densities
 * do not count for it. */
static inline uint32_t meant(const incidence *at, uint32_t lobe, int i) {
    uint32_t front =
        (lobe == SHADER_TAKE_DIFFUSE) | (lobe == SHADER_TAKE_GGX) | (lobe == SHADER_TAKE_COAT) ? ~0u : 0;
    uint32_t back = (lobe == SHADER_TAKE_BEHIND) | (lobe == SHADER_TAKE_CROSS) ? ~0u : 0;
    uint32_t any = lobe == SHADER_TAKE_HIGHLIGHT ? ~0u : 0;
    return (front & at->reflected[i]) | (back & at->cross[i]) | any;
}

static void sample(const surface_block *s, const shader_block *b, const lanes3 u,
                   shader_sample *restrict out) {
    uint32_t lobe[LANES];
    lanes3 l;
    incidence at;
    choose_lobes(b, u[2], lobe);
    sample_rough(b, u, lobe, l);
    to_world(b, l, out->direction);
    judge_sides(s, b, out->direction, &at);
    add_lobes(s, b, out->direction, &at, out->weight, out->density);
    for (int i = 0; i < LANES; ++i) {
        uint32_t some = (out->density[i] > 0 ? ~0u : 0) & meant(&at, lobe[i], i);
        float inverse = chosen(some, 1 / (out->density[i] + 0x1p-126f), 0);
        out->density[i] = chosen(some, out->density[i], 0);
        for (int c = 0; c < 3; ++c) out->weight[c][i] = limited(out->weight[c][i] * inverse);
        out->through[i] = at.cross[i], out->straight[i] = 0;
    }
    if (b->lobes & SMOOTH) take_smooth(s, b, lobe, out);
}

const shader_kernels KERNEL(shader_kernels) = {
    .make = make,
    .evaluate = evaluate,
    .sample = sample,
};
