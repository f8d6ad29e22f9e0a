/* Albedos of the layers of a metallic-roughness material, by quadrature, and the compensation of
 * `multiscatter`: light that leaves the facets after more than one scattering is added uniformly (Kulla &
 * Conty 2017). With E the albedo of facets of reflectance 1, S a reflectance, R the dielectric's albedo over
 * all scatterings, C the transmittance of the coat, and <> the cosine-weighted mean:
 *
 *   again = <S>^2 <E> / (1 - <S> (1 - <E>))
 *   R = S's albedo + again (1 - E)
 *   below = <(1 - R) C>
 */
#include "integrate/reference_inner.h"

#include <stdlib.h>

/* ---- curves ---- */

/* The cosine of a node; the first is not 0, because albedos are limits there. */
double reference_node(int i) {
    const double x = fmax(i, 0.5) / REFERENCE_STEPS;
    return x * x;
}

double reference_curve(const double *curve, double cosine) {
    const double at = sqrt(fmin(fabs(cosine), 1)) * REFERENCE_STEPS;
    const int low = (int)fmin(at, REFERENCE_STEPS - 1);
    return curve[low] + (at - low) * (curve[low + 1] - curve[low]);
}

/* The curves of facets, for the direction d in the surface's frame. */
static double facets_at(const double curves[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1], vec3_f64 d) {
    const double sum = fabs(d.x) + fabs(d.y), at = sum > 0 ? fabs(d.y) / sum * REFERENCE_TURNS : 0;
    const int low = (int)fmin(at, REFERENCE_TURNS - 1);
    const double a = reference_curve(curves[low], d.z), b = reference_curve(curves[low + 1], d.z);
    return a + (at - low) * (b - a);
}

/* ---- integrals ---- */

/* Midpoint rule over the hemisphere of l, denser at grazing angles: the error is at most 4e-4. */
static double fibres_reflect(const fathom_material *m, double nv) {
    enum { RINGS = 64, AROUND = 32 };
    double sum = 0;
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double x = (i / AROUND + 0.5) / RINGS, nl = x * x, phi = PI * (i % AROUND + 0.5) / AROUND;
        const double lv = nl * nv + sqrt((1 - nl * nl) * (1 - nv * nv)) * cos(phi);
        sum += 2 * x * reference_fibres(m, nl, nv, (nl + nv) / sqrt(2 + 2 * lv)) * nl;
    }
    return sum * 2 * PI / (RINGS * AROUND);
}

static double stretched(double along, double across, vec3_f64 d) {
    return length_f64(vec_f64(along * d.x, across * d.y, d.z));
}

/* Midpoint rule over half vectors, distributed like D: G2 (v·h) / ((n·v) (n·h)), and the same times (1 -
 * v·h)^5. The fraction u of D lies within the slope sqrt(u / (1 - u)) of the normal; u = 1 - q^3 makes
 * midpoints denser at steep slopes, so that the error of both albedos is at most 3e-4 for alpha >= 0.02. */
static void facets_reflect(double along, double across, vec3_f64 v, double *all, double *edge) {
    enum { RINGS = 128, AROUND = 64 };
    *all = *edge = 0;
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double q = (i / AROUND + 0.5) / RINGS, phi = 2 * PI * (i % AROUND + 0.5) / AROUND;
        const double slope = sqrt(1 / (q * q * q) - 1);
        const vec3_f64 h = normalize_f64(vec_f64(along * slope * cos(phi), across * slope * sin(phi), 1));
        const double vh = dot_f64(v, h);
        const vec3_f64 l = sub_f64(scale_f64(2 * vh, h), v);
        if (!(vh > 0 && l.z > 0)) continue;
        const double g = l.z * stretched(along, across, v) + v.z * stretched(along, across, l);
        const double part = 3 * q * q * 2 * l.z * vh / (g * h.z) / (RINGS * AROUND);
        *all += part, *edge += part * pow(1 - vh, 5);
    }
}

static void make_facets(const fathom_material *m, reference_albedos *out) {
    const double across = reference_alpha(m), along = reference_alpha_along(m);
    for (int i = 0; i < (REFERENCE_TURNS + 1) * (REFERENCE_STEPS + 1); ++i) {
        const int turn = i / (REFERENCE_STEPS + 1), step = i % (REFERENCE_STEPS + 1);
        const double cosine = reference_node(step), sine = sqrt(1 - cosine * cosine);
        const double y = (double)turn / REFERENCE_TURNS, length = hypot(1 - y, y);
        const vec3_f64 v = {sine * (1 - y) / length, sine * y / length, cosine};
        double *all = &out->facets[turn][step], *edge = &out->edge[turn][step];
        if (turn && along == across)
            *all = out->facets[0][step], *edge = out->edge[0][step];
        else if (along > 0)
            facets_reflect(along, across, v, all, edge);
        else
            *all = 1, *edge = pow(1 - cosine, 5);
    }
}

/* ---- several scatterings ---- */

/* Directions distributed like the cosine over a quarter of the hemisphere. */
enum { RINGS = 256, AROUND = 16 };
static vec3_f64 spread(int i) {
    const double z2 = (i / AROUND + 0.5) / RINGS, angle = PI / 2 * (i % AROUND + 0.5) / AROUND;
    return vec_f64(sqrt(1 - z2) * cos(angle), sqrt(1 - z2) * sin(angle), sqrt(z2));
}

static double again_of(double reflectance, double mean) {
    return reflectance * reflectance * mean / (1 - reflectance * (1 - mean));
}

