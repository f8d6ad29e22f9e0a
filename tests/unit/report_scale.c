/* Axes, numbers for people, colours of magnitudes. */
#include "report/colour.h"
#include "report/heat.h"
#include "report/number.h"
#include "report/scale.h"
#include "unit.h"

/* ---- axes ---- */

/* Ticks are inside, in order, of the number asked for, and round: at most two digits. */
static void check_ticks(const scale *s, size_t most) {
    double ticks[SCALE_TICKS];
    size_t count = scale_ticks(s, most, ticks);
    if (count < 2 || count > most)
        fail_msg("%zu ticks from %g to %g, at most %zu", count, s->low, s->high, most);
    for (size_t i = 0; i < count; ++i) {
        /* Sums of a few steps: some roundings. */
        assert_true(ticks[i] >= s->low - 1e-9 * fabs(s->low) - 1e-9 * (s->high - s->low));
        assert_true(ticks[i] <= s->high + 1e-9 * fabs(s->high));
        if (i) assert_true(ticks[i] > ticks[i - 1]);
        if (s->log) {
            double digits = ticks[i] / pow(10, floor(log10(ticks[i]) + 1e-9));
            assert_near(digits, round(digits), 1e-9);
        }
    }
    for (size_t i = 2; i < count && !s->log; ++i)
        assert_near(ticks[i] - ticks[i - 1], ticks[1] - ticks[0], 1e-9 * (s->high - s->low));
}

static void test_scales_hold_what_they_are_over(void **state) {
    (void)state;
    static const double spans[][2] = {{60, 800},    {0.5, 2},       {1e-9, 4e9},       {3, 3},     {1, 10},
                                      {9.99, 10.1}, {1e-30, 1e-29}, {0.00123, 0.0013}, {7e5, 2e17}};
    for (size_t i = 0; i < sizeof spans / sizeof *spans; ++i) {
        for (int log = 0; log < 2; ++log) {
            scale s = scale_over(log, spans[i][0], spans[i][1], 10, 210);
            assert_true(s.low < s.high);
            assert_true(s.low <= spans[i][0] * (1 + 1e-9) && s.high >= spans[i][1] * (1 - 1e-9));
            assert_near(scale_at(&s, s.low), 10, 1e-9);
            assert_near(scale_at(&s, s.high), 210, 1e-9);
            for (size_t most = 4; most < 12; ++most) check_ticks(&s, most);
        }
    }
}

static void test_places(void **state) {
    (void)state;
    scale log = scale_over(true, 1, 1e4, 0, 400);
    assert_near(scale_at(&log, 10), 100, 1e-9);
    assert_near(scale_at(&log, 1e9), 400, 0);
    assert_near(scale_at(&log, 0), 0, 0);
    log.zero = -20;
    assert_near(scale_at(&log, 0), -20, 0);
    assert_near(scale_at(&log, 1e-9), 0, 0);
    scale up = scale_over(false, 0, 100, 300, 0);
    assert_near(scale_at(&up, 25), 225, 1e-9);
    double ticks[SCALE_TICKS];
    assert_int_equal(scale_ticks(&up, 6, ticks), 6);
    for (int i = 0; i < 6; ++i) assert_near(ticks[i], 20 * i, 1e-9);
    assert_int_equal(scale_ticks(&log, 8, ticks), 5);
    for (int i = 0; i < 5; ++i) assert_near(ticks[i] / pow(10, i), 1, 1e-12);
    /* Where decades are few, 2 and 5 times them stand between. */
    scale narrow = scale_over(true, 60, 800, 0, 1);
    assert_int_equal(scale_ticks(&narrow, 8, ticks), 5);
    static const double expected[5] = {50, 100, 200, 500, 1000};
    for (int i = 0; i < 5; ++i) assert_near(ticks[i], expected[i], 1e-9);
}

/* ---- numbers ---- */

static void test_numbers(void **state) {
    (void)state;
    static const struct {
        double x;
        const char *text;
    } cases[] = {{0, "0"},
                 {1, "1"},
                 {0.5, "0.5"},
                 {2.1199618, "2.12"},
                 {-43.27, "−43.3"},
                 {999.6, "1000"},
                 {1234, "1230"},
                 {9994, "9990"},
                 {9999, "10×10³"},
                 {0.01234, "0.0123"},
                 {0.00999, "9.99×10⁻³"},
                 {3.9e8, "390×10⁶"},
                 {999999, "1×10⁶"},
                 {1e-10, "100×10⁻¹²"},
                 {-1e15, "−1×10¹⁵"},
                 {1e300, "1×10³⁰⁰"},
                 {5e-324, "4.94×10⁻³²⁴"},
                 {(double)INFINITY, "∞"},
                 {-(double)INFINITY, "−∞"},
                 {(double)NAN, "–"}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i)
        assert_string_equal(number_of(cases[i].x).text, cases[i].text);
    assert_string_equal(number_count(0).text, "0");
    assert_string_equal(number_count(5500).text, "5500");
    assert_string_equal(number_count(1234567).text, "1\u202f234\u202f567");
    assert_string_equal(number_tick(1e-8).text, "10⁻⁸");
    assert_string_equal(number_tick(100).text, "100");
    assert_string_equal(number_tick(6.371e6).text, "6.37×10⁶");
    assert_int_equal(number_width("6.37×10⁶"), 8);
}

/* ---- colours ---- */

static void test_colours_keep_the_order(void **state) {
    (void)state;
    for (unsigned i = 1; i < COLOUR_STEPS; ++i) {
        double light = colour_luminance(colour_step(i - 1, 0)) - colour_luminance(colour_step(i, 0));
        double dark = colour_luminance(colour_step(i, 1)) - colour_luminance(colour_step(i - 1, 1));
        /* More than the last place of one channel, the blue one apart, which weighs little. */
        assert_true(light > 0.005 && dark > 0.005);
    }
    assert_near(colour_luminance((colour){255, 255, 255}), 1, 1e-9);
    heat_range range = {0.1, 100};
    unsigned last = 0;
    for (double x = 1e-3; x < 1e4; x *= 1.1) {
        unsigned step = heat_step(&range, x);
        assert_true(step >= last && step < COLOUR_STEPS);
        last = step;
    }
    assert_int_equal(last, COLOUR_STEPS - 1);
    assert_int_equal(heat_step(&range, 0), 0);
    assert_int_equal(heat_step(&range, (double)NAN), 0);
    assert_int_equal(heat_step(&range, (double)INFINITY), COLOUR_STEPS - 1);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_scales_hold_what_they_are_over),
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_numbers),
        cmocka_unit_test(test_colours_keep_the_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
