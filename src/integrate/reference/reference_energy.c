/* Albedos of the layers of a metallic-roughness material, by quadrature, and the compensation of
 * `multiscatter`: light that leaves the facets after more than one scattering is added uniformly (Kulla &
 * Conty 2017). With E the albedo of facets of reflectance 1, S a reflectance, R the dielectric's albedo over
 * all scatterings, C the transmittance of the coat, and <> the cosine-weighted mean:
 *
 *   again = <S>^2 <E> / (1 - <S> (1 - <E>))
 *   R = S's albedo + again (1 - E)
 *   below = <(1 - R) C>
 *
 * Each channel of a film has its own R. */
#include "integrate/reference/reference_inner.h"

#include <stdlib.h>

/* ---- curves ---- */

/* The cosine at a node of the curves; the first is not 0, because albedos are limits there. */
static double node_cosine(int i) {
    const double x = fmax(i, 0.5) / REFERENCE_STEPS;
    return x * x;
}

double reference_curve(const double *curve, double cosine) {
    const double at = sqrt(fmin(fabs(cosine), 1)) * REFERENCE_STEPS;
    const int low = (int)fmin(at, REFERENCE_STEPS - 1);
    return curve[low] + (at - low) * (curve[low + 1] - curve[low]);
}

double reference_facets(const double curves[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1], vec3_f64 d) {
    const double sum = fabs(d.x) + fabs(d.y), at = sum > 0 ? fabs(d.y) / sum * REFERENCE_TURNS : 0;
    const int low = (int)fmin(at, REFERENCE_TURNS - 1);
    const double a = reference_curve(curves[low], d.z), b = reference_curve(curves[low + 1], d.z);
    return a + (at - low) * (b - a);
}

/* The same for colours. */
static vec3_f64 layer_at(const reference_albedos *a, vec3_f64 d) {
    const double sum = fabs(d.x) + fabs(d.y), turn = sum > 0 ? fabs(d.y) / sum * REFERENCE_TURNS : 0;
    const double step = sqrt(fmin(fabs(d.z), 1)) * REFERENCE_STEPS;
    const int j = (int)fmin(turn, REFERENCE_TURNS - 1), k = (int)fmin(step, REFERENCE_STEPS - 1);
    return blend(blend(a->layer[j][k], a->layer[j][k + 1], step - k),
                 blend(a->layer[j + 1][k], a->layer[j + 1][k + 1], step - k), turn - j);
}

vec3_f64 reference_turned_node(int turn, int step) {
    const double cosine = node_cosine(step), sine = sqrt(1 - cosine * cosine);
    const double y = (double)turn / REFERENCE_TURNS, length = hypot(1 - y, y);
    return vec_f64(sine * (1 - y) / length, sine * y / length, cosine);
}

/* ---- integrals ---- */

/* Midpoint rule over the hemisphere of l, denser at grazing angles: the error is at most 4e-4. */
static double fibres_reflect(const fathom_material *m, double nv) {
    enum { RINGS = 64, AROUND = 32 };
    double sum = 0;
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double x = (i / AROUND + 0.5) / RINGS, nl = x * x, phi = M_PI * (i % AROUND + 0.5) / AROUND;
        const double lv = nl * nv + sqrt((1 - nl * nl) * (1 - nv * nv)) * cos(phi);
        sum += 2 * x * reference_fibres(m, nl, nv, (nl + nv) / sqrt(2 + 2 * lv)) * nl;
    }
    return sum * 2 * M_PI / (RINGS * AROUND);
}

double reference_stretched(double along, double across, vec3_f64 d) {
    return length_f64(vec_f64(along * d.x, across * d.y, d.z));
}

/* The light that a dielectric keeps from the base, by the cosine between viewer and facet: nodes at cosines
 * (k / LOOKS)^2. */
enum { LOOKS = 1024 };
typedef struct kept {
    vec3_f64 at[LOOKS + 1];
} kept;

static void look(const fathom_material *m, kept *out) {
    for (int k = 0; k <= LOOKS; ++k) {
        const double x = (double)k / LOOKS;
        out->at[k] = sub_f64(gray(1), reference_reflect(m, (double)m->ior, x * x, x * x).base);
    }
}

static vec3_f64 kept_at(const kept *table, double cosine) {
    const double at = sqrt(fmin(cosine, 1)) * LOOKS;
    const int low = (int)fmin(at, LOOKS - 1);
    return blend(table->at[low], table->at[low + 1], at - low);
}

