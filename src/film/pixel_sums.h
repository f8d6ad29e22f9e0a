/* Samples summed into pixels, in double and in the order of the samples. */
#ifndef FILM_PIXEL_SUMS_H
#define FILM_PIXEL_SUMS_H

#include "film/film.h"
#include "film/squares.h"

/* A wave's sums are read as wide as they were written, by these: a wide load of what narrow stores have just
 * written waits for them. */
typedef struct film_kernels {
    /* A square's: to[i] += from[i]. */
    void (*add_samples)(const float *from, double *to);
    void (*add_sums)(const double *from, double *to);
    /* to[i] = from[i], which becomes 0. */
    void (*move_sums)(double *from, double *to);

    /* A square of 4 × 4 sums, scaled, to an image of this width. */
    void (*store_square)(const double *sums, double scale, size_t width, float *to);
} film_kernels;

const film_kernels *film_kernels_best(void);
/* Those that this processor can run, from the plainest to the best; NULL past the last. */
const film_kernels *film_kernels_at(unsigned index);

/* Sums that only AOVs need. */
typedef struct hit_sums {
    double n[3][WAVE_SLOTS], albedo[3][WAVE_SLOTS], alpha[WAVE_SLOTS];
    double nearest[WAVE_SLOTS]; /* squared distance to the pixel's centre of the sample kept in `centre` */
    first_hits centre;
} hit_sums;

/* The sums of a wave's pixels, by slot. */
typedef struct pixel_sums {
    uint32_t groups;                          /* 1 or SAMPLE_GROUPS */
    bool equal;                               /* scaled so that all groups have the same number of samples */
    double rgb[SAMPLE_GROUPS][3][WAVE_SLOTS]; /* of the groups that there are */
    hit_sums *hits;                           /* NULL: no AOV wants them */
    double (*layers)[WAVE_SLOTS];             /* three of each of film_part_sums(); NULL: there are none */
    matte_list (*mattes)[WAVE_SLOTS];         /* of each matte; NULL likewise */
    film_parts parts;
    sampler sampler; /* which made the samples */
    const film_kernels *kernels;
} pixel_sums;

bool pixel_sums_create(const sampler *from, uint32_t groups, film_parts parts, pixel_sums *out);
void pixel_sums_destroy(pixel_sums *sums);
void pixel_sums_clear(pixel_sums *sums);
void hit_sums_clear(hit_sums *hits);

/* The samples of the square at `place` of a batch, and their first hits where AOVs want them. The sums are of
 * the region's wave. */
void pixel_sums_add(pixel_sums *sums, const wave_samples *samples, const wave_region *region,
                    const wave_batch *batch, uint32_t place);
/* The mattes alone. */
void matte_sums_add(matte_list (*mattes)[WAVE_SLOTS], const wave_samples *samples, film_parts parts,
                    const wave_region *region, const wave_batch *batch, uint32_t place);
/* The first hits alone. */
void hit_sums_add(hit_sums *hits, const sampler *from, const first_hits *first, const wave_region *region,
                  const wave_batch *batch, uint32_t place);

/* How many samples the sums of a square's pixels are of. */
typedef struct sums_count {
    uint32_t samples, hits;
} sums_count;

/* The means of the pixels of a square to the film, as far as they lie in the region. */
void pixel_sums_store_square(const pixel_sums *sums, const wave_region *region, const wave_square *square,
                             sums_count count, fathom_film *film);

/* The squared standard error of a pixel's mean of R, G and B, by the differences between the means of its
 * groups: unbiased, with 3 degrees of freedom. Returns the mean's grey. Infinite below a sample of each
 * group. */
double pixel_sums_error(const pixel_sums *sums, uint32_t slot, uint32_t samples, double squared[3]);

static inline wave_grid film_waves(const fathom_film *film) {
    return wave_grid_of(film->x, film->y, film->x + film->width, film->y + film->height);
}

#endif
