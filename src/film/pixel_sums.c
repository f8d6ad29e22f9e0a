#include "film/pixel_sums.h"

#include "base/kernel.h"

#include <stdlib.h>
#include <string.h>

KERNEL_BEST(film_kernels)

bool pixel_sums_create(const sampler *from, uint32_t groups, film_parts parts, pixel_sums *out) {
    out->groups = groups;
    out->equal = false;
    out->sampler = *from;
    out->kernels = film_kernels_best();
    out->parts = parts;
    out->hits = parts.hits ? malloc(sizeof *out->hits) : NULL;
    const uint32_t layers = film_part_sums(parts);
    out->layers = layers ? malloc(3 * layers * sizeof *out->layers) : NULL;
    out->mattes = parts.matte_count ? malloc(parts.matte_count * sizeof *out->mattes) : NULL;
    if ((out->hits || !parts.hits) && (out->layers || !layers) && (out->mattes || !parts.matte_count))
        return true;
    pixel_sums_destroy(out);
    return false;
}

void pixel_sums_destroy(pixel_sums *sums) {
    free(sums->hits);
    free(sums->layers);
    free(sums->mattes);
    sums->hits = NULL, sums->layers = NULL, sums->mattes = NULL;
}

void hit_sums_clear(hit_sums *hits) {
    memset(hits, 0, sizeof *hits);
    for (uint32_t slot = 0; slot < WAVE_SLOTS; ++slot) hits->nearest[slot] = INFINITY;
}

void pixel_sums_clear(pixel_sums *sums) {
    memset(sums->rgb, 0, sums->groups * sizeof *sums->rgb);
    if (sums->hits) hit_sums_clear(sums->hits);
    if (sums->layers) memset(sums->layers, 0, 3 * film_part_sums(sums->parts) * sizeof *sums->layers);
    if (sums->mattes) memset(sums->mattes, 0, sums->parts.matte_count * sizeof *sums->mattes);
}

static double distance_to_centre(const sampler *from, sample_key key) {
    double dx, dy;
    sample_2d(from, key, SAMPLE_PIXEL, &dx, &dy);
    return (dx - 0.5) * (dx - 0.5) + (dy - 0.5) * (dy - 0.5);
}

static void keep_centre(hit_sums *sums, const first_hits *f, uint32_t from, uint32_t slot) {
    sums->centre.z[slot] = f->z[from];
    for (int c = 0; c < 3; ++c) sums->centre.p[c][slot] = f->p[c][from];
    for (int c = 0; c < 4; ++c) sums->centre.motion[c][slot] = f->motion[c][from];
    sums->centre.object[slot] = f->object[from];
    sums->centre.primitive[slot] = f->primitive[from];
    sums->centre.instance[slot] = f->instance[from];
}

/* Adds the first hit of a sample, from its slot in the batch to its slot in the sums. */
static void add_hit(hit_sums *hits, const sampler *of, const first_hits *f, uint32_t from, uint32_t slot,
                    sample_key key) {
    hits->alpha[slot] += (double)f->alpha[from];
    for (int c = 0; c < 3; ++c) {
        hits->n[c][slot] += (double)f->n[c][from];
        hits->albedo[c][slot] += (double)f->albedo[c][from];
    }
    double distance = distance_to_centre(of, key);
    if (distance >= hits->nearest[slot]) return;
    hits->nearest[slot] = distance;
    keep_centre(hits, f, from, slot);
}

static uint32_t slot_of(const wave_region *region, const wave_square *square) {
    return wave_slot(square->left - region->left, square->top - region->top);
}

void hit_sums_add(hit_sums *hits, const sampler *from, const first_hits *first, const wave_region *region,
                  const wave_batch *batch, uint32_t place) {
    const wave_square *square = &batch->squares[place];
    const uint32_t to = slot_of(region, square);
    for (uint32_t left = wave_square_pixels(region, square); left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        add_hit(hits, from, first, place * LANES + k, to + k, wave_square_key(square, k));
    }
}

void matte_sums_add(matte_list (*mattes)[WAVE_SLOTS], const wave_samples *samples, film_parts parts,
                    const wave_region *region, const wave_batch *batch, uint32_t place) {
    const wave_square *square = &batch->squares[place];
    const uint32_t to = slot_of(region, square);
    for (uint32_t left = wave_square_pixels(region, square); left; left &= left - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(left);
        for (uint32_t m = 0; m < parts.matte_count; ++m)
            matte_add(&mattes[m][to + k], samples->mattes[m][place * LANES + k], 1);
    }
}