/* Midpoint rule over half vectors, distributed like D: G2 (v·h) / ((n·v) (n·h)), and the same times what the
 * layer keeps. The fraction u of D lies within the slope sqrt(u / (1 - u)) of the normal; u = 1 - q^3 makes
 * midpoints denser at steep slopes, so that the error of both albedos is at most 3e-4 for alpha >= 0.02. */
static void facets_reflect(double along, double across, vec3_f64 v, const kept *table, double *all,
                           vec3_f64 *layer) {
    enum { RINGS = 128, AROUND = 64 };
    *all = 0, *layer = gray(0);
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double q = (i / AROUND + 0.5) / RINGS, phi = 2 * M_PI * (i % AROUND + 0.5) / AROUND;
        const double slope = sqrt(1 / (q * q * q) - 1);
        const vec3_f64 h = normalize_f64(vec_f64(along * slope * cos(phi), across * slope * sin(phi), 1));
        const double vh = dot_f64(v, h);
        const vec3_f64 l = sub_f64(scale_f64(2 * vh, h), v);
        if (!(vh > 0 && l.z > 0)) continue;
        const double g =
            l.z * reference_stretched(along, across, v) + v.z * reference_stretched(along, across, l);
        const double part = 3 * q * q * 2 * l.z * vh / (g * h.z) / (RINGS * AROUND);
        *all += part, *layer = madd_f64(*layer, part, kept_at(table, vh));
    }
}

static void make_facets(const fathom_material *m, const kept *table, reference_albedos *out) {
    const double across = reference_alpha(m), along = reference_alpha_along(m);
    for (int i = 0; i < (REFERENCE_TURNS + 1) * (REFERENCE_STEPS + 1); ++i) {
        const int turn = i / (REFERENCE_STEPS + 1), step = i % (REFERENCE_STEPS + 1);
        const vec3_f64 v = reference_turned_node(turn, step);
        double *all = &out->facets[turn][step];
        vec3_f64 *layer = &out->layer[turn][step];
        if (turn && along == across)
            *all = out->facets[0][step], *layer = out->layer[0][step];
        else if (along > 0)
            facets_reflect(along, across, v, table, all, layer);
        else
            *all = 1, *layer = kept_at(table, v.z);
    }
}

/* ---- several scatterings ---- */

/* Directions distributed like the cosine over a quarter of the hemisphere. */
enum { RINGS = 256, AROUND = 16 };
static vec3_f64 spread(int i) {
    const double z2 = (i / AROUND + 0.5) / RINGS, angle = M_PI / 2 * (i % AROUND + 0.5) / AROUND;
    return vec_f64(sqrt(1 - z2) * cos(angle), sqrt(1 - z2) * sin(angle), sqrt(z2));
}

static double again_of(double reflectance, double mean) {
    return reflectance * reflectance * mean / (1 - reflectance * (1 - mean));
}

static vec3_f64 again_each(vec3_f64 reflectance, double mean) {
    return vec_f64(again_of(reflectance.x, mean), again_of(reflectance.y, mean),
                   again_of(reflectance.z, mean));
}

static void make_again(const fathom_material *m, reference_albedos *out) {
    const double metallic = (double)m->metallic;
    const double solid = reference_is_rough_glass(m) ? 1 - (double)m->transmission : 1,
                 part = 1.0 / (RINGS * AROUND);
    double mean = 0;
    vec3_f64 base = gray(0), metal = gray(0), layer = gray(0);
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const vec3_f64 d = spread(i);
        const reference_reflectances f = reference_reflect(m, (double)m->ior, d.z, d.z);
        mean += part * reference_facets(out->facets, d);
        base = madd_f64(base, part, f.dielectric);
        metal = madd_f64(metal, part, f.metal);
        layer = madd_f64(layer, part, sub_f64(gray(1), f.base));
    }
    out->again = blend(scale_f64(solid, again_each(base, mean)), again_each(metal, mean), metallic);
    out->again_inside = scale_f64(metallic, again_each(metal, mean));
    out->again_base = again_each(layer, mean);
    out->lost = 1 - mean;
}

static vec3_f64 under(const reference_albedos *a, vec3_f64 d) {
    const double all = reference_facets(a->facets, d);
    return sub_f64(gray(1), madd_f64(layer_at(a, d), 1 - all, a->again_base));
}

