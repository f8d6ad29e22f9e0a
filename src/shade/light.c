#include "shade/light.h"

#include "math/power.h"

void light_prepare(const fathom_light *light, vec3_f64 origin, shade_light *out) {
    *out = (shade_light){.type = light->type};
    for (int c = 0; c < 3; ++c) out->intensity[c] = light->intensity[c];
    if (light->type != FATHOM_LIGHT_DIRECTIONAL) {
        out->position = narrow(sub_f64(load_f64(light->position), origin));
    }
    if (light->type != FATHOM_LIGHT_POINT) {
        out->to_light = narrow(normalize_f64(neg_f64(load_f64(light->direction))));
    }
    if (light->type == FATHOM_LIGHT_SPOT) {
        double outer = cos((double)light->outer_angle), width = cos((double)light->inner_angle) - outer;
        /* inner < outer holds, but their cosines may round to the same: then the edge is as sharp as float
         * shows. */
        double scale = 1 / fmax(width, 0x1p-24);
        out->cone_scale = (float)scale;
        out->cone_offset = (float)(-outer * scale);
    }
}

/* Direction, distance, and intensity over squared distance with the cone's falloff. */
static void arrive(const shade_light *light, light_block *out, float strength[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float x = light->position.x - out->origin[0][i], y = light->position.y - out->origin[1][i],
              z = light->position.z - out->origin[2][i];
        float d2 = x * x + y * y + z * z, distance = sqrtf(d2);
        /* A light in the very point has no direction: it lights nothing there. */
        float inverse = d2 > 0 ? 1 / distance : 0;
        out->direction[0][i] = x * inverse;
        out->direction[1][i] = y * inverse;
        out->direction[2][i] = z * inverse;
        out->distance[i] = distance;
        strength[i] = inverse * inverse;
    }
    if (light->type != FATHOM_LIGHT_SPOT) return;
    for (int i = 0; i < LANES; ++i) {
        float cosine = out->direction[0][i] * light->to_light.x + out->direction[1][i] * light->to_light.y +
                       out->direction[2][i] * light->to_light.z;
        float t = cosine * light->cone_scale + light->cone_offset;
        t = t < 0 ? 0 : (t > 1 ? 1 : t);
        strength[i] *= t * t;
    }
}

static void arrive_parallel(const shade_light *light, light_block *out, float strength[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        out->direction[0][i] = light->to_light.x;
        out->direction[1][i] = light->to_light.y;
        out->direction[2][i] = light->to_light.z;
        out->distance[i] = INFINITY;
        strength[i] = 1;
    }
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
        bool behind = s->smooth[i] ? !(n_dot_l > 0) : !(side > 0);
        float facing = behind || !(n_dot_l > 0) ? 0 : n_dot_l;
        out->n_dot_l[i] = n_dot_l;
        out->behind[i] = behind ? ~0u : 0;
        out->cosine[i] = m->from_behind[i] ? fabsf(n_dot_l) : facing;
    }
}

/* Shadow rays leave on the light's side; a point lifted off its facet is clear of it wherever the light lies,
 * but is of no use to a light behind. */
static void begin_rays(const surface_block *s, const light_side *side, lanes3 origin) {
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            float front = s->p[c][i] + s->lift[c][i] + s->offset[i] * s->ng[c][i];
            float back = s->p[c][i] - s->offset[i] * s->ng[c][i];
            origin[c][i] = side->behind[i] ? back : front;
        }
    }
}

/* k_s max(0, v·r)^n with r = -l + 2(n·l)n, or k_s max(0, n·h)^n with h = (l+v)/|l+v|. */
static void highlight(const surface_block *s, const material_block *m, const lanes3 l,
                      const float n_dot_l[LANES], float out[LANES]) {
    for (int i = 0; i < LANES; ++i) {
        float v_dot_r = 0, n_dot_h = 0, h2 = 0;
        for (int c = 0; c < 3; ++c) {
            float r = -l[c][i] + 2 * n_dot_l[i] * s->ns[c][i], h = l[c][i] + s->v[c][i];
            v_dot_r += s->v[c][i] * r;
            n_dot_h += s->ns[c][i] * h;
            h2 += h * h;
        }
        float blinn = h2 > 0 ? n_dot_h / sqrtf(h2) : 0;
        float cosine = m->phong[i] ? v_dot_r : blinn;
        out[i] = power_of(cosine > 0 ? cosine : 0, m->shininess[i]);
        /* max(0, ·) of a negative cosine to the power 0 is still no highlight. */
        out[i] = cosine > 0 ? out[i] : 0;
    }
}

void light_evaluate(const shade_light *light, const surface_block *s, const material_block *m, bool specular,
                    light_block *out) {
    float strength[LANES], rho_s[LANES] = {0};
    light_side side;
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) out->origin[c][i] = s->p[c][i] + s->lift[c][i];
    }
    if (light->type == FATHOM_LIGHT_DIRECTIONAL) {
        arrive_parallel(light, out, strength);
    } else {
        arrive(light, out, strength);
    }
    judge_sides(s, m, out->direction, &side);
    if (specular) highlight(s, m, out->direction, side.n_dot_l, rho_s);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) {
            out->radiance[c][i] = s->weight[c][i] * light->intensity[c] * (strength[i] * side.cosine[i]) *
                                  (m->k_d[c][i] + m->k_s[c][i] * rho_s[i]);
        }
    }
    begin_rays(s, &side, out->origin);
}
