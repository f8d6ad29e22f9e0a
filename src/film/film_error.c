/* The error channels of a film, taken together. */
#include "film/film.h"

#include <math.h>

double film_error_weight(double grey) {
    double norm = grey < 1 ? fmax(grey, 0.01) : grey * grey;
    return 1 / norm;
}

static bool is_bound(const fathom_film *film, size_t pixel) { return film->largest[pixel] >= 1; }

static double pixel_error(const fathom_film *film, size_t pixel) {
    double squares = 0, grey = 0;
    for (int c = 0; c < 3; ++c) {
        const double error = (double)film->error[c][pixel];
        squares += error * error / 3;
        grey += (double)film->rgb[c][pixel] / 3;
    }
    return squares * film_error_weight(grey);
}

bool film_error_of(const fathom_film *film, film_error *out) {
    const size_t pixels = (size_t)film->width * film->height;
    double squares = 0, doubtful = 0, count = 0;
    *out = (film_error){.error = 0};
    for (size_t i = 0; film->largest && i < pixels; ++i) {
        if (is_bound(film, i)) {
            for (int c = 0; c < 3; ++c)
                out->unseen = fmax(out->unseen, FILM_ERROR_T * (double)film->error[c][i]);
            continue;
        }
        squares += pixel_error(film, i);
        doubtful += film->largest[i] > FILM_DOUBTFUL;
        ++count;
    }
    if (count > 0) out->error = sqrt(squares / count), out->doubtful = doubtful / count;
    return film->largest && isfinite(out->error) && isfinite(out->unseen);
}
