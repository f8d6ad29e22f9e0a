/* Thin films: Belcour & Barla (2017), as KHR_materials_iridescence uses them. Light is reflected back and
 * forth in the film; the phases of the light that leaves it interfere, and the interference is integrated
 * over the colour matching functions as Gaussians in Fourier space. Both interfaces have Schlick's
 * reflectance; phases are 0 or pi. */
#include "material/layers.h"
#include "material/mixture.h"

#include <math.h>
#include <string.h>

static double schlick(double f0, double cosine) { return f0 + (1 - f0) * pow(1 - cosine, 5); }

static double square(double x) { return x * x; }

/* The integral of the colour matching functions at an optical path difference in nanometres, with a phase
 * shift per channel. */
static void sensitivity(double difference, const double shift[3], double rgb[3]) {
    static const double value[3] = {5.4856e-13, 4.4201e-13, 5.2481e-13},
                        place[3] = {1.6810e6, 1.7953e6, 2.2084e6};
    static const double width[3] = {4.3278e9, 9.3046e9, 6.6121e9}, all = 1.0685e-7;
    static const double to_rgb[3][3] = {{3.2404542, -1.5371385, -0.4985314},
                                        {-0.9692660, 1.8760108, 0.0415560},
                                        {0.0556434, -0.2040259, 1.0572252}};
    const double phase = 2 * M_PI * difference * 1e-9;
    double xyz[3];
    for (int c = 0; c < 3; ++c)
        xyz[c] = value[c] * sqrt(2 * M_PI * width[c]) * cos(place[c] * phase + shift[c]) *
                 exp(-square(phase) * width[c]);
    xyz[0] += 9.7470e-14 * sqrt(2 * M_PI * 4.5282e9) * cos(2.2399e6 * phase + shift[0]) *
              exp(-square(phase) * 4.5282e9);
    for (int c = 0; c < 3; ++c)
        rgb[c] = (to_rgb[c][0] * xyz[0] + to_rgb[c][1] * xyz[1] + to_rgb[c][2] * xyz[2]) / all;
}

/* The reflectance of a film on a base of reflectance f0. */
static void reflectance(const fathom_material *m, const float f0[3], double cosine, double rgb[3]) {
    const double thickness = (double)m->iridescence_thickness_max;
    const double index = thickness > 0 ? (double)m->iridescence_ior : 1;
    const double inner = sqrt(1 - (1 - cosine * cosine) / (index * index));
    const double r12 = schlick(square((index - 1) / (index + 1)), cosine), t121 = 1 - r12;
    double r23[3], shift[3], term[3];
    for (int c = 0; c < 3; ++c) {
        const double root = sqrt(fmin((double)f0[c], 0.9999)), base = (1 + root) / (1 - root);
        r23[c] = schlick(square((base - index) / (base + index)), inner);
        shift[c] = M_PI + (base < index ? M_PI : 0);
    }
    for (int c = 0; c < 3; ++c) {
        const double rs = t121 * t121 * r23[c] / (1 - fmin(fmax(r12 * r23[c], 1e-5), 0.9999));
        rgb[c] = r12 + rs;
        term[c] = rs - t121;
    }
    for (int k = 1; k <= 2; ++k) {
        double s[3], shifts[3] = {k * shift[0], k * shift[1], k * shift[2]};
        sensitivity(2 * index * thickness * inner * k, shifts, s);
        for (int c = 0; c < 3; ++c) {
            term[c] *= sqrt(fmin(fmax(r12 * r23[c], 1e-5), 0.9999));
            rgb[c] += term[c] * 2 * s[c];
        }
    }
    for (int c = 0; c < 3; ++c) rgb[c] = fmin(fmax(rgb[c], 0), 1);
}

/* With mu = x^2: 4 ∫ f x^3 dx, by Simpson's rule. */
static float mean_of(const float curve[FILM_STEPS + 1]) {
    float sum = 0;
    for (int k = 0; k <= FILM_STEPS; ++k) {
        const float x = (float)k / FILM_STEPS, weight = k == 0 || k == FILM_STEPS ? 1 : (k % 2 ? 4 : 2);
        sum += weight * curve[k] * x * x * x;
    }
    return sum * 4 / (3.0f * FILM_STEPS);
}

