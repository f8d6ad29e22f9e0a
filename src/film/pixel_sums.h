/* Sums samples into pixels, in double and in the order of the samples. */
#pragma once

#include "film/film.h"
#include "film/squares.h"

/* These kernels read a wave's sums with the same vector width that wrote them: a wide load stalls on data
 * that narrow stores have just written. */
typedef struct film_kernels {
    /* to[i] += from[i], for the 16 values of a square. */
    void (*add_samples)(const float *from, double *to);
    void (*add_sums)(const double *from, double *to);
    /* to[i] = from[i], then from[i] = 0. */
    void (*move_sums)(double *from, double *to);

    /* Writes the 4 × 4 sums of a square, times `scale`, to an image of this width. */
    void (*store_square)(const double *sums, double scale, size_t width, float *to);
} film_kernels;

const film_kernels *film_kernels_best(void);

/* Sums that only AOVs need. */
typedef struct hit_sums {
    double n[3][WAVE_SLOTS], albedo[3][WAVE_SLOTS], alpha[WAVE_SLOTS];
    double nearest[WAVE_SLOTS]; /* squared distance from the pixel's centre to the sample kept in `centre` */
    first_hits centre;
} hit_sums;

/* The sums of a wave's pixels, by slot. */
typedef struct pixel_sums {
    uint32_t groups; /* 1 or SAMPLE_GROUPS */
    bool equal;      /* the sums are scaled as if all groups had the same number of samples */
    double rgb[SAMPLE_GROUPS][3][WAVE_SLOTS]; /* only the first `groups` are used */
    hit_sums *hits;                           /* NULL: no AOV needs them */
    double (*layers)[WAVE_SLOTS];             /* three for each of film_part_sums(); NULL: there are none */
    matte_list (*mattes)[WAVE_SLOTS];         /* for each matte; NULL: there are none */
    film_parts parts;
    sampler sampler; /* the one that made the samples */
    const film_kernels *kernels;
} pixel_sums;

bool pixel_sums_create(const sampler *from, uint32_t groups, film_parts parts, pixel_sums *out);
void pixel_sums_destroy(pixel_sums *sums);
void pixel_sums_clear(pixel_sums *sums);
void hit_sums_clear(hit_sums *hits);

/* Adds the samples of the square at `place` of a batch, and their first hits if AOVs need them. The sums are
 * for the wave of the region. */
void pixel_sums_add(pixel_sums *sums, const wave_samples *samples, const wave_region *region,
                    const wave_batch *batch, uint32_t place);
/* Adds the mattes only. */
void matte_sums_add(matte_list (*mattes)[WAVE_SLOTS], const wave_samples *samples, film_parts parts,
                    const wave_region *region, const wave_batch *batch, uint32_t place);
/* Adds the first hits only. */
void hit_sums_add(hit_sums *hits, const sampler *from, const first_hits *first, const wave_region *region,
                  const wave_batch *batch, uint32_t place);

/* The number of samples in the sums of a square's pixels. */
typedef struct sums_count {
    uint32_t samples, hits;
} sums_count;

/* Stores the means of a square's pixels in the film, clipped to the region. */
void pixel_sums_store_square(const pixel_sums *sums, const wave_region *region, const wave_square *square,
                             sums_count count, fathom_film *film);

/* squared: the squared standard error of a pixel's mean R, G and B, from the differences between the means of
 * its groups: unbiased, with 3 degrees of freedom; infinite unless every group has a sample. Returns the mean
 * of the three means. */
double pixel_sums_error(const pixel_sums *sums, uint32_t slot, uint32_t samples, double squared[3]);

static inline wave_grid film_waves(const fathom_film *film) {
    return wave_grid_of(film->x, film->y, film->x + film->width, film->y + film->height);
}
