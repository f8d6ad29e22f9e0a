/* Fireflies, after Zirr, Hanika and Dachsbacher, "Reweighting Firefly Samples for Improved Finite-Sample
 * Monte Carlo Estimates" (Computer Graphics Forum 37(6), 2018).
 *
 * Cascades. A sample's brightness L is the mean of its R, G and B. Cascade k stands for b_k = 2^octave * 8^k,
 * with any integer k. A sample between b_k and b_(k+1) is split: the fraction f = (8 b_k / L - 1) / 7 goes to
 * cascade k, and 1 - f to cascade k + 1. So the brightness in a cascade, divided by b_k, is its number of
 * samples, without a counter: f L / b_k + (1 - f) L / b_(k+1) = 1. The octave follows the brightest light of
 * the scene: if all lights become brighter by a power of two, the sums do too, and keep their bits.
 *
 * Slots. A pixel has 12 slots, and cascade k is in slot k modulo 12. So cascades that share a slot are 2^36
 * apart, and the darker one adds nothing visible. The sum in a slot tells which cascade it is: its number of
 * samples must be from 2^-18 to 2^18. A pixel has at most 2^16 samples. Less than 2^-18 of a sample counts
 * for the darker cascade.
 *
 * Weights. A pixel of N samples is the sum of its cascades' means C_k times
 *
 *     w_k = (n_k + N E_k / b_k - 1) / kappa, clamped to [0, 1].
 *
 * n_k is the number of samples of similar or higher brightness: those in cascades k - 1 and above. It is the
 * mean over 3 x 3 pixels, or the pixel's own number if that is larger and more than a single sample. The 1
 * subtracts the sample itself. E_k is the brightness that the darker cascades have given the pixel so far.
 * N E_k / b_k is the number of samples of this cascade that would add the same brightness again; so samples
 * that hardly change the pixel keep their weight. kappa is 4, but at most (N - 1) / 2.
 *
 * A smooth image keeps its bits: if the samples of each pixel are within a factor of 1.5, all weights are 1.
 * In the worst case one sample is just above b_j, and N - 1 samples are at x b_j, x = 2/3. Each of these has
 * 8 (1 - x) / 7 < 0.39 of a sample in the cascade j - 1, which n_(j+1) does not count. So n_(j+1) is above
 * 1 + 0.61 (N - 1).
 *
 * The paper uses the pixel's own count only if the mean of the block is above 1. We always use the larger of
 * both. So the edge of a lamp keeps its samples because of the lamp, and a small light that several samples
 * of its pixel hit keeps them. */
#include "base/text.h"
#include "film/film.h"

#include <stdio.h>
#include <string.h>

#define KAPPA 4.0
#define SLOTS ((int)FIREFLY_CASCADES)

/* The quotient rounded down, and its remainder from 0 on. */
static int quotient(int a, int b) { return a / b - (a % b < 0); }
static int remainder_of(int a, int b) { return a - b * quotient(a, b); }

static double cascade_brightness(uint32_t octave, int k) { return ldexp(1, (int)octave + 3 * k); }

static void keep_brightest(double *brightest, const float rgb[3], float factor) {
    for (int c = 0; c < 3; ++c) *brightest = fmax(*brightest, (double)rgb[c] * (double)factor);
}

uint32_t fireflies_octave(const fathom_scene *scene) {
    double brightest = 0;
    keep_brightest(&brightest, scene->background, 1);
    for (size_t i = 0; i < scene->lights.count; ++i)
        keep_brightest(&brightest, scene->lights.items[i].intensity, 1);
    for (size_t i = 0; i < scene->environments.count; ++i)
        keep_brightest(&brightest, scene->environments.items[i].intensity, 1);
    for (size_t i = 0; i < scene->materials.count; ++i) {
        const fathom_material *m = &scene->materials.items[i].value;
        keep_brightest(&brightest, m->k_e, 1);
        keep_brightest(&brightest, m->emissive, m->emissive_strength);
    }
    return brightest > 0 ? (uint32_t)remainder_of(ilogb(brightest), 3) : 0;
}

