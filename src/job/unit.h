/* A unit of work, squares of one wave with all their samples; its result, and the sinks that take it. */
#ifndef JOB_UNIT_H
#define JOB_UNIT_H

#include "film/pixel_sums.h"

typedef struct work_unit {
    uint32_t wave, reserved; /* the first: of the film's grid */
    uint64_t squares;        /* bit y / 4 * 8 + x / 4 */
} work_unit;

/* Squares that fill a batch where each pixel gets so many samples, and so the fewest of a unit. */
static inline uint32_t unit_least_squares(uint32_t samples) {
    return samples < WAVE_SQUARES ? WAVE_SQUARES / samples : 1;
}

typedef struct unit_result {
    wave_region region;      /* the wave, as far as the film shows it */
    uint64_t squares;        /* those that are done */
    const pixel_sums *sums;  /* of the wave's pixels */
    const uint32_t *samples; /* [WAVE_SQUARES], of each pixel of a square */
    const uint32_t *hits;    /* likewise: first hits, for the AOVs */
    double error;            /* of the wave; 0: not estimated */
} unit_result;

/* Groups of the samples of a pixel when all pixels have the same number. Classic images keep one:
 * its samples are stratified better, and hardly anything but edges is random in them. */
uint32_t unit_groups(const fathom_settings *settings);

/* Pixels of the squares that the film shows, and samples of these. */
uint64_t unit_pixels(const unit_result *r);
uint64_t unit_samples(const unit_result *r);

/* Takes results from any thread, those of one square from one thread. */
typedef struct unit_sink {
    void (*take)(void *user, const unit_result *result);
    void *user;
} unit_sink;

/* The means of the samples become the film's pixels. */
unit_sink unit_film_sink(fathom_film *film);

#endif
