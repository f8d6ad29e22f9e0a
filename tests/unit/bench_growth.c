/* Exponents of growth. */
#include "measure/growth.h"
#include "unit.h"

/* Seconds that are a power of the triangles have that exponent, and an interval of nothing but rounding: sums
 * of five logarithms below 20, each rounded, over a spread of Σ (x - x̄)² = 53. */
static void powers(void **state) {
    (void)state;
    double n[5], t[5];
    for (int i = 0; i < 5; ++i) n[i] = pow(10, 4 + i), t[i] = 3e-9 * pow(n[i], 1.1);
    growth_fit fit = growth_fit_of(n, t, 5);
    assert_int_equal(fit.count, 5);
    assert_near(fit.exponent, 1.1, 1e-13);
    assert_near(fit.scale / 3e-9, 1, 1e-12);
    assert_near(fit.half, 0, 1e-12);
}

/* One of the times off by a factor e, in the middle of x = 0, 1, 2: the slope stays, the line leaves
 * -1/3, 2/3, -1/3. */
static void intervals(void **state) {
    (void)state;
    const double n[] = {1, M_E, M_E * M_E}, t[] = {1, M_E * M_E, M_E * M_E};
    growth_fit fit = growth_fit_of(n, t, 3);
    assert_near(fit.exponent, 1, 1e-14);
    assert_near(fit.half, student_95(1) * sqrt(2.0 / 3 / 2), 1e-13);
}

/* What has no logarithm is left out. */
static void few(void **state) {
    (void)state;
    const double n[] = {10, 100, 1000, 0}, t[] = {1, 10, 0, 5};
    growth_fit fit = growth_fit_of(n, t, 4);
    assert_int_equal(fit.count, 2);
    assert_near(fit.exponent, 1, 1e-14);
    assert_true(isinf(fit.half));
    assert_true(isnan(growth_fit_of(n, t, 1).exponent));
}

int main(void) {
    const struct CMUnitTest tests[] = {cmocka_unit_test(powers), cmocka_unit_test(intervals),
                                       cmocka_unit_test(few)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