/* The layer over the base: a film counts as a Schlick curve that is nowhere below it. */
static void make_layer(const fathom_material *m, reference_albedos *out) {
    enum { LOOKS = 256 };
    out->low = largest(reference_reflect(m, (double)m->ior, 1, 1).dielectric);
    out->high = m->iridescence > 0 ? 1 : (double)m->specular_factor;
    for (int k = 1; k < LOOKS && m->iridescence > 0; ++k) {
        const double cosine = (double)k / LOOKS * k / LOOKS, rise = pow(1 - cosine, 5);
        const double film = largest(reference_reflect(m, (double)m->ior, cosine, cosine).dielectric);
        out->low = fmin(fmax(out->low, (film - rise) / (1 - rise)), 1);
    }
}

static void make_again(const fathom_material *m, reference_albedos *out) {
    const double metallic = (double)m->metallic;
    double mean = 0;
    vec3_f64 base = gray(0), metal = gray(0);
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const vec3_f64 d = spread(i);
        const reference_reflectances f = reference_reflect(m, (double)m->ior, d.z, d.z);
        mean += facets_at(out->facets, d) / (RINGS * AROUND);
        base = madd_f64(base, 1.0 / (RINGS * AROUND), f.dielectric);
        metal = madd_f64(metal, 1.0 / (RINGS * AROUND), f.metal);
    }
    const vec3_f64 both = blend(base, metal, metallic);
    const double solid = reference_is_rough_glass(m) ? 1 - (double)m->transmission : 1;
    const vec3_f64 layer = {again_of(base.x, mean), again_of(base.y, mean), again_of(base.z, mean)};
    const vec3_f64 parts =
        blend(scale_f64(solid, layer),
              vec_f64(again_of(metal.x, mean), again_of(metal.y, mean), again_of(metal.z, mean)), metallic);
    out->again_inside = scale_f64(
        metallic, vec_f64(again_of(metal.x, mean), again_of(metal.y, mean), again_of(metal.z, mean)));
    /* A film covers the mixture of metal and dielectric. */
    out->again = m->iridescence > 0
                     ? vec_f64(again_of(both.x, mean), again_of(both.y, mean), again_of(both.z, mean))
                     : parts;
    out->again_base = again_of(out->low + (out->high - out->low) / 21, mean);
    out->lost = 1 - mean;
}

static double under(const reference_albedos *a, vec3_f64 d) {
    const double all = facets_at(a->facets, d), edge = facets_at(a->edge, d);
    return 1 - a->low * (all - edge) - a->high * edge - a->again_base * (1 - all);
}

static void make_even(const fathom_material *m, reference_albedos *out) {
    make_facets(m, out);
    make_layer(m, out);
    make_again(m, out);
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const vec3_f64 d = spread(i);
        out->below += under(out, d) * (1 - reference_curve(out->coat, d.z)) / (RINGS * AROUND);
    }
}

bool reference_albedos_make(const fathom_material *m, const double *around, unsigned count,
                            reference_albedos **out) {
    const bool sheen = largest(color_of(m->sheen_color)) > 0, coat = m->clearcoat > 0;
    const double alpha = reference_coat_alpha(m);
    *out = NULL;
    if (m->model == FATHOM_MODEL_CLASSIC || !(sheen || coat || m->multiscatter)) return true;
    const unsigned glasses = m->multiscatter && reference_is_rough_glass(m) ? count : 0;
    *out = calloc(1, sizeof **out + glasses * sizeof *(*out)->glass);
    if (!*out) return false;
    for (int i = 0; i <= REFERENCE_STEPS; ++i) {
        const double cosine = reference_node(i);
        double all, edge = pow(1 - cosine, 5);
        if (sheen) (*out)->sheen[i] = fibres_reflect(m, cosine);
        if (!coat) continue;
        all = 1;
        if (alpha > 0)
            facets_reflect(alpha, alpha, vec_f64(sqrt(1 - cosine * cosine), 0, cosine), &all, &edge);
        (*out)->coat[i] = (double)m->clearcoat * (0.04 * all + 0.96 * edge);
    }
    if (m->multiscatter) make_even(m, *out);
    (*out)->glasses = glasses;
    for (unsigned k = 0; k < glasses; ++k)
        reference_glass_make(m, (double)m->ior / around[k], &(*out)->glass[k]);
    return true;
}

/* ---- at a surface ---- */

static vec3_f64 in_frame(const reference_surface *s, vec3_f64 d) {
    return vec_f64(dot_f64(d, s->along), dot_f64(d, cross_f64(s->normal, s->along)), dot_f64(d, s->normal));
}

double reference_again(const reference_surface *s, vec3_f64 l) {
    const reference_albedos *a = s->albedos;
    if (!s->material->multiscatter || !(a->lost > 1e-6)) return 0;
    const double from_l = facets_at(a->facets, in_frame(s, l));
    return (1 - from_l) * (1 - facets_at(a->facets, in_frame(s, s->to_viewer))) / (PI * a->lost);
}

bool reference_is_inside(const reference_surface *s) {
    const fathom_material *m = s->material;
    return s->behind && reference_refracts(m) && m->ior != 1 && !(m->iridescence > 0);
}

/* Light that crosses into a solid is as without `multiscatter`. */
double reference_base(const reference_surface *s, vec3_f64 l, double plain) {
    const reference_albedos *a = s->albedos;
    const bool behind = s->behind && reference_refracts(s->material) && s->material->ior != 1;
    if (reference_is_inside(s) && dot_f64(s->normal, l) > 0) return 1;
    if (!s->material->multiscatter || behind) return plain;
    return a->below > 1e-4 ? under(a, in_frame(s, l)) * under(a, in_frame(s, s->to_viewer)) / a->below : 0;
}
