/* The numbers of samples: where they lie, and that dimensions know nothing of each other. */
#include "sample/sample.h"
#include "unit.h"
#include "variants.h"

VARIANTS(sample_kernels)

static const sampler sobol = {FATHOM_PATTERN_SOBOL, 1, 11};

static void sample(const sampler *s, uint32_t x, uint32_t index, uint32_t dimension, double p[2]) {
    sample_2d(s, (sample_key){x, x / 3, index}, (sample_dimension)dimension, &p[0], &p[1]);
    for (int c = 0; c < 2; ++c) assert_true(p[c] >= 0 && p[c] < 1);
}

UNIT_TEST(each_cell_of_a_grid_holds_one_sample) {
    static const fathom_pattern patterns[] = {FATHOM_PATTERN_GRID, FATHOM_PATTERN_STRATIFIED};
    for (int k = 0; k < 2; ++k) {
        const sampler s = {patterns[k], 5, 3};
        for (uint32_t index = 0; index < 50; ++index) {
            double p[2];
            sample(&s, 17, index, SAMPLE_PIXEL, p);
            assert_int_equal((int)(p[0] * 5), index % 5);
            assert_int_equal((int)(p[1] * 5), index / 5 % 5);
        }
    }
}

/* 2^a × 2^b boxes, a + b = k: one of 2^k points in each. */
static void check_boxes(uint32_t pixel, uint32_t dimension, uint32_t run, uint32_t k) {
    for (uint32_t a = 0; a <= k; ++a) {
        bool taken[256] = {false};
        for (uint32_t i = 0; i < 1u << k; ++i) {
            double p[2];
            sample(&sobol, pixel, (run << k) + i, dimension, p);
            uint32_t box = (uint32_t)(p[0] * (1u << a)) << (k - a) | (uint32_t)(p[1] * (1u << (k - a)));
            assert_false(taken[box]);
            taken[box] = true;
        }
    }
}

UNIT_TEST(every_run_of_a_power_of_two_is_stratified_in_every_dimension) {
    for (uint32_t dimension = 0; dimension < 6; ++dimension) {
        for (uint32_t run = 0; run < 3; ++run) {
            for (uint32_t k = 1; k <= 8; ++k) check_boxes(100 + run, dimension, run, k);
        }
    }
}

/* 2^a × 2^b × 2^c boxes: 2 of 2^k points in each if a + b + c = k - 1, and one if that is k and c is even. */
static void check_solid_boxes(const double (*p)[3], uint32_t k, uint32_t a, uint32_t b, uint32_t c) {
    unsigned taken[256] = {0};
    for (uint32_t i = 0; i < 1u << k; ++i) {
        const uint32_t box = ((uint32_t)(p[i][0] * (1u << a)) << b | (uint32_t)(p[i][1] * (1u << b))) << c |
                             (uint32_t)(p[i][2] * (1u << c));
        ++taken[box];
    }
    for (uint32_t i = 0; i < 1u << (a + b + c); ++i) assert_int_equal(taken[i], 1u << (k - a - b - c));
}

UNIT_TEST(triples_are_stratified_as_well) {
    static double p[256][3];
    for (uint32_t run = 0; run < 5; ++run) {
        for (uint32_t k = 1; k <= 8; ++k) {
            for (uint32_t i = 0; i < 1u << k; ++i) {
                const uint64_t pixel[LANES] = {sample_pixel_hash(&sobol, run, 5)};
                const uint32_t index[LANES] = {(run << k) + i};
                float u[3][LANES];
                sample_kernels_best()->triples(pixel, index, SAMPLE_VERTEX + run, u[0], u[1], u[2]);
                for (int c = 0; c < 3; ++c) p[i][c] = (double)u[c][0];
            }
            for (uint32_t a = 0; a <= k; ++a) {
                for (uint32_t c = 0; c <= k - a; ++c) {
                    if (!(c & 1)) check_solid_boxes(p, k, a, k - a - c, c);
                    if (a + c < k) check_solid_boxes(p, k, a, k - 1 - a - c, c);
                }
            }
        }
    }
}

