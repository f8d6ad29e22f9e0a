/* The error channels of a film.
 *
 * The groups of samples of a pixel give an estimate v of its variance, with 3 degrees of freedom. If light
 * comes from few bright samples, v is often far too small, because the pixel has no such sample yet. Its
 * neighbours may have one. So the stated variance is w v + (1 - w) m, with m the mean of v over 12 × 12
 * pixels: the pixel's square of 4 × 4 and the eight squares around it. This is the linear estimate of minimum
 * squared error (Bühlmann, "Experience rating and credibility", 1967). The weight w is the fraction of the
 * differences between the v of these pixels that comes from real differences of the pixels, and not from
 * noise:
 *
 *     w = (mean of s - q) / (mean of v² - q), clamped to [0, 1]
 *
 * q is the mean of v v' over all pairs of two different pixels; it estimates the squared mean of their
 * variances. s of a pixel is the mean of the products of two estimates of its variance that have no group
 * in common (squared_variance() in pixel_sums.c); the mean of s estimates the mean of the squared
 * variances. Both are unbiased for any distribution of the samples. So w tells apart rare bright samples,
 * which make v noisy, and edges, where the pixels really differ. One weight serves R, G and B: each of the
 * three terms is a sum over the channels. At the border of a crop, m is over the pixels inside it. Squares
 * in which each pixel's samples are all equal are not counted; their pixels keep their bounds.
 *
 * Doubt. An interval fails most often in two cases (bench/README.md, Errors of pixels). (1) The pixel has a
 * bright sample and few neighbours have one: then its own v is several times the stated variance. (2) w is
 * near 1: then the neighbours add no information, and v alone is too uncertain. The doubt is the larger of w
 * and 1 - exp(-v / stated variance), which is above FILM_DOUBTFUL from a ratio of 3.9 on.
 *
 * The image. Its error is a sum over pixels, and uses v before this step. The reason: the weight of a pixel
 * in the sum depends on its brightness. If a lamp's edge shared its variance with a black pixel next to it,
 * this variance would count a thousand times. */
#include "film/film.h"

#include <math.h>

double film_error_weight(double grey) {
    double norm = grey < 1 ? fmax(grey, 0.01) : grey * grey;
    return 1 / norm;
}

/* The error is an upper bound on unseen light, or is unknown. */
static bool is_bound(const fathom_film *film, size_t pixel) { return film->doubt[pixel] >= 1; }

static double error_of(const fathom_film *film, int c, size_t pixel) { return (double)film->error[c][pixel]; }

static bool is_known(const fathom_film *film, size_t pixel) {
    return isfinite(error_of(film, 0, pixel) + error_of(film, 1, pixel) + error_of(film, 2, pixel));
}

static double variance(const fathom_film *film, int c, size_t pixel) {
    const double error = error_of(film, c, pixel);
    return is_bound(film, pixel) ? 0 : error * error;
}

/* True if all samples of the pixel are equal. */
static bool is_alike(const fathom_film *film, size_t pixel) {
    return !(variance(film, 0, pixel) + variance(film, 1, pixel) + variance(film, 2, pixel) > 0);
}

/* ---- squares ---- */

/* Sums over pixels: their number; v and v² for each channel; the products of two estimates over all
 * channels. */
struct error_sums {
    double pixels, sum[3], squares[3], products;
};

static uint32_t squares_between(uint32_t from, uint32_t to) { return (to + 3) / 4 - from / 4; }

static uint32_t squares_across(const fathom_film *film) {
    return squares_between(film->x, film->x + film->width);
}

size_t film_error_rows(const fathom_film *film) {
    return film->settings.aovs & FATHOM_AOV_ERROR
               ? 3 * (size_t)squares_across(film) * sizeof *film->error_rows
               : 0;
}

typedef struct pixel_list {
    size_t items[LANES];
    uint32_t count;
} pixel_list;

/* The pixels of a square inside the film whose errors are known. None if the samples of every pixel are
 * alike. */
static pixel_list list_pixels(const fathom_film *film, uint32_t column, uint32_t row) {
    const uint32_t left = (film->x / 4 + column) * 4, top = (film->y / 4 + row) * 4;
    pixel_list list = {.count = 0};
    bool alike = true;
    for (uint32_t y = max_u32(top, film->y); y < min_u32(top + 4, film->y + film->height); ++y) {
        for (uint32_t x = max_u32(left, film->x); x < min_u32(left + 4, film->x + film->width); ++x) {
            const size_t pixel = (size_t)(y - film->y) * film->width + (x - film->x);
            if (!is_known(film, pixel)) continue;
            list.items[list.count++] = pixel;
            alike = alike && is_alike(film, pixel);
        }
    }
    if (alike) list.count = 0;
    return list;
}

