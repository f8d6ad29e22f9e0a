/* The integrators that the laws test. */
#include "base/status.h"
#include "integrate/reference/reference.h"
#include "verify/laws/laws.h"

#include <fathom/render.h>
#include <stdlib.h>

/* ---- the reference ---- */

enum { CELL = 8 };

/* Mean and error of a cell of an image `width` pixels wide. Pixels are independent, so the squares of their
 * errors add up. */
static sample_mean mean_of(const reference_estimate *pixels, uint32_t width, int channel, uint32_t samples) {
    const uint32_t count = CELL * CELL;
    double mean = 0, square = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const reference_estimate *p = &pixels[i / CELL * width + i % CELL];
        mean += p->mean[channel] / count;
        square += p->error[channel] * p->error[channel];
    }
    return (sample_mean){mean, sqrt(square) / count, count * (samples - 1.0)};
}

static fathom_status reference_cells(const fathom_scene *scene, const laws_pair *o, sample_mean *out) {
    const uint32_t width = o->across * CELL, height = o->down * CELL;
    const reference_settings settings = {.width = width,
                                         .height = height,
                                         .samples = (uint32_t)fmax((double)o->samples / width / height, 2),
                                         .depth = o->depth,
                                         .seed = o->seed,
                                         .threads = o->threads,
                                         .terminator_fix = true};
    reference_estimate *pixels = malloc((size_t)width * height * sizeof *pixels);
    fathom_status status = pixels ? reference_render(scene, &settings, pixels)
                                  : fail_memory(scene->context, (size_t)width * height * sizeof *pixels);
    for (uint32_t i = 0; i < 3 * o->across * o->down && status == FATHOM_OK; ++i) {
        const reference_estimate *corner =
            pixels + i / 3 / o->across * CELL * width + i / 3 % o->across * CELL;
        out[i] = mean_of(corner, width, (int)(i % 3), settings.samples);
    }
    free(pixels);
    return status;
}

/* ---- the path integrator ---- */

/* Samples of a low-discrepancy sequence are not independent, so the error comes from whole renders with
 * different seeds. */
enum { SEEDS = 16 };

/* Sums over all seeds of the means of a grid's cells, three channels each, and of their squares. */
typedef struct cells {
    uint32_t across, count;
    double *sums, *squares; /* three per cell; the caller zeroes them */
} cells;

static void add_film(const fathom_film *film, uint32_t side, const cells *k) {
    static const char *const names[3] = {"R", "G", "B"};
    const uint32_t width = k->across * side;
    for (uint32_t i = 0; i < 3 * k->count; ++i) {
        const float *channel = fathom_film_channel(film, names[i % 3]);
        const uint32_t x = i / 3 % k->across * side, y = i / 3 / k->across * side;
        double mean = 0;
        for (uint32_t p = 0; p < side * side; ++p)
            mean += (double)channel[(y + p / side) * width + x + p % side] / (side * side);
        k->sums[i] += mean, k->squares[i] += mean * mean;
    }
}

static fathom_status path_cells(fathom_context *context, const fathom_scene *scene, fathom_settings settings,
                                uint32_t side, const cells *k, sample_mean *out) {
    const uint64_t seed = settings.seed * SEEDS;
    for (unsigned i = 0; i < SEEDS; ++i) {
        fathom_film *film;
        settings.seed = seed + i;
        const fathom_status status = fathom_render(context, scene, &settings, NULL, NULL, NULL, &film);
        if (status != FATHOM_OK) return status;
        add_film(film, side, k);
        fathom_film_destroy(film);
    }
    for (uint32_t i = 0; i < 3 * k->count; ++i) {
        const double mean = k->sums[i] / SEEDS, variance = fmax(k->squares[i] / SEEDS - mean * mean, 0);
        out[i] = (sample_mean){mean, sqrt(variance / (SEEDS - 1)), SEEDS - 1};
    }
    return FATHOM_OK;
}

static fathom_settings path_settings(uint32_t width, uint32_t height, uint32_t depth, uint64_t samples,
                                     uint64_t seed) {
    fathom_settings s;
    const double pixels = (double)width * height;
    fathom_settings_default(&s);
    fathom_settings_set_integrator(&s, FATHOM_INTEGRATOR_PATH);
    s.width = width, s.height = height, s.max_depth = depth, s.seed = seed;
    s.target_error = 0, s.min_weight = 0;
    s.spp = (uint32_t)fmin(fmax(ceil((double)samples / (SEEDS * pixels)), 1), 65536);
    return s;
}

fathom_status laws_path(const law_room *room, uint64_t samples, uint64_t seed, sample_mean out[3]) {
    enum { WIDTH = 64 }; /* four tiles */
    double sums[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
    const cells whole = {1, 1, sums, squares};
    return path_cells(room->b.context, room->b.scene, path_settings(WIDTH, WIDTH, room->depth, samples, seed),
                      WIDTH, &whole, out);
}

/* ---- both integrators on one scene ---- */

fathom_status laws_pair_run(fathom_context *context, const fathom_scene *scene, const laws_pair *o,
                            laws_difference *out) {
    const uint32_t count = 3 * o->across * o->down;
    const fathom_settings settings =
        path_settings(o->across * CELL, o->down * CELL, o->depth, o->samples, o->seed);
    double *sums = calloc(2 * (size_t)count, sizeof *sums);
    sample_mean *means = calloc(2 * (size_t)count, sizeof *means);
    fathom_status status = sums && means ? FATHOM_OK : fail_memory(context, 2 * count * sizeof *means);
    if (status == FATHOM_OK) status = reference_cells(scene, o, means);
    if (status == FATHOM_OK) {
        const cells k = {o->across, o->across * o->down, sums, sums + count};
        status = path_cells(context, scene, settings, CELL, &k, means + count);
    }
    if (status == FATHOM_OK) *out = laws_compare(means + count, means, count, o->allowance);
    free(sums);
    free(means);
    return status;
}