/* Adds whole squares: slots outside the region hold no radiance. */
void pixel_sums_add(pixel_sums *sums, const wave_samples *samples, const wave_region *region,
                    const wave_batch *batch, uint32_t place) {
    const wave_square *square = &batch->squares[place];
    const uint32_t from = place * LANES, to = slot_of(region, square);
    for (int c = 0; c < 3; ++c)
        sums->kernels->add_samples(samples->radiance[c] + from, sums->rgb[square->group][c] + to);
    for (uint32_t k = 0; k < 3 * sums->parts.layers; ++k)
        sums->kernels->add_samples(samples->layers[k] + from, sums->layers[k] + to);
    if (sums->parts.cascades)
        fireflies_add(samples, from, sums->parts.octave, sums->layers + 3 * sums->parts.layers, to);
    if (sums->mattes) matte_sums_add(sums->mattes, samples, sums->parts, region, batch, place);
    if (sums->hits) hit_sums_add(sums->hits, &sums->sampler, samples->first, region, batch, place);
}

/* ---- the error ---- */

static double samples_of_group(const pixel_sums *sums, uint32_t samples, uint32_t group) {
    return sums->equal ? samples / (double)sums->groups : wave_group_count(samples, group, sums->groups);
}

static double sum_of(const pixel_sums *sums, int c, uint32_t slot) {
    double sum = sums->rgb[0][c][slot];
    for (uint32_t g = 1; g < sums->groups; ++g) sum += sums->rgb[g][c][slot];
    return sum;
}

/* Groups g of n samples are independent, and their means have the variance σ²/n. So the sum over groups of
 * n (mean of the group - mean)² has the expectation (groups - 1) σ², and the variance of the mean is σ²
 * divided by the number of all samples. If all n are equal, this also holds for groups with different
 * variances. */
double pixel_sums_error(const pixel_sums *sums, uint32_t slot, uint32_t samples, double squared[3]) {
    double grey = 0;
    for (int c = 0; c < 3; ++c) {
        const double mean = sum_of(sums, c, slot) / samples;
        grey += mean / 3;
        squared[c] = samples < SAMPLE_GROUPS || sums->groups == 1 ? (double)INFINITY : 0;
        for (uint32_t g = 0; g < sums->groups && isfinite(squared[c]); ++g) {
            const double n = samples_of_group(sums, samples, g), d = sums->rgb[g][c][slot] / n - mean;
            squared[c] += n * d * d / (samples * (sums->groups - 1.0));
        }
    }
    return grey;
}

/* For two groups of m and n samples, the difference of the means has the variance σ² (1/m + 1/n). */
static double variance_by(const pixel_sums *sums, int c, uint32_t slot, uint32_t samples, uint32_t a,
                          uint32_t b) {
    const double m = samples_of_group(sums, samples, a), n = samples_of_group(sums, samples, b),
                 d = sums->rgb[a][c][slot] / m - sums->rgb[b][c][slot] / n;
    return d * d / ((1 / m + 1 / n) * samples);
}

/* The squared variance of the mean, summed over the channels. Four groups can be split into two pairs in
 * three ways. For each way, multiplies the variance estimates of both pairs; takes the mean of the three
 * products. No group is in both factors, so the result is unbiased. */
static double squared_variance(const pixel_sums *sums, uint32_t slot, uint32_t samples) {
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        for (uint32_t g = 1; g < SAMPLE_GROUPS; ++g)
            sum += variance_by(sums, c, slot, samples, 0, g) *
                   variance_by(sums, c, slot, samples, g == 1 ? 2 : 1, g == 3 ? 2 : 3) / 3;
    }
    return sum;
}

/* ---- to the film ---- */

static void store_hits(const hit_sums *hits, uint32_t slot, double scale, size_t pixel, fathom_film *film) {
    for (int c = 0; c < 3; ++c) {
        if (film->n[c]) film->n[c][pixel] = (float)(hits->n[c][slot] * scale);
        if (film->albedo[c]) film->albedo[c][pixel] = (float)(hits->albedo[c][slot] * scale);
        if (film->p[c]) film->p[c][pixel] = hits->centre.p[c][slot];
    }
    if (film->alpha) film->alpha[pixel] = (float)(hits->alpha[slot] * scale);
    if (film->z) film->z[pixel] = hits->centre.z[slot];
    for (int c = 0; film->motion[0] && c < 4; ++c) film->motion[c][pixel] = hits->centre.motion[c][slot];
    if (film->object) {
        film->object[pixel] = hits->centre.object[slot];
        film->primitive[pixel] = hits->centre.primitive[slot];
        film->instance[pixel] = hits->centre.instance[slot];
    }
}