/* ---- sums ---- */

typedef struct share {
    int slot;
    double of_it; /* fraction of the sample; the next cascade gets the rest */
} share;

static share share_of(double brightness, uint32_t octave) {
    if (!(brightness > 0 && brightness < (double)INFINITY)) return (share){0, 1};
    const int k = quotient(ilogb(brightness) - (int)octave, 3);
    return (share){remainder_of(k, SLOTS), (8 * cascade_brightness(octave, k) / brightness - 1) / 7};
}

void fireflies_add(const wave_samples *samples, uint32_t from, uint32_t octave, double (*to)[WAVE_SLOTS],
                   uint32_t slot) {
    for (uint32_t i = 0; i < LANES; ++i) {
        double rgb[3], sum = 0;
        for (int c = 0; c < 3; ++c) rgb[c] = (double)samples->radiance[c][from + i], sum += rgb[c];
        const share s = share_of(sum / 3, octave);
        double(*here)[WAVE_SLOTS] = to + 3 * s.slot, (*next)[WAVE_SLOTS] = to + 3 * ((s.slot + 1) % SLOTS);
        for (uint32_t c = 0; c < 3; ++c) {
            here[c][slot + i] += s.of_it * rgb[c];
            if (s.of_it < 1) next[c][slot + i] += (1 - s.of_it) * rgb[c];
        }
    }
}

/* ---- the second image ---- */

static double mean_in(const fathom_film *film, int slot, int c, size_t pixel) {
    const size_t pixels = (size_t)film->width * film->height, layer = 3 * (film->parts.layers + (size_t)slot);
    return (double)film->layers[(layer + (size_t)c) * pixels + pixel];
}

/* The content of a slot of a pixel. */
typedef struct cascade {
    int k, slot;
    double grey, count; /* share of the pixel's mean; number of samples, not an integer */
} cascade;

/* False: nothing. */
static bool cascade_in(const fathom_film *film, int slot, size_t pixel, cascade *out) {
    const double grey =
        (mean_in(film, slot, 0, pixel) + mean_in(film, slot, 1, pixel) + mean_in(film, slot, 2, pixel)) / 3;
    if (!(grey > 0 && grey < (double)INFINITY)) return false;
    const uint32_t octave = film->parts.octave;
    const double sum = grey * film->samples[pixel];
    const int turns = quotient(ilogb(sum) - (int)octave - 3 * slot + 18, 3 * SLOTS), k = slot + SLOTS * turns;
    *out = (cascade){k, slot, grey, sum / cascade_brightness(octave, k)};
    return true;
}

/* Lists a pixel's cascades, the darkest first, and returns their number. */
static int cascades_of(const fathom_film *film, size_t pixel, cascade out[FIREFLY_CASCADES]) {
    int count = 0;
    for (int slot = 0; slot < SLOTS; ++slot) {
        cascade next;
        if (!cascade_in(film, slot, pixel, &next)) continue;
        int at = count++;
        for (; at > 0 && out[at - 1].k > next.k; --at) out[at] = out[at - 1];
        out[at] = next;
    }
    return count;
}

/* Number of samples of a pixel in cascades k - 1 and above. */
static double count_near(const fathom_film *film, int k, size_t pixel) {
    double count = 0;
    for (int slot = 0; slot < SLOTS; ++slot) {
        cascade c;
        if (cascade_in(film, slot, pixel, &c) && c.k >= k - 1) count += c.count;
    }
    return count;
}

/* The mean count over 3 x 3 pixels inside the film, or the pixel's own count if that is larger and means more
 * than one sample. Counts are not integers, because samples are split between cascades; hence 1.5. */
