/* `multiscatter` of rough glass: the light that its facets send neither back nor through, which leaves to
 * both sides. With A(mu) the albedo of facets that reflect and refract, M = 1 - A, <> the cosine-weighted
 * mean, a the viewer's side and b the other one, T a smooth surface's transmittance for light that comes from
 * all around:
 *
 *   through = T_a <M_b> / max(<M_a>, <M_b>)
 *   f = (1 - through) M_a(v) M_a(l) / (pi <M_a>) on the viewer's side
 *   f = through M_a(v) M_b(l) / (pi <M_b>) on the other side
 *
 * As T_a n_a^2 = T_b n_b^2, the light that passes is reciprocal. */
#include "integrate/reference_inner.h"

static double smith(double alpha, double cosine) {
    return sqrt(alpha * alpha * (1 - cosine * cosine) + cosine * cosine);
}

static reference_reflectances reflect_at(const fathom_material *m, double ior, double ratio, double cosine) {
    return reference_reflect(m, ior, ratio < 1 ? reference_far_cosine(cosine, ratio) : cosine, cosine);
}

/* Midpoint rule over half vectors that are distributed like D, as in reference_energy.c: G2 (v·h) / ((n·v)
 * (n·h)) times the reflectance, or times the transmittance. */
static double facets_send(const fathom_material *m, double ior, double ratio, double nv) {
    enum { RINGS = 128, AROUND = 32 };
    const double alpha = reference_alpha(m);
    const vec3_f64 v = {sqrt(1 - nv * nv), 0, nv};
    double sum = 0;
    for (int i = 0; i < RINGS * AROUND; ++i) {
        const double q = (i / AROUND + 0.5) / RINGS, phi = PI * (i % AROUND + 0.5) / AROUND;
        const double nh = 1 / hypot(1, alpha * sqrt(1 / (q * q * q) - 1)), sine = sqrt(1 - nh * nh);
        const vec3_f64 h = {sine * cos(phi), sine * sin(phi), nh};
        const double vh = dot_f64(v, h);
        if (!(vh > 0)) continue;
        const reference_reflectances f = reflect_at(m, ior, ratio, fmin(vh, 1));
        const double back = reference_mirrored(v, h).z, on = -reference_refracted(v, h, ratio).z;
        const double weights[2] = {back > 0 ? largest(f.dielectric) : 0, on > 0 ? f.base : 0};
        for (int k = 0; k < 2; ++k) {
            const double nl = k ? on : back;
            if (weights[k] > 0)
                sum +=
                    weights[k] * 6 * q * q * nl * vh / ((nl * smith(alpha, nv) + nv * smith(alpha, nl)) * nh);
        }
    }
    return sum / (RINGS * AROUND);
}

/* The mean of a curve over directions distributed like the cosine. */
static double mean_of(const double *curve) {
    enum { COUNT = 4096 };
    double sum = 0;
    for (int i = 0; i < COUNT; ++i) sum += reference_curve(curve, sqrt((i + 0.5) / COUNT)) / COUNT;
    return sum;
}

static double mean_transmitted(const fathom_material *m, double ior, double ratio) {
    enum { COUNT = 65536 };
    double sum = 0;
    for (int i = 0; i < COUNT; ++i) sum += reflect_at(m, ior, ratio, sqrt((i + 0.5) / COUNT)).base / COUNT;
    return sum;
}

void reference_glass_make(const fathom_material *m, double ior, reference_glass *out) {
    double lost[2];
    out->ior = ior;
    for (int side = 0; side < 2; ++side) {
        const double ratio = side ? 1 / ior : ior;
        for (int i = 0; i <= REFERENCE_STEPS; ++i)
            out->missing[side][i] = fmax(1 - facets_send(m, ior, ratio, reference_node(i)), 0);
        lost[side] = mean_of(out->missing[side]);
    }
    for (int side = 0; side < 2; ++side) {
        const double open = mean_transmitted(m, ior, side ? 1 / ior : ior);
        const double through = open * lost[!side] / fmax(fmax(lost[0], lost[1]), 1e-6);
        out->again[side] = lost[side] > 1e-6 ? (1 - through) / (PI * lost[side]) : 0;
        out->cross[side] = lost[!side] > 1e-6 ? through / (PI * lost[!side]) : 0;
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
    const double from_v = reference_curve(g->missing[side], dot_f64(s->normal, s->to_viewer));
    if (nl > 0) return g->again[side] * from_v * reference_curve(g->missing[side], nl);
    return g->cross[side] * from_v * reference_curve(g->missing[!side], nl);
}
