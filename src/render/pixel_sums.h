/* Samples summed into pixels, in double and in the order of the samples. */
#ifndef RENDER_PIXEL_SUMS_H
#define RENDER_PIXEL_SUMS_H

#include "render/film.h"
#include "render/wave.h"

/* What only AOVs need. */
typedef struct hit_sums {
    double n[3][WAVE_SLOTS], albedo[3][WAVE_SLOTS], alpha[WAVE_SLOTS];
    double nearest[WAVE_SLOTS]; /* squared distance to the pixel's centre of the sample kept in `centre` */
    first_hits centre;
} hit_sums;

/* Of a wave's pixels, by slot. */
typedef struct pixel_sums {
    double rgb[3][WAVE_SLOTS];
    hit_sums *hits; /* NULL: no AOV wants them */
} pixel_sums;

bool pixel_sums_create(const render_plan *plan, pixel_sums *out);
void pixel_sums_destroy(pixel_sums *sums);
void pixel_sums_clear(pixel_sums *sums);

/* The first hit of sample `index` of pixel (x, y), from its slot in the wave to its slot in the sums. Needs
 * hits. */
void pixel_sums_add_hit(pixel_sums *sums, const wave *w, uint32_t from, uint32_t x, uint32_t y, uint32_t slot,
                        uint32_t index);

/* The means of `samples` samples of all pixels of a region to the film. */
void pixel_sums_store_all(const render_plan *plan, const pixel_sums *sums, const wave_region *region,
                          uint32_t samples, fathom_film *film);

/* The mean of `samples` samples to a pixel of the film, (x, y) in the image. */
void pixel_sums_store(const pixel_sums *sums, uint32_t slot, uint32_t samples, uint32_t x, uint32_t y,
                      fathom_film *film);

#endif
