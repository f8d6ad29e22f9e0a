/* Fibres and thin films of the reference (KHR_materials_sheen, _iridescence). */
#include "integrate/reference/reference_inner.h"

/* ---- fibres ---- */

/* The curve fitted by Estevez & Kulla (2017), as in KHR_materials_sheen. */
static double curve(double x, double alpha) {
    const double t = (1 - alpha) * (1 - alpha);
    const double a = t * 25.3245 + (1 - t) * 21.5473, b = t * 3.32435 + (1 - t) * 3.82987;
    const double c = t * 0.16801 + (1 - t) * 0.19823, d = t * -1.27393 + (1 - t) * -1.97760;
    return a / (1 + b * pow(x, c)) + d * x + (t * -4.85967 + (1 - t) * -4.32054);
}

static double shadowed(double cosine, double alpha) {
    return exp(cosine < 0.5 ? curve(cosine, alpha) : 2 * curve(0.5, alpha) - curve(1 - cosine, alpha));
}

double reference_fibres(const fathom_material *m, double nl, double nv, double nh) {
    const double rough = fmax((double)m->sheen_roughness, 0.07), alpha = rough * rough;
    const double d = (2 + 1 / alpha) * pow(fmax(1 - nh * nh, 0), 0.5 / alpha) / (2 * M_PI);
    return d / (4 * nl * nv * (1 + shadowed(nl, alpha) + shadowed(nv, alpha)));
}

/* ---- films: Belcour & Barla (2017), as in KHR_materials_iridescence ---- */

static double squared(double x) { return x * x; }

/* The response of three receptors to a wave of this phase, in linear Rec.709. Each receptor uses the phase
 * shift of red, green or blue, as in the extension's sample code. */
static vec3_f64 seen(double way, const double shift[3]) {
    static const double value[4] = {5.4856e-13, 4.4201e-13, 5.2481e-13, 9.7470e-14};
    static const double place[4] = {1.6810e6, 1.7953e6, 2.2084e6, 2.2399e6};
    static const double spread[4] = {4.3278e9, 9.3046e9, 6.6121e9, 4.5282e9};
    const double phase = 2 * M_PI * way * 1e-9;
    double xyz[4];
    for (int k = 0; k < 4; ++k)
        xyz[k] = value[k] * sqrt(2 * M_PI * spread[k]) * cos(place[k] * phase + shift[k % 3]) *
                 exp(-spread[k] * phase * phase) / 1.0685e-7;
    const double x = xyz[0] + xyz[3], y = xyz[1], z = xyz[2];
    return vec_f64(3.2404542 * x - 1.5371385 * y - 0.4985314 * z,
                   -0.9692660 * x + 1.8760108 * y + 0.0415560 * z,
                   0.0556434 * x - 0.2040259 * y + 1.0572252 * z);
}

/* The index of a base with the reflectance f0. */
static double base_index(double f0) {
    const double root = sqrt(fmin(f0, 0.9999));
    return (1 + root) / (1 - root);
}

/* The reflectance of each channel over a base with the reflectance f0 in all channels; waves: the channels'
 * responses to light that was reflected once and twice in the film. */
static vec3_f64 film_over(double index, double f0, double cosine, const vec3_f64 waves[2]) {
    const double inside2 = 1 - (1 - cosine * cosine) / (index * index);
    if (inside2 < 0) return gray(1);
    const double inside = sqrt(inside2), base = base_index(f0);
    const double top0 = squared((index - 1) / (index + 1)), low0 = squared((base - index) / (base + index));
    const double top = top0 + (1 - top0) * pow(1 - cosine, 5);
    const double low = low0 + (1 - low0) * pow(1 - inside, 5), both = fmin(fmax(top * low, 1e-5), 0.9999);
    const double again = squared(1 - top) * low / (1 - both);
    vec3_f64 sum = gray(top + again);
    for (int k = 1; k <= 2; ++k)
        sum = madd_f64(sum, 2 * (again - (1 - top)) * pow(both, k / 2.0), waves[k - 1]);
    return vec_f64(fmin(fmax(sum.x, 0), 1), fmin(fmax(sum.y, 0), 1), fmin(fmax(sum.z, 0), 1));
}

vec3_f64 reference_film(const fathom_material *m, vec3_f64 f0, double cosine) {
    const double thick = (double)m->iridescence_thickness_max, part = fmin(thick / 0.03, 1);
    const double index = 1 + ((double)m->iridescence_ior - 1) * part * part * (3 - 2 * part);
    const double c = fmin(fmax(cosine, 0), 1), colors[3] = {f0.x, f0.y, f0.z};
    const double inside = sqrt(fmax(1 - (1 - c * c) / (index * index), 0));
    vec3_f64 waves[2];
    for (int k = 1; k <= 2; ++k) {
        double shift[3];
        for (int i = 0; i < 3; ++i) shift[i] = k * (base_index(colors[i]) < index ? 2 * M_PI : M_PI);
        waves[k - 1] = seen(k * 2 * index * thick * inside, shift);
    }
    return vec_f64(film_over(index, f0.x, c, waves).x, film_over(index, f0.y, c, waves).y,
                   film_over(index, f0.z, c, waves).z);
}
