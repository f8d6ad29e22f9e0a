/* `multiscatter` of rough glass: the light that the first scattering neither reflects nor transmits, which
 * leaves to both sides. With A(mu) the albedo of facets that reflect and refract, M = 1 - A, <> the
 * cosine-weighted mean, a the viewer's side and b the other one, T a smooth surface's transmittance for
 * light that comes from all around:
 *
 *   through = T_a <M_b> / max(<M_a>, <M_b>)
 *   f = (1 - through) M_a(v) M_a(l) / (pi <M_a>) on the viewer's side
 *   f = through M_a(v) M_b(l) / (pi <M_b>) on the other side
 *
 * As T_a n_a^2 = T_b n_b^2, the light that passes is reciprocal. */
#include "integrate/reference/reference_inner.h"

static reference_reflectances reflect_at(const fathom_material *m, double ior, double ratio, double cosine) {
    return reference_reflect(m, ior, ratio < 1 ? reference_far_cosine(cosine, ratio) : cosine, cosine);
}

/* Midpoint rule over half vectors that are distributed like D, as in reference_energy.c: G2 (v·h) / ((n·v)
 * (n·h)) times the reflectance, or times the transmittance. Light that is totally reflected ends at an edge
 * across the azimuths, so they are denser than the rings: the error is at most 1e-3 for one alpha. */
static double facets_send(const fathom_material *m, double ior, double ratio, vec3_f64 v) {
    const double across = reference_alpha(m), along = reference_alpha_along(m);
    const int half = along == across ? 2 : 1; /* both halves are alike if v.y is 0 */
    const int RINGS = 64, AROUND = half == 2 ? 128 : 64;
    double sum = 0;
    for (int i = 0; i < RINGS * AROUND / half; ++i) {
        const double q = (i / (AROUND / half) + 0.5) / RINGS,
                     phi = 2 * M_PI * (i % (AROUND / half) + 0.5) / AROUND;
        const double slope = sqrt(1 / (q * q * q) - 1);
        const vec3_f64 h = normalize_f64(vec_f64(along * slope * cos(phi), across * slope * sin(phi), 1));
        const double vh = dot_f64(v, h);
        if (!(vh > 0)) continue;
        const reference_reflectances f = reflect_at(m, ior, ratio, fmin(vh, 1));
        const vec3_f64 back = reference_mirrored(v, h), on = neg_f64(reference_refracted(v, h, ratio));
        const double weights[2] = {back.z > 0 ? largest(f.dielectric) : 0, on.z > 0 ? f.base.x : 0};
        for (int k = 0; k < 2; ++k) {
            const vec3_f64 l = k ? on : back;
            const double g =
                l.z * reference_stretched(along, across, v) + v.z * reference_stretched(along, across, l);
            if (weights[k] > 0) sum += weights[k] * half * 6 * q * q * l.z * vh / (g * h.z);
        }
    }
    return sum / (RINGS * AROUND);
}

/* The mean of curves over directions distributed like the cosine, of a quarter of the hemisphere. */
static double mean_of(const double curves[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1]) {
    enum { RINGS = 1024, TURNS = 32 };
    double sum = 0;
    for (int i = 0; i < RINGS * TURNS; ++i) {
        const double z = sqrt((i / TURNS + 0.5) / RINGS), phi = M_PI / 2 * (i % TURNS + 0.5) / TURNS;
        sum += reference_facets(curves, vec_f64(sqrt(1 - z * z) * cos(phi), sqrt(1 - z * z) * sin(phi), z));
    }
    return sum / (RINGS * TURNS);
}

static double mean_transmitted(const fathom_material *m, double ior, double ratio) {
    enum { COUNT = 65536 };
    double sum = 0;
    for (int i = 0; i < COUNT; ++i) sum += reflect_at(m, ior, ratio, sqrt((i + 0.5) / COUNT)).base.x / COUNT;
    return sum;
}

/* All azimuths have the same value if the alphas are equal. Otherwise every second node is the mean of its
 * neighbours. */
static void make_missing(const fathom_material *m, double ior, double ratio,
                         double out[REFERENCE_TURNS + 1][REFERENCE_STEPS + 1]) {
    const bool even = reference_alpha(m) == reference_alpha_along(m);
    for (int turn = 0; turn <= REFERENCE_TURNS; ++turn) {
        for (int i = 0; i <= REFERENCE_STEPS; i += even ? 1 : 2)
            out[turn][i] = turn && even
                               ? out[0][i]
                               : fmax(1 - facets_send(m, ior, ratio, reference_turned_node(turn, i)), 0);
        for (int i = 1; i < REFERENCE_STEPS && !even; i += 2)
            out[turn][i] = (out[turn][i - 1] + out[turn][i + 1]) / 2;
    }
}

void reference_glass_make(const fathom_material *m, double ior, reference_glass *out) {
    double lost[2];
    out->ior = ior;
    for (int side = 0; side < 2; ++side) {
        make_missing(m, ior, side ? 1 / ior : ior, out->missing[side]);
        lost[side] = mean_of(out->missing[side]);
    }
    for (int side = 0; side < 2; ++side) {
        const double open = mean_transmitted(m, ior, side ? 1 / ior : ior);
        const double through = open * lost[!side] / fmax(fmax(lost[0], lost[1]), 1e-6);
        out->again[side] = lost[side] > 1e-6 ? (1 - through) / (M_PI * lost[side]) : 0;
        out->cross[side] = lost[!side] > 1e-6 ? through / (M_PI * lost[!side]) : 0;
    }
}

double reference_glass_again(const reference_surface *s, vec3_f64 l) {
    const reference_albedos *a = s->albedos;
    if (!reference_is_rough_glass(s->material) || !s->material->multiscatter || s->ratio == 1) return 0;
    const double ior = s->behind ? 1 / s->ratio : s->ratio, nl = dot_f64(s->normal, l);
    const reference_glass *g = &a->glass[0];
    for (unsigned k = 1; k < a->glasses; ++k)
        if (fabs(a->glass[k].ior - ior) < fabs(g->ior - ior)) g = &a->glass[k];
    const int side = s->behind ? 1 : 0;
    const vec3_f64 v = reference_in_frame(s, s->to_viewer), to = reference_in_frame(s, l);
    const double from_v = reference_facets(g->missing[side], v);
    if (nl > 0) return g->again[side] * from_v * reference_facets(g->missing[side], to);
    return g->cross[side] * from_v * reference_facets(g->missing[!side], to);
}