static double count_of(const fathom_film *film, int k, uint32_t x, uint32_t y) {
    double sum = 0;
    uint32_t pixels = 0;
    for (uint32_t v = y ? y - 1 : 0; v <= y + 1 && v < film->height; ++v) {
        for (uint32_t u = x ? x - 1 : 0; u <= x + 1 && u < film->width; ++u, ++pixels)
            sum += count_near(film, k, (size_t)v * film->width + u);
    }
    const double own = count_near(film, k, (size_t)y * film->width + x);
    return fmax(own > 1.5 ? own : 0, sum / pixels);
}

/* False: all weights are 1, or there are too few samples to decide. */
static bool reweight_pixel(const fathom_film *film, uint32_t x, uint32_t y, double out[3]) {
    const size_t pixel = (size_t)y * film->width + x;
    const double samples = film->samples[pixel], kappa = fmin(KAPPA, (samples - 1) / 2);
    bool changed = false;
    double grey = 0;
    cascade all[FIREFLY_CASCADES];
    const int cascades = cascades_of(film, pixel, all);
    for (int c = 0; c < 3; ++c) out[c] = 0;
    for (int i = 0; i < cascades && kappa > 0; ++i) {
        const double count = count_of(film, all[i].k, x, y),
                     enough = count + grey / all[i].grey * all[i].count - 1,
                     weight = fmin(fmax(enough / kappa, 0), 1);
        changed |= weight < 1;
        for (int c = 0; c < 3; ++c) out[c] += weight * mean_in(film, all[i].slot, c, pixel);
        grey += weight * all[i].grey;
    }
    return changed;
}

typedef struct removal {
    double before, after;
    size_t pixels;
} removal;

/* Pixels whose weights are all 1 keep their bits. */
static removal reweight(const fathom_film *film, fathom_film *out) {
    removal r = {.pixels = 0};
    for (uint32_t y = 0; y < film->height; ++y) {
        for (uint32_t x = 0; x < film->width; ++x) {
            const size_t pixel = (size_t)y * film->width + x;
            double rgb[3];
            const bool changed = reweight_pixel(film, x, y, rgb);
            r.pixels += changed;
            for (int c = 0; c < 3; ++c) {
                out->rgb[c][pixel] = changed ? (float)rgb[c] : film->rgb[c][pixel];
                r.before += (double)film->rgb[c][pixel], r.after += (double)out->rgb[c][pixel];
            }
        }
    }
    return r;
}

static void tell(const removal *r, size_t pixels, char out[FIREFLY_TEXT]) {
    const locale_t own = text_locale_begin();
    snprintf(out, FIREFLY_TEXT,
             "reweighted after Zirr, Hanika and Dachsbacher 2018 (cascades by 8, kappa %g): "
             "%.4g %% of the light taken off, in %.4g %% of the pixels",
             KAPPA, r->before > 0 ? 100 * (1 - r->after / r->before) : 0,
             100 * (double)r->pixels / (double)pixels);
    text_locale_end(own);
}

fathom_status fathom_film_reweight(fathom_context *context, const fathom_film *film, fathom_film **out) {
    if (!out) return fail_null(context, "out");
    *out = NULL;
    if (!context || !film) return fail_null(context, "film");
    if (!film->parts.cascades) return FATHOM_OK;
    fathom_film like = *film;
    like.settings.aovs &= FATHOM_AOV_ALPHA;
    like.settings.fireflies = FATHOM_FIREFLIES_KEEP;
    memset(like.manifests, 0, sizeof like.manifests);
    fathom_status status = film_create_like(context, &like, out);
    if (status != FATHOM_OK) return status;
    const removal r = reweight(film, *out);
    const size_t pixels = (size_t)film->width * film->height;
    if (film->alpha) memcpy((*out)->alpha, film->alpha, pixels * sizeof *film->alpha);
    (*out)->settings = film->settings;
    (*out)->stats = film->stats, (*out)->interrupted = film->interrupted;
    tell(&r, pixels, (*out)->fireflies);
    return FATHOM_OK;
}
