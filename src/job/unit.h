/* A unit of work: squares of one wave with all their samples. Also its result, and the sinks that receive
 * it. */
#pragma once

#include "film/pixel_sums.h"

typedef struct work_unit {
    uint32_t wave, reserved; /* wave: index in the film's grid */
    uint64_t squares;        /* bit y / 4 * 8 + x / 4 */
} work_unit;

/* Number of squares that fill a batch when each pixel gets this many samples. This is the minimum for a
 * unit. */
static inline uint32_t unit_least_squares(uint32_t samples) {
    return samples < WAVE_SQUARES ? WAVE_SQUARES / samples : 1;
}

typedef struct unit_result {
    wave_region region;      /* the wave, clipped to the film */
    uint64_t squares;        /* the finished ones */
    const pixel_sums *sums;  /* of the wave's pixels */
    const uint32_t *samples; /* [WAVE_SQUARES], of each pixel of a square */
    const uint32_t *hits;    /* likewise: number of first hits, for the AOVs */
    double error;            /* of the wave; 0: not estimated */
} unit_result;

/* Number of sample groups of a pixel if all pixels have the same number of samples. Only errors need several:
 * the samples of one group are stratified better (bench/path_tracing.md). */
uint32_t unit_groups(const fathom_settings *settings);

/* Number of pixels of the squares inside the film, and number of samples of these pixels. */
uint64_t unit_pixels(const unit_result *r);
uint64_t unit_samples(const unit_result *r);

/* Receives results from any thread; all results of one square come from one thread. */
typedef struct unit_sink {
    void (*take)(void *user, const unit_result *result);
    void *user;
} unit_sink;

/* Stores the means of the samples as the film's pixels. */
unit_sink unit_film_sink(fathom_film *film);
