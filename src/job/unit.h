/* The result of a unit of work, squares of one wave with all their samples, and the sinks that take it. */
#ifndef JOB_UNIT_H
#define JOB_UNIT_H

#include "film/pixel_sums.h"

typedef struct unit_result {
    wave_region region;      /* the wave, as far as the film shows it */
    uint64_t squares;        /* those that are done: bit y / 4 * 8 + x / 4 */
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

/* Takes results from any thread, those of one wave from one thread at a time. */
typedef struct unit_sink {
    void (*take)(void *user, const unit_result *result);
    void *user;
} unit_sink;

/* The means of the samples become the film's pixels. */
unit_sink unit_film_sink(fathom_film *film);

#endif
