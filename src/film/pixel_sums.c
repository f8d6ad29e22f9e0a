#include "film/pixel_sums.h"

#include "base/kernel.h"

#include <stdlib.h>
#include <string.h>

KERNEL_CHOICE(film_kernels)

bool pixel_sums_create(const sampler *from, bool hits, pixel_sums *out) {
    out->sampler = *from;
    out->kernels = film_kernels_best();
    out->hits = hits ? malloc(sizeof *out->hits) : NULL;
    return out->hits || !hits;
}

void pixel_sums_destroy(pixel_sums *sums) {
    free(sums->hits);
    sums->hits = NULL;
}

void pixel_sums_clear(pixel_sums *sums) {
    memset(sums->rgb, 0, sizeof sums->rgb);
    if (sums->hits) memset(sums->hits, 0, sizeof *sums->hits);
}

static double distance_to_centre(const sampler *from, sample_key key) {
    double dx, dy;
    sample_2d(from, key, SAMPLE_PIXEL, &dx, &dy);
    return (dx - 0.5) * (dx - 0.5) + (dy - 0.5) * (dy - 0.5);
}

static void keep_centre(hit_sums *sums, const first_hits *f, uint32_t from, uint32_t slot) {
    sums->centre.z[slot] = f->z[from];
    for (int c = 0; c < 3; ++c) sums->centre.p[c][slot] = f->p[c][from];
    sums->centre.object[slot] = f->object[from];
    sums->centre.primitive[slot] = f->primitive[from];
    sums->centre.instance[slot] = f->instance[from];
}

/* The first hit of a sample, from its slot in the batch to its slot in the sums. */
static void add_hit(pixel_sums *sums, const first_hits *f, uint32_t from, uint32_t slot, sample_key key) {
    hit_sums *hits = sums->hits;
    hits->alpha[slot] += (double)f->alpha[from];
    for (int c = 0; c < 3; ++c) {
        hits->n[c][slot] += (double)f->n[c][from];
        hits->albedo[c][slot] += (double)f->albedo[c][from];
    }
    double distance = distance_to_centre(&sums->sampler, key);
    if (key.index && distance >= hits->nearest[slot]) return;
    hits->nearest[slot] = distance;
    keep_centre(hits, f, from, slot);
}

/* Slots outside the region hold no radiance. */
void pixel_sums_add(pixel_sums *sums, const wave_samples *samples, const wave_region *region,
                    const wave_batch *batch, uint32_t place) {
    const wave_square *square = &batch->squares[place];
    uint32_t from = place * LANES, to = wave_slot(square->left - region->left, square->top - region->top);
    for (int c = 0; c < 3; ++c)
        sums->kernels->add_samples(samples->radiance[c] + from, LANES, sums->rgb[c] + to);
    if (!sums->hits) return;
    for (uint32_t left = wave_square_pixels(region, square); left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        add_hit(sums, samples->first, from + k, to + k, wave_square_key(square, k));
    }
}

static void store_hits(const hit_sums *hits, uint32_t slot, double scale, size_t pixel, fathom_film *film) {
    for (int c = 0; c < 3; ++c) {
        if (film->n[c]) film->n[c][pixel] = (float)(hits->n[c][slot] * scale);
        if (film->albedo[c]) film->albedo[c][pixel] = (float)(hits->albedo[c][slot] * scale);
        if (film->p[c]) film->p[c][pixel] = hits->centre.p[c][slot];
    }
    if (film->alpha) film->alpha[pixel] = (float)(hits->alpha[slot] * scale);
    if (film->z) film->z[pixel] = hits->centre.z[slot];
    if (film->object) {
        film->object[pixel] = hits->centre.object[slot];
        film->primitive[pixel] = hits->centre.primitive[slot];
        film->instance[pixel] = hits->centre.instance[slot];
    }
}

void pixel_sums_store(const pixel_sums *sums, uint32_t slot, uint32_t samples, uint32_t x, uint32_t y,
                      fathom_film *film) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    double scale = 1.0 / samples;
    for (int c = 0; c < 3; ++c) film->rgb[c][pixel] = (float)(sums->rgb[c][slot] * scale);
    if (sums->hits) store_hits(sums->hits, slot, scale, pixel, film);
    if (film->samples) film->samples[pixel] = samples;
}

static void store_square(const pixel_sums *sums, uint32_t slot, uint32_t samples, uint32_t x, uint32_t y,
                         fathom_film *film) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    for (int c = 0; c < 3; ++c)
        sums->kernels->store_square(sums->rgb[c] + slot, 1.0 / samples, film->width, film->rgb[c] + pixel);
}

/* The part of a square that lies in the region. */
static void store_pixels(const pixel_sums *sums, const wave_region *r, const wave_square *square,
                         uint32_t slot, uint32_t samples, fathom_film *film) {
    for (uint32_t left = wave_square_pixels(r, square); left; left &= left - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(left);
        pixel_sums_store(sums, slot + k, samples, square->left + k % 4, square->top + k / 4, film);
    }
}

void pixel_sums_store_square(const pixel_sums *sums, const wave_region *r, const wave_square *square,
                             uint32_t samples, fathom_film *film) {
    uint32_t slot = wave_slot(square->left - r->left, square->top - r->top);
    if (wave_square_is_whole(r, square) && !sums->hits && !film->samples)
        store_square(sums, slot, samples, square->left, square->top, film);
    else
        store_pixels(sums, r, square, slot, samples, film);
}
