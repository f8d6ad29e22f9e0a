/* Fireflies, after Zirr, Hanika and Dachsbacher, "Reweighting Firefly Samples for Improved Finite-Sample
 * Monte Carlo Estimates" (Computer Graphics Forum 37(6), 2018).
 *
 * Cascades. A sample's brightness L is the mean of its R, G and B. Cascade k stands for b_k = 2^-10 * 8^k. A
 * sample between b_k and b_(k+1) is split: the fraction f = (8 b_k / L - 1) / 7 goes to cascade k, and 1 - f
 * to cascade k + 1. Darker samples go to the first cascade, brighter ones to the last. So the brightness in a
 * cascade, divided by b_k, is its number of samples, without a counter: f L / b_k + (1 - f) L / b_(k+1) = 1.
 * A sample brighter than the last cascade, 2^23, counts as several.
 *
 * Weights. A pixel of N samples is the sum of its cascades' means C_k times
 *
 *     w_k = (n_k + N E_k / b_k - 1) / kappa, clamped to [0, 1].
 *
 * n_k is the number of samples of similar or higher brightness: those in cascades k - 1 and above. It is the
 * mean over 3 x 3 pixels, or the pixel's own number if that is larger and more than a single sample. The 1
 * subtracts the sample itself. E_k is the brightness that the darker cascades have given the pixel so far.
 * N E_k / b_k is the number of samples of this cascade that would add the same brightness again; so samples
 * that hardly change the pixel keep their weight. kappa is 4, but at most (N - 1) / 2. The first cascade has
 * the weight 1.
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

#define DARKEST 0x1p-10
#define KAPPA 4.0

static double cascade_brightness(uint32_t k) { return ldexp(DARKEST, (int)(3 * k)); }

/* ---- sums ---- */

typedef struct share {
    uint32_t cascade;
    double of_it; /* fraction of the sample; the next cascade gets the rest */
} share;

static share share_of(double brightness) {
    const int exponent = brightness > DARKEST ? ilogb(brightness / DARKEST) : 0;
    const uint32_t k = (uint32_t)exponent / 3;
    if (!(brightness > DARKEST) || k >= FIREFLY_CASCADES - 1) return (share){k ? FIREFLY_CASCADES - 1 : 0, 1};
    return (share){k, (8 * cascade_brightness(k) / brightness - 1) / 7};
}

void fireflies_add(const wave_samples *samples, uint32_t from, double (*to)[WAVE_SLOTS], uint32_t slot) {
    for (uint32_t i = 0; i < LANES; ++i) {
        double rgb[3], sum = 0;
        for (int c = 0; c < 3; ++c) rgb[c] = (double)samples->radiance[c][from + i], sum += rgb[c];
        const share s = share_of(sum / 3);
        for (uint32_t c = 0; c < 3; ++c) {
            to[3 * s.cascade + c][slot + i] += s.of_it * rgb[c];
            if (s.of_it < 1) to[3 * s.cascade + 3 + c][slot + i] += (1 - s.of_it) * rgb[c];
        }
    }
}

/* ---- the second image ---- */

static double mean_in(const fathom_film *film, uint32_t k, int c, size_t pixel) {
    const size_t pixels = (size_t)film->width * film->height, layer = 3 * (film->parts.layers + k);
    return (double)film->layers[(layer + (size_t)c) * pixels + pixel];
}

static double grey_in(const fathom_film *film, uint32_t k, size_t pixel) {
    return (mean_in(film, k, 0, pixel) + mean_in(film, k, 1, pixel) + mean_in(film, k, 2, pixel)) / 3;
}

/* Number of samples of a pixel in cascades k - 1 and above. */
static double count_near(const fathom_film *film, uint32_t k, size_t pixel) {
    double count = 0;
    for (uint32_t i = k ? k - 1 : 0; i < FIREFLY_CASCADES; ++i)
        count += grey_in(film, i, pixel) / cascade_brightness(i);
    return count * film->samples[pixel];
}

/* The mean count over 3 x 3 pixels inside the film, or the pixel's own count if that is larger and means more
 * than one sample. Counts are not integers, because samples are split between cascades; hence 1.5. */
static double count_of(const fathom_film *film, uint32_t k, uint32_t x, uint32_t y) {
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
    for (int c = 0; c < 3; ++c) out[c] = mean_in(film, 0, c, pixel), grey += out[c] / 3;
    for (uint32_t k = 1; k < FIREFLY_CASCADES && kappa > 0; ++k) {
        const double here = grey_in(film, k, pixel);
        if (!(here > 0)) continue;
        const double count = count_of(film, k, x, y),
                     enough = count + samples * grey / cascade_brightness(k) - 1,
                     weight = fmin(fmax(enough / kappa, 0), 1);
        changed |= weight < 1;
        for (int c = 0; c < 3; ++c) out[c] += weight * mean_in(film, k, c, pixel);
        grey += weight * here;
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
             "reweighted after Zirr, Hanika and Dachsbacher 2018 (%u cascades from 2^-10 by 8, kappa %g): "
             "%.4g %% of the light taken off, in %.4g %% of the pixels",
             FIREFLY_CASCADES, KAPPA, r->before > 0 ? 100 * (1 - r->after / r->before) : 0,
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