static void add_pixel(const fathom_film *film, size_t pixel, struct error_sums *to) {
    double squares = 0;
    for (int c = 0; c < 3; ++c) {
        const double v = variance(film, c, pixel);
        to->sum[c] += v, to->squares[c] += v * v, squares += v * v;
    }
    if (!is_bound(film, pixel)) to->products += FILM_ERROR_PRODUCTS * (double)film->doubt[pixel] * squares;
    to->pixels += 1;
}

static struct error_sums *sums_at(const fathom_film *film, uint32_t column, uint32_t row) {
    return film->error_rows + (size_t)(row % 3) * squares_across(film) + column;
}

static void sum_row(const fathom_film *film, uint32_t row) {
    for (uint32_t i = 0; i < squares_across(film); ++i) {
        const pixel_list pixels = list_pixels(film, i, row);
        struct error_sums sums = {.pixels = 0};
        for (uint32_t k = 0; k < pixels.count; ++k) add_pixel(film, pixels.items[k], &sums);
        *sums_at(film, i, row) = sums;
    }
}

/* The sums over the square and its neighbours. */
static struct error_sums sum_around(const fathom_film *film, uint32_t column, uint32_t row, uint32_t rows) {
    struct error_sums all = {.pixels = 0};
    for (uint32_t j = row ? row - 1 : 0; j <= row + 1 && j < rows; ++j) {
        for (uint32_t i = column ? column - 1 : 0; i <= column + 1 && i < squares_across(film); ++i) {
            const struct error_sums *one = sums_at(film, i, j);
            all.pixels += one->pixels, all.products += one->products;
            for (int c = 0; c < 3; ++c) all.sum[c] += one->sum[c], all.squares[c] += one->squares[c];
        }
    }
    return all;
}

/* The weight of a pixel's own variance. */
static double own_weight(const struct error_sums *s) {
    double of_pixels = s->products / s->pixels, of_all = 0;
    for (int c = 0; c < 3; ++c) {
        const double pairs = s->sum[c] * s->sum[c] - s->squares[c],
                     q = s->pixels > 1 ? fmax(pairs, 0) / (s->pixels * (s->pixels - 1)) : 0;
        of_pixels -= q, of_all += s->squares[c] / s->pixels - q;
    }
    return of_all > 0 ? fmin(fmax(of_pixels / of_all, 0), 1) : 0;
}

static void settle_pixel(fathom_film *film, size_t pixel, const struct error_sums *around, double weight) {
    double own = 0, stated = 0;
    float error[3];
    for (int c = 0; c < 3; ++c) {
        const double v = variance(film, c, pixel),
                     all = weight * v + (1 - weight) * around->sum[c] / around->pixels;
        own += v, stated += all, error[c] = (float)sqrt(all);
    }
    for (int c = 0; c < 3; ++c) film->error[c][pixel] = error[c];
    const double doubt = fmax(weight, stated > 0 ? 1 - exp(-own / stated) : 0);
    film->doubt[pixel] = (float)fmin(doubt, 1 - 0x1p-20);
}

static void settle_row(fathom_film *film, uint32_t row, uint32_t rows) {
    for (uint32_t i = 0; i < squares_across(film); ++i) {
        const pixel_list pixels = list_pixels(film, i, row);
        if (!pixels.count) continue;
        const struct error_sums around = sum_around(film, i, row, rows);
        const double weight = own_weight(&around);
        for (uint32_t k = 0; k < pixels.count; ++k) settle_pixel(film, pixels.items[k], &around, weight);
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

static double image_error(const fathom_film *film) {
    const size_t pixels = (size_t)film->width * film->height;
    double squares = 0, count = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (is_bound(film, i)) continue;
        squares += pixel_error(film, i);
        ++count;
    }
    return count > 0 ? sqrt(squares / count) : 0;
}

static void find_doubtful(const fathom_film *film, film_error *out) {
    const size_t pixels = (size_t)film->width * film->height;
    double doubtful = 0, count = 0;
    for (size_t i = 0; i < pixels; ++i) {
        if (is_bound(film, i)) {
            for (int c = 0; c < 3; ++c) out->unseen = fmax(out->unseen, FILM_ERROR_T * error_of(film, c, i));
            continue;
        }
        doubtful += film->doubt[i] > FILM_DOUBTFUL;
        ++count;
    }
    if (count > 0) out->doubtful = doubtful / count;
}

void film_settle_errors(fathom_film *film) {
    if (!film->doubt) return;
    const uint32_t rows = squares_between(film->y, film->y + film->height);
    film->whole = (film_error){.error = image_error(film)};
    sum_row(film, 0);
    for (uint32_t row = 0; row < rows; ++row) {
        if (row + 1 < rows) sum_row(film, row + 1);
        settle_row(film, row, rows);
    }
    find_doubtful(film, &film->whole);
    film->settled = true;
}

bool film_error_of(const fathom_film *film, film_error *out) {
    *out = film->whole;
    return film->settled && isfinite(out->error) && isfinite(out->unseen);
}
