#include "render/pixel_sums.h"

#include <stdlib.h>
#include <string.h>

bool pixel_sums_create(const render_plan *plan, pixel_sums *out) {
    const bool wanted = plan->parts & FATHOM_PART_HITS;
    out->hits = wanted ? malloc(sizeof *out->hits) : NULL;
    return out->hits || !wanted;
}

void pixel_sums_destroy(pixel_sums *sums) {
    free(sums->hits);
    sums->hits = NULL;
}

void pixel_sums_clear(pixel_sums *sums) {
    memset(sums->rgb, 0, sizeof sums->rgb);
    if (sums->hits) memset(sums->hits, 0, sizeof *sums->hits);
}

static double distance_to_centre(const render_plan *plan, uint32_t x, uint32_t y, uint32_t index) {
    double dx, dy;
    wave_sample_position(plan, x, y, index, &dx, &dy);
    return (dx - 0.5) * (dx - 0.5) + (dy - 0.5) * (dy - 0.5);
}

static void keep_centre(hit_sums *sums, const first_hits *f, uint32_t from, uint32_t slot) {
    sums->centre.z[slot] = f->z[from];
    for (int c = 0; c < 3; ++c) sums->centre.p[c][slot] = f->p[c][from];
    sums->centre.object[slot] = f->object[from];
    sums->centre.primitive[slot] = f->primitive[from];
    sums->centre.instance[slot] = f->instance[from];
}

void pixel_sums_add_hit(pixel_sums *sums, const wave *w, uint32_t from, uint32_t x, uint32_t y, uint32_t slot,
                        uint32_t index) {
    const first_hits *f = w->first;
    hit_sums *hits = sums->hits;
    hits->alpha[slot] += (double)f->alpha[from];
    for (int c = 0; c < 3; ++c) {
        hits->n[c][slot] += (double)f->n[c][from];
        hits->albedo[c][slot] += (double)f->albedo[c][from];
    }
    double distance = distance_to_centre(w->plan, x, y, index);
    if (index && distance >= hits->nearest[slot]) return;
    hits->nearest[slot] = distance;
    keep_centre(hits, f, from, slot);
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

static void store_square(const render_plan *plan, const pixel_sums *sums, uint32_t slot, uint32_t samples,
                         uint32_t x, uint32_t y, fathom_film *film) {
    size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
    for (int c = 0; c < 3; ++c)
        plan->blocks->store_square(sums->rgb[c] + slot, 1.0 / samples, film->width, film->rgb[c] + pixel);
}

/* The part of a square that lies in the region. */
static void store_pixels(const pixel_sums *sums, const wave_region *r, uint32_t samples, uint32_t left,
                         uint32_t top, fathom_film *film) {
    for (uint32_t k = 0; k < LANES; ++k) {
        uint32_t x = left + k % 4, y = top + k / 4;
        bool inside = x >= r->x0 && x < r->x1 && y >= r->y0 && y < r->y1;
        if (inside) pixel_sums_store(sums, wave_slot(x - r->left, y - r->top), samples, x, y, film);
    }
}

void pixel_sums_store_all(const render_plan *plan, const pixel_sums *sums, const wave_region *r,
                          uint32_t samples, fathom_film *film) {
    bool colors_alone = !sums->hits && !film->samples;
    for (uint32_t y = r->top; y < r->y1; y += 4) {
        for (uint32_t x = r->left; x < r->x1; x += 4) {
            bool whole = x >= r->x0 && x + 4 <= r->x1 && y >= r->y0 && y + 4 <= r->y1;
            if (whole && colors_alone)
                store_square(plan, sums, wave_slot(x - r->left, y - r->top), samples, x, y, film);
            else
                store_pixels(sums, r, samples, x, y, film);
        }
    }
}