static void store_layers(const pixel_sums *sums, uint32_t slot, double scale, size_t pixel,
                         fathom_film *film) {
    const size_t pixels = (size_t)film->width * film->height;
    for (uint32_t k = 0; k < 3 * film_part_sums(sums->parts); ++k)
        film->layers[k * pixels + pixel] = (float)(sums->layers[k][slot] * scale);
}

static void store_mattes(const pixel_sums *sums, uint32_t slot, uint32_t samples, size_t pixel,
                         fathom_film *film) {
    const size_t pixels = (size_t)film->width * film->height;
    for (uint32_t m = 0; m < film->parts.matte_count; ++m) {
        float ranks[2 * MATTE_RANKS];
        matte_rank(&sums->mattes[m][slot], samples, ranks);
        for (uint32_t k = 0; k < 2 * MATTE_RANKS; ++k)
            film->mattes[(m * 2 * MATTE_RANKS + k) * pixels + pixel] = ranks[k];
    }
}

/* All n samples are equal. With a probability of 5 %, they missed something that covers 1 - 0.05^(1/n) of
 * the pixel. */
static void store_bound(uint32_t samples, size_t pixel, fathom_film *film) {
    const double share = 1 - pow(0.05, 1.0 / samples);
    film->doubt[pixel] = 0;
    for (int c = 0; c < 3; ++c) {
        const double more = fmax((double)film->brightest[c] - (double)film->rgb[c][pixel], 0);
        film->error[c][pixel] = (float)(share * more / FILM_ERROR_T);
        if (more > 0) film->doubt[pixel] = 1;
    }
}

/* The means of equal samples differ only by rounding errors of double. */
static bool are_alike(const double squared[3], double grey) {
    return squared[0] + squared[1] + squared[2] <= 0x1p-80 * grey * grey;
}

static void store_error(const pixel_sums *sums, uint32_t slot, uint32_t samples, size_t pixel,
                        fathom_film *film) {
    double squared[3];
    const double grey = pixel_sums_error(sums, slot, samples, squared);
    const bool known = isfinite(squared[0]);
    double squares = 0;
    for (int c = 0; c < 3; ++c) {
        squares += squared[c] * squared[c];
        film->error[c][pixel] = (float)sqrt(squared[c]);
    }
    film->doubt[pixel] = known ? 0 : 1;
    if (known && are_alike(squared, grey))
        store_bound(samples, pixel, film);
    else if (known && squares > 0)
        film->doubt[pixel] =
            (float)fmin(squared_variance(sums, slot, samples) / (FILM_ERROR_PRODUCTS * squares), 0.99);
}

static void store_pixel(const pixel_sums *sums, uint32_t slot, sums_count count, uint32_t x, uint32_t y,
                        fathom_film *film) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    double scale = 1.0 / count.samples;
    for (int c = 0; c < 3; ++c) film->rgb[c][pixel] = (float)(sum_of(sums, c, slot) * scale);
    if (sums->hits) store_hits(sums->hits, slot, 1.0 / count.hits, pixel, film);
    if (sums->layers) store_layers(sums, slot, scale, pixel, film);
    if (sums->mattes) store_mattes(sums, slot, count.hits, pixel, film);
    if (film->doubt) store_error(sums, slot, count.samples, pixel, film);
    if (film->samples) film->samples[pixel] = count.samples;
}

static void store_square(const pixel_sums *sums, uint32_t slot, uint32_t samples, uint32_t x, uint32_t y,
                         fathom_film *film) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    for (int c = 0; c < 3; ++c)
        sums->kernels->store_square(sums->rgb[0][c] + slot, 1.0 / samples, film->width, film->rgb[c] + pixel);
}

/* Stores the part of a square that lies in the region. */
static void store_pixels(const pixel_sums *sums, const wave_region *r, const wave_square *square,
                         uint32_t slot, sums_count count, fathom_film *film) {
    for (uint32_t left = wave_square_pixels(r, square); left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        store_pixel(sums, slot + k, count, square->left + k % 4, square->top + k / 4, film);
    }
}

void pixel_sums_store_square(const pixel_sums *sums, const wave_region *r, const wave_square *square,
                             sums_count count, fathom_film *film) {
    uint32_t slot = slot_of(r, square);
    if (wave_square_is_whole(r, square) && sums->groups == 1 && !sums->hits && !sums->layers &&
        !sums->mattes && !film->samples && !film->doubt)
        store_square(sums, slot, count.samples, square->left, square->top, film);
    else
        store_pixels(sums, r, square, slot, count, film);
}