typedef float film_curves[3][FILM_STEPS + 1];

static double plain(float f0, float f90, double rise) {
    return (double)f0 + ((double)f90 - (double)f0) * rise;
}

/* By glTF's formulas alone, the base gets what the brightest channel does not reflect. With
 * `multiscatter`, each channel of the base gets what the film does not reflect in that channel, so that
 * nothing is lost. Without a film, the brightest channel still counts for all (KHR_materials_specular). */
static void set_node(const fathom_material *m, const float layer[3], int k, film_curves dielectric,
                     film_curves metal, film_curves kept) {
    const float most_layer = fmaxf(layer[0], fmaxf(layer[1], layer[2])), s = m->specular_factor;
    const double x = (double)k / FILM_STEPS, rise = pow(1 - x * x, 5), part = (double)m->iridescence;
    double over_metal[3], over_base[3], most = 0;
    reflectance(m, m->base_color, x * x, over_metal);
    reflectance(m, layer, x * x, over_base);
    for (int c = 0; c < 3; ++c) {
        const double reflected = part * over_base[c] + (1 - part) * plain(layer[c], s, rise);
        dielectric[c][k] = (float)reflected, most = fmax(most, reflected);
        metal[c][k] = (float)(part * over_metal[c] + (1 - part) * plain(m->base_color[c], 1, rise));
        kept[c][k] = (float)(part * over_base[c] + (1 - part) * plain(most_layer, s, rise));
    }
    for (int c = 0; c < 3 && !m->multiscatter; ++c) kept[c][k] = (float)most;
}

void prepare_film(const fathom_material *m, const float layer[3], shader *out, film_means *means) {
    film_curves dielectric, metal;
    for (int k = 0; k <= FILM_STEPS; ++k) set_node(m, layer, k, dielectric, metal, out->film_kept);
    out->layer0 = out->layer90 = 0;
    for (int c = 0; c < 3; ++c) {
        for (int k = 0; k <= FILM_STEPS; ++k)
            out->film[c][k] = (1 - m->metallic) * dielectric[c][k] + m->metallic * metal[c][k];
        means->dielectric[c] = mean_of(dielectric[c]), means->metal[c] = mean_of(metal[c]);
        means->kept[c] = mean_of(out->film_kept[c]);
        out->layer0 += out->film_kept[c][FILM_STEPS] * (1 / 3.0f);
        out->layer90 += out->film_kept[c][0] * (1 / 3.0f);
    }
    out->lobes |= SHADER_FILM | SHADER_LAYER;
}

/* Schlick's part of the reflectance uses the albedos of the tables, which depend on the azimuth. The
 * film's difference from it uses the mean over the azimuth. */
void prepare_film_base(const film_means *means, float mean, shader *out) {
    const bool smooth = !(out->lobes & (SHADER_GGX | SHADER_THIN | SHADER_REFRACT));
    out->film_high = out->film_kept[0][0];
    for (int c = 0; c < 3; ++c) {
        float rest[FILM_STEPS + 1];
        const float low = out->film_kept[c][FILM_STEPS];
        for (int k = 0; k <= FILM_STEPS; ++k) {
            const float x = (float)k / FILM_STEPS, less = 1 - x * x,
                        rise = less * less * (less * less) * less;
            rest[k] = out->film_kept[c][k] - (low + (out->film_high - low) * rise);
        }
        memset(out->film_rest[c], 0, sizeof out->film_rest[c]);
        if (smooth)
            memcpy(out->film_rest[c], rest, sizeof rest);
        else
            energy_facets(out->along, out->alpha, rest, out->film_rest[c]);
        out->film_low[c] = low;
        out->film_again[c] = mixture_again(means->kept[c], means->kept[c], mean);
    }
}
