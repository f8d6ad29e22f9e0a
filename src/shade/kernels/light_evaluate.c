#include "math/power.h"
#include "shade/kernels/kernel.h"
#include "shade/kernels/reach.h"
#include "shade/limit.h"

/* (edge - (1 - cos)) scale, where 1 - cos of the angle between unit vectors is half their difference squared.
 */
static void fall_off(const shade_light *light, const light_block *out, float falloff[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float x = out->direction[0][i] - light->to_light.x, y = out->direction[1][i] - light->to_light.y,
              z = out->direction[2][i] - light->to_light.z;
        float t = (light->cone_edge - 0.5f * (x * x + y * y + z * z)) * light->cone_scale;
        t = t < 0 ? 0 : (t > 1 ? 1 : t);
        falloff[i] = t * t;
    }
}

/* Direction, distance, its inverse, and the cone's falloff. */
static void arrive(const shade_light *light, const surface_block *s, light_block *out, float inverse[LANES],
                   float falloff[LANES]) {
    lanes3 to;
    reach_from(light, s->p, to);
    reach_along(to, out->direction, out->distance, inverse);
    for (int i = 0; i < LANES; ++i) falloff[i] = 1;
    if (light->type == FATHOM_LIGHT_SPOT) fall_off(light, out, falloff);
}

static void arrive_parallel(const shade_light *light, light_block *out, float inverse[LANES],
                            float falloff[LANES]) {
    KERNEL(light_aim)(light, out);
    for (int i = 0; i < LANES; ++i) inverse[i] = falloff[i] = 1;
}

/* Where the light stands to the surface. */
typedef struct light_side {
    float n_dot_l[LANES];
    float cosine[LANES];    /* what the radiance is multiplied with */
    uint32_t behind[LANES]; /* on the viewer's far side */
} light_side;

/* Opaque: a light on the far side counts nothing. On smooth meshes the facets stand for a round surface,
 * whose side the shading normal tells (Hanika 2021); lit_from_behind takes either side. */
static void judge_sides(const surface_block *s, const material_block *m, const lanes3 l, light_side *out) {
    for (int i = 0; i < LANES; ++i) {
        float side = l[0][i] * s->ng[0][i] + l[1][i] * s->ng[1][i] + l[2][i] * s->ng[2][i];
        float n_dot_l = l[0][i] * s->ns[0][i] + l[1][i] * s->ns[1][i] + l[2][i] * s->ns[2][i];
        uint32_t unlit = n_dot_l > 0 ? 0 : ~0u, away = side > 0 ? 0 : ~0u, either = m->from_behind[i];
        uint32_t behind = (s->smooth[i] & unlit) | (~s->smooth[i] & away);
        float facing = chosen(behind | unlit, 0, n_dot_l);
        out->n_dot_l[i] = n_dot_l;
        out->behind[i] = behind;
        out->cosine[i] = chosen(either, fabsf(n_dot_l), facing);
    }
}

/* Shadow rays leave on the light's side; a point lifted off its facet is clear of it wherever the light lies,
 * but is of no use to a light behind. */
static void begin_rays(const surface_block *s, const light_side *side, float (*restrict origin)[LANES]) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            float front = surface_start(s->p[c][i] + s->lift[c][i], s->offset[i], s->ng[c][i]);
            float back = surface_start(s->p[c][i], -s->offset[i], s->ng[c][i]);
            origin[c][i] = chosen(side->behind[i], back, front);
        }
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

static void highlight(const surface_block *s, const material_block *m, const lanes3 l,
                      const float n_dot_l[LANES], float *restrict out) {
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

static bool any_lit(const light_side *side, const float falloff[LANES]) {
    uint32_t lit = 0;
    for (int i = 0; i < LANES; ++i) lit |= side->cosine[i] * falloff[i] > 0 ? ~0u : 0;
    return lit != 0;
}

void KERNEL(light_evaluate)(const shade_light *light, const surface_block *s, const material_block *m,
                            light_block *restrict out) {
    float inverse[LANES], falloff[LANES], rho_s[LANES] = {0};
    light_side side;
    if (light->type == FATHOM_LIGHT_DIRECTIONAL) {
        memcpy(out->origin, s->p, sizeof out->origin);
        arrive_parallel(light, out, inverse, falloff);
    } else {
        arrive(light, s, out, inverse, falloff);
    }
    judge_sides(s, m, out->direction, &side);
    begin_rays(s, &side, out->origin);
    if (!any_lit(&side, falloff)) {
        memset(out->radiance, 0, sizeof out->radiance);
        return;
    }
    highlight(s, m, out->direction, side.n_dot_l, rho_s);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            /* The squared distance is divided by in two steps: it may be out of range where the quotient is
             * not. */
            float once = light->intensity[c] * inverse[i], most = 0x1p127f;
            float arriving = limited((once < most ? once : most) * inverse[i]);
            float reflected = limited(m->k_d[c][i] + m->k_s[c][i] * rho_s[i]);
            float weighed = limited(s->weight[c][i] * (arriving * (falloff[i] * side.cosine[i])));
            out->radiance[c][i] = limited(weighed * reflected);
        }
    }
    if (light->type != FATHOM_LIGHT_DIRECTIONAL) KERNEL(light_aim)(light, out);
}
