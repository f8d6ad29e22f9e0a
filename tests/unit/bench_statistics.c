/* What measurements are told by: medians, intervals, lines. */
#include "unit.h"

#include "measure/statistics.h"

UNIT_TEST(medians) {
    double odd[] = {5, 1, 3}, even[] = {4, 1, 3, 2};
    assert_true(quartiles_of(odd, 3).median == 3);
    assert_true(quartiles_of(even, 4).median == 2.5);
}

/* Of four values in order x1 … x4 the lower quartile lies at 1 + 0.25 · 3, three quarters of the way from the
 * first to the second: 1 + 0.75 · (3 - 1) by hand. */
UNIT_TEST(quarters) {
    double four[] = {9, 1, 5, 3}, one[] = {7};
    quartiles q = quartiles_of(four, 4);
    assert_true(q.low == 2.5 && q.median == 4 && q.high == 6);
    q = quartiles_of(one, 1);
    assert_true(q.low == 7 && q.median == 7 && q.high == 7);
    assert_true(isnan(quartiles_of(one, 0).median));
}

/* For 2 degrees of freedom Student's distribution has the closed form P(|T| <= t) = t / √(2 + t²). */
UNIT_TEST(student) {
    assert_true(isinf(student_95(0)));
    assert_near(student_95(1), tan(0.475 * M_PI), 0.001); /* Cauchy's distribution */
    assert_near(student_95(2), 0.95 * sqrt(2 / (1 - 0.95 * 0.95)), 0.001);
    for (size_t n = 1; n < 200; ++n) assert_true(student_95(n + 1) < student_95(n));
    assert_near(student_95(1000000), 1.959964, 0.001);
}

/* 1, 2, 3: deviation 1, so the half width is 4.303 / √3. */
UNIT_TEST(means) {
    const double values[] = {1, 2, 3};
    mean_interval m = mean_of(values, 3);
    assert_true(m.mean == 2);
    assert_near(m.half, student_95(2) / sqrt(3), 1e-15 * 4);
    assert_true(isinf(mean_of(values, 1).half));
    assert_true(isnan(mean_of(values, 0).mean));
}

/* By hand: x̄ = 1, ȳ = 4/3, Σ(x - x̄)(y - ȳ) = 1, Σ(x - x̄)² = 2. */
UNIT_TEST(lines) {
    const double x[] = {0, 1, 2}, y[] = {1, 1, 2}, same[] = {3, 3, 3};
    line_fit l = line_through(x, y, 3);
    assert_near(l.slope, 0.5, 1e-15);
    assert_near(l.intercept, 5.0 / 6, 1e-15);
    assert_true(isnan(line_through(same, y, 3).slope));
    assert_true(isnan(line_through(x, y, 0).slope));
    /* The line leaves 1/6, -1/3, 1/6: squares of 1/6 together, one degree of freedom. */
    assert_near(l.half, student_95(1) * sqrt(1.0 / 12), 1e-14);
    assert_true(isinf(line_through(x, y, 2).half));
}

/* Seconds that are a power of the triangles have that exponent, and an interval of nothing but rounding: sums
 * of five logarithms below 20, each rounded, over a spread of Σ (x - x̄)² = 53. */
UNIT_TEST(powers) {
    double n[5], t[5];
    for (int i = 0; i < 5; ++i) n[i] = pow(10, 4 + i), t[i] = 3e-9 * pow(n[i], 1.1);
    power_fit fit = power_through(n, t, 5);
    assert_int_equal(fit.count, 5);
    assert_near(fit.exponent, 1.1, 1e-13);
    assert_near(fit.scale / 3e-9, 1, 1e-12);
    assert_near(fit.half, 0, 1e-12);
    /* Pairs without a logarithm do not count. */
    const double few_n[] = {10, 100, 1000, 0}, few_t[] = {1, 10, 0, 5};
    fit = power_through(few_n, few_t, 4);
    assert_int_equal(fit.count, 2);
    assert_near(fit.exponent, 1, 1e-14);
    assert_true(isinf(fit.half));
    assert_true(isnan(power_through(few_n, few_t, 1).exponent));
}

/* One of the times off by a factor e, in the middle of x = 0, 1, 2: the slope stays, the line leaves
 * -1/3, 2/3, -1/3. */
UNIT_TEST(intervals_of_powers) {
    const double n[] = {1, M_E, M_E * M_E}, t[] = {1, M_E * M_E, M_E * M_E};
    power_fit fit = power_through(n, t, 3);
    assert_near(fit.exponent, 1, 1e-14);
    assert_near(fit.half, student_95(1) * sqrt(2.0 / 3 / 2), 1e-13);
}

int main(void) { return unit_main(NULL, NULL); }
