/* Vectors, frames and affine maps: the laws they keep. */
#include "math/affine.h"
#include "math/frame.h"
#include "math/power.h"
#include "unit.h"

static void frame_is_orthonormal(const frame_f64 *f) {
    /* Each axis is a normalised sum of products: a few roundings of 2^-53. */
    const double tolerance = 8 * 0x1p-53;
    assert_near(dot_f64(f->x, f->x), 1, tolerance);
    assert_near(dot_f64(f->y, f->y), 1, tolerance);
    assert_near(dot_f64(f->z, f->z), 1, tolerance);
    assert_near(dot_f64(f->x, f->y), 0, tolerance);
    assert_near(dot_f64(f->y, f->z), 0, tolerance);
    assert_near(dot_f64(f->z, f->x), 0, tolerance);
    assert_near(dot_f64(cross_f64(f->x, f->y), f->z), 1, tolerance);
}

UNIT_TEST(frames_from_any_two_directions) {
    const double values[] = {0, 1, -1, 1e-30, 1e30, 0.3};
    const size_t n = sizeof values / sizeof *values;
    for (size_t i = 0; i < n * n * n; ++i) {
        for (size_t j = 0; j < n * n * n; ++j) {
            vec3_f64 z = {values[i % n], values[i / n % n], values[i / n / n]};
            vec3_f64 y = {values[j % n], values[j / n % n], values[j / n / n]};
            frame_f64 f = frame_from((vec3_f64){1, 2, 3}, z, y);
            frame_is_orthonormal(&f);
        }
    }
}

UNIT_TEST(affine_inverse) {
    affine_f64 rotation = affine_rotation_axis((vec3_f64){1, 2, 3}, 0.7);
    affine_f64 scaling = affine_scaling((vec3_f64){1e-6, -1, 1e6});
    affine_f64 map = affine_compose(&rotation, &scaling), inverse;
    map.m[0][3] = 5, map.m[1][3] = -7;
    assert_true(affine_invert(&map, &inverse));
    vec3_f64 p = {3, 4, 5}, q = affine_point(&inverse, affine_point(&map, p));
    /* Map and inverse stretch by up to 1e6 and shrink by up to 1e6, and cofactors of the turned map cancel
     * that much again: |M||M^-1||p| roundings, a condition number of 1e12. */
    assert_near(length_f64(sub_f64(q, p)), 0, 64 * 0x1p-53 * 1e12 * 7);
    /* Without the turn nothing cancels. */
    assert_true(affine_invert(&scaling, &inverse));
    q = affine_point(&inverse, affine_point(&scaling, p));
    assert_near(length_f64(sub_f64(q, p)), 0, 8 * 0x1p-53 * 7);
    affine_f64 flat = affine_scaling((vec3_f64){1, 1, 0});
    assert_false(affine_invert(&flat, &inverse));
}

/* (1-d)^n within an ulp: 2 u of itself, and half an ulp of the smallest normal number. */
UNIT_TEST(powers_next_to_one) {
    const float exponents[] = {0.5f, 1, 2, 12.5f, 400, 1e4f, 1e6f, 1e9f};
    for (size_t e = 0; e < sizeof exponents / sizeof *exponents; ++e) {
        for (float d = 1e-12f; d < 0.29f; d *= 1.07f) {
            double exact = (double)expl((long double)exponents[e] * log1pl(-(long double)d));
            float found = power_one_less(d, exponents[e]);
            if (exact < 0x1p-125) {
                assert_true(found <= 0x1p-125f);
            } else {
                assert_near(found, exact, exact * 2 * 0x1p-24);
            }
        }
        assert_near(power_one_less(0, exponents[e]), 1, 0);
        assert_near(power_one_less(1, exponents[e]), 0, 0);
        assert_near(power_one_less(2, exponents[e]), 0, 0);
        float x = 1 - 0.7f;
        assert_near(power_one_less(0.7f, exponents[e]), pow((double)x, (double)exponents[e]), 4 * 0x1p-24);
    }
    assert_near(power_one_less(0.5f, 0), 1, 0);
    assert_near(power_one_less(1, 0), 0, 0);
}

int main(void) { return unit_main(NULL, NULL); }
