#include "measure/coverage.h"

#include "film/film.h"

#include <math.h>

typedef struct work {
    fathom_context *context;
    const bench_stage *stage;
    const coverage_options *options;
    fathom_film *truth;
    unsigned done, total; /* numbers of renders */
} work;

static bool on_progress(void *user, const fathom_progress *progress) {
    const work *k = user;
    if (!k->options->progress) return true;
    return k->options->progress(k->options->user, (k->done + progress->fraction) / k->total);
}

static bool has_groups(const bench_stage *stage) {
    return stage->settings.integrator == FATHOM_INTEGRATOR_PATH;
}

/* The seeds of the images and of the reference are far apart. */
static fathom_status render(work *k, const coverage_row *row, uint64_t seed, fathom_film **out) {
    fathom_settings s = k->stage->settings;
    s.pattern = FATHOM_PATTERN_SOBOL, s.spp = row->spp, s.seed = seed;
    s.target_error = row->target, s.max_time = 0, s.min_spp = 0;
    s.aovs = has_groups(k->stage) || row->target > 0 ? FATHOM_AOV_ERROR : 0;
    fathom_status status = fathom_render(k->context, k->stage->scene, &s, on_progress, k, NULL, out);
    ++k->done;
    return status;
}

static double mean_of_film(const fathom_film *film) {
    const size_t pixels = (size_t)film->width * film->height;
    double sum = 0;
    for (int c = 0; c < 3; ++c)
        for (size_t i = 0; i < pixels; ++i) sum += (double)film->rgb[c][i];
    return sum / (3.0 * (double)pixels);
}

/* The variance of the mean of a film. Its pixels are independent; the three channels of a pixel are not. */
static double variance_of_film(const fathom_film *film) {
    const size_t pixels = (size_t)film->width * film->height;
    double sum = 0;
    for (size_t i = 0; i < pixels && film->doubt; ++i) {
        double error = 0;
        for (int c = 0; c < 3; ++c) error += (double)film->error[c][i] / 3;
        sum += film->doubt[i] < 1 ? error * error : 0;
    }
    return sum / ((double)pixels * (double)pixels);
}

static bool is_alike(const fathom_film *film, size_t i) {
    return film->doubt[i] >= 1 || !(film->error[0][i] + film->error[1][i] + film->error[2][i] > 0);
}

static void count_pixel(const fathom_film *film, const fathom_film *truth, size_t i, coverage_row *row) {
    coverage_count *to = is_alike(film, i)                ? &row->alike
                         : film->doubt[i] > FILM_DOUBTFUL ? &row->doubtful
                                                          : &row->trusted;
    for (int c = 0; c < 3; ++c) {
        const double off = fabs((double)film->rgb[c][i] - (double)truth->rgb[c][i]);
        /* Means of different numbers of equal samples can differ by rounding errors. */
        const double rounding = 0x1p-22 * fabs((double)truth->rgb[c][i]);
        ++to->values;
        to->held += off <= FILM_ERROR_T * (double)film->error[c][i] + rounding;
    }
}

static fathom_status measure_row(work *k, coverage_row *row) {
    double sum = 0, squares = 0, samples = 0;
    const double truth = mean_of_film(k->truth);
    for (uint32_t n = 0; n < k->options->seeds; ++n) {
        fathom_film *film;
        fathom_status status = render(k, row, k->options->seed + n, &film);
        if (status != FATHOM_OK) {
            fathom_film_destroy(film);
            return status;
        }
        const size_t pixels = (size_t)film->width * film->height;
        const double d = mean_of_film(film) - truth;
        sum += d, squares += d * d;
        samples += (double)film->stats.samples / (double)pixels;
        for (size_t i = 0; i < pixels; ++i) count_pixel(film, k->truth, i, row);
        fathom_film_destroy(film);
    }
    const double count = row->seeds = k->options->seeds, mean = sum / count;
    const double variance = (squares - sum * mean) / (count * (count - 1));
    row->light = 1 + mean / truth;
    row->mean_spp = samples / count;
    row->t = mean / sqrt(variance + variance_of_film(k->truth));
    return FATHOM_OK;
}

fathom_status coverage_measure(fathom_context *context, const bench_stage *stage,
                               const coverage_options *options, coverage_row out[COVERAGE_ROWS],
                               unsigned *count) {
    const uint32_t most = options->max_spp;
    const coverage_row rows[COVERAGE_ROWS] = {
        {.spp = 16}, {.spp = 64}, {.target = 0.1, .spp = most}, {.target = 0.05, .spp = most}};
    const unsigned first = has_groups(stage) ? 0 : 2;
    work k = {.context = context, .stage = stage, .options = options};
    k.total = 1 + (COVERAGE_ROWS - first) * options->seeds;
    *count = 0;
    const coverage_row reference = {.spp = options->reference_spp};
    fathom_status status = render(&k, &reference, options->seed + (1ull << 62), &k.truth);
    for (unsigned i = first; i < COVERAGE_ROWS && status == FATHOM_OK; ++i) {
        out[*count] = rows[i];
        status = measure_row(&k, &out[*count]);
        if (status == FATHOM_OK) ++*count;
    }
    fathom_film_destroy(k.truth);
    return status;
}
