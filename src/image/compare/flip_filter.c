#include "image/compare/flip_filter.h"

#include <math.h>
#include <string.h>

static double gauss(double x, double sigma) { return exp(-x * x / (2 * sigma * sigma)); }

flip_kernel flip_gauss(double sigma, int radius) {
    flip_kernel k = {.radius = radius};
    double sum = 0;
    for (int x = -radius; x <= radius; ++x) sum += k.weights[x + radius] = gauss(x, sigma);
    for (int i = 0; i <= 2 * radius; ++i) k.weights[i] /= sum;
    return k;
}

static void balance(flip_kernel *k) {
    double above = 0, below = 0;
    for (int i = 0; i <= 2 * k->radius; ++i) {
        above += fmax(k->weights[i], 0);
        below -= fmin(k->weights[i], 0);
    }
    for (int i = 0; i <= 2 * k->radius; ++i) k->weights[i] /= k->weights[i] > 0 ? above : below;
}

flip_kernel flip_edge(double sigma, int radius) {
    flip_kernel k = {.radius = radius};
    for (int x = -radius; x <= radius; ++x) k.weights[x + radius] = -x * gauss(x, sigma);
    balance(&k);
    return k;
}

flip_kernel flip_point(double sigma, int radius) {
    flip_kernel k = {.radius = radius};
    for (int x = -radius; x <= radius; ++x)
        k.weights[x + radius] = (x * x / (sigma * sigma) - 1) * gauss(x, sigma);
    balance(&k);
    return k;
}

/* The line as it goes on beyond the border. */
static void extend_row(const double *row, size_t width, size_t radius, double *line) {
    for (size_t i = 0; i < radius; ++i) line[i] = row[0], line[radius + width + i] = row[width - 1];
    memcpy(line + radius, row, width * sizeof *row);
}

static void add_row(const double *restrict from, double weight, size_t width, double *restrict to) {
    for (size_t x = 0; x < width; ++x) to[x] += weight * from[x];
}

void flip_along_rows(const double *in, flip_size size, const flip_kernel *k, double *line, double *out) {
    memset(out, 0, size.width * size.height * sizeof *out);
    for (size_t y = 0; y < size.height; ++y) {
        extend_row(in + y * size.width, size.width, (size_t)k->radius, line);
        for (int i = 0; i <= 2 * k->radius; ++i)
            add_row(line + i, k->weights[i], size.width, out + y * size.width);
    }
}

void flip_along_columns(const double *in, flip_size size, const flip_kernel *k, double *out) {
    memset(out, 0, size.width * size.height * sizeof *out);
    for (size_t y = 0; y < size.height; ++y) {
        for (int i = -k->radius; i <= k->radius; ++i) {
            ptrdiff_t row = (ptrdiff_t)y + i, last = (ptrdiff_t)size.height - 1;
            row = row < 0 ? 0 : row > last ? last : row;
            add_row(in + (size_t)row * size.width, k->weights[i + k->radius], size.width,
                    out + y * size.width);
        }
    }
}
