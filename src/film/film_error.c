/* The error channels of a film.
 *
 * A pixel's own groups of samples tell its variance v with FILM_OWN degrees of freedom. Where light comes
 * from few bright samples, that is often far too small: the pixel has met none of them yet. Its neighbours
 * may have. So the stated variance is (a v + b m) / (a + b), with m the mean over the square of 4 × 4 pixels
 * (Smyth, "Linear models and empirical Bayes methods", 2004: moderated t), a = FILM_OWN, b = FILM_NEAR. Over
 * a square its mean is that of v: unbiased. Measured at 16 samples a pixel, intervals by v hold the truth in
 * 91 % of pixels, and moderated ones in 95.5 % (bench/README.md, Rendering to an error). At the edge of a
 * crop, m is of the pixels inside.
 *
 * Doubt. Neighbours do not help where even they have met nothing. Then the variance of a whole wave hangs on
 * few of its pixels. (sum of v)² / sum of v² is how many pixels carry it: n, where n have the same v and the
 * others none. The doubt of a wave is 1 - that over its pixels. */
#include "film/film.h"
#include "film/pixel_sums.h"

#include <math.h>

double film_error_weight(double grey) {
    double norm = grey < 1 ? fmax(grey, 0.01) : grey * grey;
    return 1 / norm;
}

/* The error is a bound on what was never seen, or unknown. */
static bool is_bound(const fathom_film *film, size_t pixel) { return film->doubt[pixel] >= 1; }

static bool is_known(const fathom_film *film, size_t pixel) { return isfinite(film->error[0][pixel]); }

static double variance(const fathom_film *film, int c, size_t pixel) {
    const double error = (double)film->error[c][pixel];
    return is_bound(film, pixel) ? 0 : error * error;
}

/* ---- what pixels may take from their neighbours ---- */

typedef struct pixel_list {
    size_t items[LANES];
    uint32_t count;
} pixel_list;

/* The pixels of a square whose errors are known. */
static pixel_list known_pixels(const fathom_film *film, const wave_region *r, const wave_square *square) {
    pixel_list list = {.count = 0};
    for (uint32_t left = wave_square_pixels(r, square); left; left &= left - 1) {
        const uint32_t k = (uint32_t)__builtin_ctz(left), x = square->left + k % 4, y = square->top + k / 4;
        const size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
        if (is_known(film, pixel)) list.items[list.count++] = pixel;
    }
    return list;
}

static bool all_are_bounds(const fathom_film *film, const pixel_list *square) {
    bool all = true;
    for (uint32_t i = 0; i < square->count; ++i) all = all && is_bound(film, square->items[i]);
    return all;
}

static void moderate(fathom_film *film, const pixel_list *square, double doubt) {
    double mean[3] = {0};
    for (int c = 0; c < 3; ++c) {
        for (uint32_t i = 0; i < square->count; ++i)
            mean[c] += variance(film, c, square->items[i]) / square->count;
    }
    for (uint32_t i = 0; i < square->count; ++i) {
        const size_t pixel = square->items[i];
        for (int c = 0; c < 3; ++c) {
            const double sum = FILM_OWN * variance(film, c, pixel) + FILM_NEAR * mean[c];
            film->error[c][pixel] = (float)sqrt(sum / (FILM_OWN + FILM_NEAR));
        }
        film->doubt[pixel] = (float)doubt;
    }
}

/* ---- waves ---- */

typedef struct wave_sums {
    double sum, squares, pixels;
} wave_sums;

static void add_variances(const fathom_film *film, const pixel_list *square, wave_sums *to) {
    for (uint32_t i = 0; i < square->count; ++i) {
        double v = 0;
        for (int c = 0; c < 3; ++c) v += variance(film, c, square->items[i]);
        to->sum += v, to->squares += v * v;
    }
    to->pixels += square->count;
}

static double doubt_of(const wave_sums *w) {
    const double carry = w->squares > 0 ? w->sum * w->sum / w->squares : w->pixels;
    return fmin(fmax(1 - carry / w->pixels, 0), 1 - 0x1p-20);
}

static void settle_wave(fathom_film *film, const wave_region *r) {
    wave_sums sums = {.sum = 0};
    wave_square squares[WAVE_SQUARES];
    pixel_list lists[WAVE_SQUARES];
    const uint32_t count = wave_list_squares(r, wave_region_bits(r), squares);
    for (uint32_t s = 0; s < count; ++s) {
        lists[s] = known_pixels(film, r, &squares[s]);
        if (all_are_bounds(film, &lists[s]))
            lists[s].count = 0;
        else
            add_variances(film, &lists[s], &sums);
    }
    for (uint32_t s = 0; s < count; ++s) moderate(film, &lists[s], doubt_of(&sums));
}

void film_settle_errors(fathom_film *film) {
    const wave_grid grid = film_waves(film);
    for (uint32_t i = 0; film->doubt && i < grid.count; ++i) {
        const wave_region r = wave_grid_region(&grid, i);
        settle_wave(film, &r);
    }
}

/* ---- the image's error ---- */

static double pixel_error(const fathom_film *film, size_t pixel) {
    double squares = 0, grey = 0;
    for (int c = 0; c < 3; ++c) {
        squares += variance(film, c, pixel) / 3;
        grey += (double)film->rgb[c][pixel] / 3;
    }
    return squares * film_error_weight(grey);
}

bool film_error_of(const fathom_film *film, film_error *out) {
    const size_t pixels = (size_t)film->width * film->height;
    double squares = 0, doubtful = 0, count = 0;
    *out = (film_error){.error = 0};
    for (size_t i = 0; film->doubt && i < pixels; ++i) {
        if (is_bound(film, i)) {
            for (int c = 0; c < 3; ++c)
                out->unseen = fmax(out->unseen, FILM_ERROR_T * (double)film->error[c][i]);
            continue;
        }
        squares += pixel_error(film, i);
        doubtful += film->doubt[i] > FILM_DOUBTFUL;
        ++count;
    }
    if (count > 0) out->error = sqrt(squares / count), out->doubtful = doubtful / count;
    return film->doubt && isfinite(out->error) && isfinite(out->unseen);
}
