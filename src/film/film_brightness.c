/* Measures the brightness of a film, and chooses an exposure for it. */
#include "base/sized.h"
#include "film/film.h"
#include "math/rgb.h"

#include <string.h>

/* A bin is one sixteenth of an octave: its index is the sign, the exponent and four bits of the mantissa. */
#define BIN_SHIFT 19
#define BINS (1u << (31 - BIN_SHIFT))

/* Fraction of the lit pixels that may be brighter than white: highlights and visible lights. */
#define BRIGHTEST 0.01

static uint32_t bin_of(float value) {
    uint32_t bits;
    memcpy(&bits, &value, sizeof bits);
    return bits >> BIN_SHIFT;
}

/* The smallest value above the bin. */
static float bin_end(uint32_t bin) {
    const uint32_t bits = (bin + 1) << BIN_SHIFT;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static bool shows_background(const fathom_film *film, size_t pixel) {
    if (film->alpha) return film->alpha[pixel] == 0;
    return film->rgb[0][pixel] == film->background[0] && film->rgb[1][pixel] == film->background[1] &&
           film->rgb[2][pixel] == film->background[2];
}

/* The pixel's largest channel, divided by alpha. */
static float brightness_at(const fathom_film *film, size_t pixel) {
    const float largest = fmaxf(film->rgb[0][pixel], fmaxf(film->rgb[1][pixel], film->rgb[2][pixel]));
    const float alpha = film->alpha ? film->alpha[pixel] : 1;
    return alpha > 0 && alpha < 1 ? largest / alpha : largest;
}

/* The largest exposure, in steps of 0.1, at which no more than the allowed number of pixels are brighter than
 * white. */
static float exposure_for(const uint64_t counts[BINS], uint64_t lit) {
    const double most = BRIGHTEST * (double)lit;
    uint64_t above = 0;
    uint32_t bin = BINS - 1;
    while (bin > 0 && (double)(above + counts[bin]) <= most) above += counts[bin--];
    return (float)(floor(-10 * log2((double)bin_end(bin))) / 10 + 0.0); /* + 0.0 avoids -0 */
}

static void look(const fathom_film *film, float exposure, fathom_brightness *out) {
    uint64_t counts[BINS] = {0};
    const float white = exp2f(-exposure);
    for (size_t i = 0; i < (size_t)film->width * film->height; ++i) {
        if (shows_background(film, i)) continue;
        const float value = brightness_at(film, i);
        ++out->pixels;
        out->black += value > 0 ? 0 : 1;
        out->clipped += value > white ? 1 : 0;
        if (value > 0) ++counts[bin_of(value)];
    }
    /* Black surfaces look as a black background does. If nothing else is seen, they count. */
    if (!out->pixels && !film->alpha && !rgb_any(film->background))
        out->pixels = out->black = (uint64_t)film->width * film->height;
    out->in_studio = film->in_studio;
    if (out->black < out->pixels) out->exposure = exposure_for(counts, out->pixels - out->black);
}

bool fathom_film_exposure(const fathom_film *film, float *stops) {
    if (!film || !stops || !film->exposed) return false;
    *stops = film->exposure;
    return true;
}

fathom_status fathom_film_brightness(const fathom_film *film, float exposure, fathom_brightness *out) {
    fathom_brightness found = {.pixels = 0};
    fathom_status status = sized_check(NULL, "out", out, sizeof found);
    if (status != FATHOM_OK) return status;
    if (film) look(film, exposure, &found);
    sized_write(out, &found, sizeof found);
    return FATHOM_OK;
}