/* Pearson's chi² of a pair of coordinates over 8 × 8 cells, 63 degrees of freedom; each pixel gives its first
 * sample alone, so that nothing stratifies one against another. Wilson and Hilferty's cube root of chi² is
 * normal: |z| < 5.1 holds but for 3.4e-7, for all 24 tests together but for 8e-6 (Bonferroni). */
static void check_pair(const unsigned counts[8][8], double total) {
    double chi = 0;
    for (int i = 0; i < 64; ++i) {
        double expected = total / 64, off = counts[i / 8][i % 8] - expected;
        chi += off * off / expected;
    }
    const double degrees = 63, z = (cbrt(chi / degrees) - (1 - 2 / (9 * degrees))) / sqrt(2 / (9 * degrees));
    assert_true(fabs(z) < 5.1);
}

UNIT_TEST(dimensions_are_independent_of_each_other) {
    for (uint32_t a = 0; a < 4; ++a) {
        for (uint32_t b = a + 1; b < 4; ++b) {
            for (int c = 0; c < 4; ++c) {
                unsigned counts[8][8] = {{0}};
                for (uint32_t pixel = 0; pixel < 20000; ++pixel) {
                    double p[2], q[2];
                    sample(&sobol, pixel, 0, a, p);
                    sample(&sobol, pixel, 0, b, q);
                    ++counts[(int)(8 * p[c & 1])][(int)(8 * q[c >> 1])];
                }
                check_pair(counts, 20000);
            }
        }
    }
}

/* Rounding down to 24 bits keeps every box of 2^-24. */
UNIT_TEST(blocks_hold_the_numbers_of_single_samples) {
    uint64_t pixel[LANES];
    uint32_t index[LANES];
    for (int i = 0; i < LANES; ++i)
        pixel[i] = sample_pixel_hash(&sobol, 77u + (uint32_t)i, 9), index[i] = 1000003u * (uint32_t)i;
    for (unsigned k = 0; sample_kernels_at(k); ++k) {
        for (uint32_t dimension = SAMPLE_LENS; dimension < 20; ++dimension) {
            float u[LANES], v[LANES], triple[3][LANES], first[LANES];
            sample_kernels_at(k)->pairs(pixel, index, dimension, u, v);
            sample_kernels_at(k)->triples(pixel, index, dimension, triple[0], triple[1], triple[2]);
            assert_memory_equal(triple[0], u, sizeof u);
            assert_memory_equal(triple[1], v, sizeof v);
            sample_kernels_at(0)->triples(pixel, index, dimension, triple[0], triple[1], first);
            assert_memory_equal(triple[2], first, sizeof first);
            for (int i = 0; i < LANES; ++i) {
                double x, y;
                sample_2d(&sobol, (sample_key){77u + (uint32_t)i, 9, index[i]}, (sample_dimension)dimension,
                          &x, &y);
                assert_true((double)u[i] == floor(x * 0x1p24) * 0x1p-24);
                assert_true((double)v[i] == floor(y * 0x1p24) * 0x1p-24);
            }
        }
    }
}

UNIT_TEST(squares_hold_the_numbers_of_their_pixels) {
    for (unsigned k = 0; sample_kernels_at(k); ++k) {
        for (uint32_t index = 3; index < 3000000; index *= 7) {
            uint64_t pixel[LANES];
            double x[LANES], y[LANES];
            sample_kernels_at(k)->square(&sobol, 77 + index, 9, pixel);
            for (uint32_t i = 0; i < 2 * LANES; ++i) {
                const sample_dimension dimension = i / LANES ? SAMPLE_LENS : SAMPLE_PIXEL;
                const sample_key key = {77 + index + i % 4, 9 + i % LANES / 4, index};
                double u, v;
                sample_kernels_at(k)->places(pixel, index, dimension, x, y);
                sample_2d(&sobol, key, dimension, &u, &v);
                assert_true(pixel[i % LANES] == sample_pixel_hash(&sobol, key.x, key.y));
                assert_true(x[i % LANES] == u && y[i % LANES] == v);
            }
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
