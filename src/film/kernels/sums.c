#include "base/kernel.h"
#include "film/pixel_sums.h"

static void add_samples(const float *restrict from, double *restrict to) {
    for (int i = 0; i < LANES; ++i) to[i] += (double)from[i];
}

static void add_sums(const double *restrict from, double *restrict to) {
    for (int i = 0; i < LANES; ++i) to[i] += from[i];
}

static void move_sums(double *restrict from, double *restrict to) {
    for (int i = 0; i < LANES; ++i) to[i] = from[i], from[i] = 0;
}

static void store_square(const double *restrict sums, double scale, size_t width, float *restrict to) {
    _Alignas(64) float mean[LANES];
    for (int i = 0; i < LANES; ++i) mean[i] = (float)(sums[i] * scale);
    for (size_t row = 0; row < 4; ++row) memcpy(to + row * width, mean + 4 * row, 4 * sizeof *to);
}

const film_kernels KERNEL(film_kernels) = {
    .add_samples = add_samples, .add_sums = add_sums, .move_sums = move_sums, .store_square = store_square};
