/* A blurred image against the mean of still ones, of 32 x 32 pixels. */
#pragma once

#include "render.h"
#include "verify/laws/laws.h"

enum { PIXELS = 32 * 32, STILLS = SANITIZED ? 8 : 64, SEEDS = 8 };

/* A scene whose shutter opens and closes at these times. */
typedef stage (*stage_fn)(double open, double close);

static inline void add_render(stage *s, double sums[PIXELS], double weight) {
    fathom_film *film = stage_render(s);
    const float *green = fathom_film_channel(film, "G");
    for (int i = 0; i < PIXELS; ++i) sums[i] += weight * (double)green[i];
}

/* Cells of 8 × 8 pixels. The stills lie in the middles of 64 times: a step of an edge, 1/64 of its way, is
 * far below the errors. Welch's t of each cell from 8 renders; one false alarm in 1e5. */
static inline void assert_mean_of_stills(stage_fn make, double open, double close) {
    sample_mean blurred[16], still[16];
    double sums[2][16] = {{0}}, squares[2][16] = {{0}};
    for (uint64_t seed = 0; seed < SEEDS; ++seed) {
        double image[2][PIXELS] = {{0}};
        stage s = make(open, close);
        s.settings.spp = 128, s.settings.seed = seed;
        add_render(&s, image[0], 1);
        for (int k = 0; k < STILLS; ++k) {
            const double time = open + (close - open) * (k + 0.5) / STILLS;
            s = make(time, time);
            s.settings.spp = 2, s.settings.seed = 1000 + seed * STILLS + (uint64_t)k;
            add_render(&s, image[1], 1.0 / STILLS);
        }
        for (int k = 0; k < 2; ++k) {
            double cells[16] = {0};
            for (int i = 0; i < PIXELS; ++i) cells[i / 256 * 4 + i % 32 / 8] += image[k][i] / 64;
            for (int c = 0; c < 16; ++c) sums[k][c] += cells[c], squares[k][c] += cells[c] * cells[c];
        }
    }
    double least = 1;
    for (int c = 0; c < 16; ++c) {
        for (int k = 0; k < 2; ++k) {
            const double mean = sums[k][c] / SEEDS, variance = fmax(squares[k][c] / SEEDS - mean * mean, 0);
            (k ? still : blurred)[c] = (sample_mean){mean, sqrt(variance / (SEEDS - 1)), SEEDS - 1};
        }
        least = fmin(least, welch_p(blurred[c], still[c], 0, 1e-4 * still[c].mean));
    }
    if (sidak(least, 16) < 1e-5) fail_msg("p %g", sidak(least, 16));
}