static void make_even(const fathom_material *m, reference_albedos *out) {
    kept table;
    look(m, &table);
    make_facets(m, &table, out);
    make_again(m, out);
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const vec3_f64 d = spread(i);
        const double share = (1 - reference_curve(out->coat, d.z)) / (RINGS * AROUND);
        out->below = madd_f64(out->below, share, under(out, d));
    }
}

/* The coat, whose index is 1.5. */
static double coat_albedo(const fathom_material *m, double cosine) {
    const double alpha = reference_coat_alpha(m);
    kept table;
    double all;
    vec3_f64 layer;
    for (int k = 0; k <= LOOKS; ++k)
        table.at[k] = gray(0.04 + 0.96 * pow(1 - (double)k / LOOKS * k / LOOKS, 5));
    if (!(alpha > 0)) return kept_at(&table, cosine).x;
    facets_reflect(alpha, alpha, vec_f64(sqrt(1 - cosine * cosine), 0, cosine), &table, &all, &layer);
    return layer.x;
}

bool reference_albedos_make(const fathom_material *m, const double *around, unsigned count,
                            reference_albedos **out) {
    const bool sheen = largest(color_of(m->sheen_color)) > 0, coat = m->clearcoat > 0;
    *out = NULL;
    if (m->model == FATHOM_MODEL_CLASSIC || !(sheen || coat || m->multiscatter)) return true;
    const unsigned glasses = m->multiscatter && reference_is_rough_glass(m) ? count : 0;
    *out = calloc(1, sizeof **out + glasses * sizeof *(*out)->glass);
    if (!*out) return false;
    for (int i = 0; i <= REFERENCE_STEPS; ++i) {
        const double cosine = node_cosine(i);
        if (sheen) (*out)->sheen[i] = fibres_reflect(m, cosine);
        if (coat) (*out)->coat[i] = (double)m->clearcoat * coat_albedo(m, cosine);
    }
    if (m->multiscatter) make_even(m, *out);
    (*out)->glasses = glasses;
    for (unsigned k = 0; k < glasses; ++k)
        reference_glass_make(m, (double)m->ior / around[k], &(*out)->glass[k]);
    return true;
}

/* ---- at a surface ---- */

vec3_f64 reference_in_frame(const reference_surface *s, vec3_f64 d) {
    return vec_f64(dot_f64(d, s->along), dot_f64(d, cross_f64(s->normal, s->along)), dot_f64(d, s->normal));
}

double reference_again(const reference_surface *s, vec3_f64 l) {
    const reference_albedos *a = s->albedos;
    if (!s->material->multiscatter || !(a->lost > 1e-6)) return 0;
    const double from_l = reference_facets(a->facets, reference_in_frame(s, l));
    return (1 - from_l) * (1 - reference_facets(a->facets, reference_in_frame(s, s->to_viewer))) /
           (M_PI * a->lost);
}

bool reference_is_inside(const reference_surface *s) {
    const fathom_material *m = s->material;
    return s->behind && reference_refracts(m) && m->ior != 1 && !(m->iridescence > 0);
}

/* Light that crosses into a solid is as without `multiscatter`. */
static bool is_plain(const reference_surface *s) {
    const bool behind = s->behind && reference_refracts(s->material) && s->material->ior != 1;
    return !s->material->multiscatter || behind;
}

vec3_f64 reference_passes(const reference_surface *s, vec3_f64 plain) {
    const bool smooth = reference_alpha(s->material) == 0;
    return smooth || is_plain(s) ? plain : under(s->albedos, reference_in_frame(s, s->to_viewer));
}

vec3_f64 reference_base(const reference_surface *s, vec3_f64 l, vec3_f64 plain) {
    const reference_albedos *a = s->albedos;
    if (reference_is_inside(s) && dot_f64(s->normal, l) > 0) return gray(1);
    if (is_plain(s)) return plain;
    const vec3_f64 both =
        times(under(a, reference_in_frame(s, l)), under(a, reference_in_frame(s, s->to_viewer)));
    return vec_f64(a->below.x > 1e-4 ? both.x / a->below.x : 0, a->below.y > 1e-4 ? both.y / a->below.y : 0,
                   a->below.z > 1e-4 ? both.z / a->below.z : 0);
}
