/* The integrators that the laws judge. */
#include "base/status.h"
#include "integrate/reference.h"
#include "verify/laws/laws.h"

#include <fathom/render.h>
#include <stdlib.h>

/* ---- the reference ---- */

enum { SIDE = 16, PIXELS = SIDE * SIDE };

static fathom_status reference_room(void *user, const law_room *room, uint64_t samples, uint64_t seed,
                                    sample_mean out[3]) {
    const reference_settings settings = {.width = SIDE,
                                         .height = SIDE,
                                         .region = {0, 0, SIDE, SIDE},
                                         .samples = (uint32_t)fmax((double)samples / PIXELS, 2),
                                         .depth = room->depth,
                                         .seed = seed,
                                         .threads = *(const unsigned *)user,
                                         .environment = room->environment};
    reference_estimate *pixels = malloc(PIXELS * sizeof *pixels);
    if (!pixels) return fail_memory(room->context, PIXELS * sizeof *pixels);
    const fathom_status status = reference_render(room->scene, &settings, pixels);
    for (int c = 0; c < 3 && status == FATHOM_OK; ++c) {
        double mean = 0, square = 0;
        for (int i = 0; i < PIXELS; ++i)
            mean += pixels[i].mean[c] / PIXELS, square += pixels[i].error[c] * pixels[i].error[c];
        out[c] = (sample_mean){mean, sqrt(square) / PIXELS, PIXELS * (settings.samples - 1.0)};
    }
    free(pixels);
    return status;
}

laws_render laws_reference(unsigned *threads) { return (laws_render){"reference", reference_room, threads}; }

/* ---- the path integrator ---- */

/* Samples of a low-discrepancy sequence depend on each other: only whole renders with seeds of their own tell
 * the error. The image has a tile for each of four threads. */
enum { WIDTH = 64, SEEDS = 16 };

static void add_means(const fathom_film *film, double sums[3], double squares[3]) {
    static const char *const names[3] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        const float *channel = fathom_film_channel(film, names[c]);
        double mean = 0;
        for (int i = 0; i < WIDTH * WIDTH; ++i) mean += (double)channel[i] / (WIDTH * WIDTH);
        sums[c] += mean, squares[c] += mean * mean;
    }
}

static fathom_status path_room(void *user, const law_room *room, uint64_t samples, uint64_t seed,
                               sample_mean out[3]) {
    (void)user;
    fathom_settings settings;
    fathom_settings_default(&settings);
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_PATH);
    settings.width = settings.height = WIDTH;
    settings.target_error = 0, settings.min_weight = 0, settings.max_depth = room->depth;
    settings.spp = (uint32_t)fmin(fmax(ceil((double)samples / (SEEDS * WIDTH * WIDTH)), 1), 65536);
    if (room->environment)
        return fail(room->context, FATHOM_BAD_INPUT,
                    "the path integrator takes radiance from outside as images alone");
    double sums[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
    for (unsigned i = 0; i < SEEDS; ++i) {
        fathom_film *film;
        settings.seed = seed * SEEDS + i;
        const fathom_status status =
            fathom_render(room->context, room->scene, &settings, NULL, NULL, NULL, &film);
        if (status != FATHOM_OK) return status;
        add_means(film, sums, squares);
        fathom_film_destroy(film);
    }
    for (int c = 0; c < 3; ++c) {
        const double mean = sums[c] / SEEDS, variance = fmax(squares[c] / SEEDS - mean * mean, 0);
        out[c] = (sample_mean){mean, sqrt(variance / (SEEDS - 1)), SEEDS - 1};
    }
    return FATHOM_OK;
}

laws_render laws_path(void) { return (laws_render){"path", path_room, NULL}; }
