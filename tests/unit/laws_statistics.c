/* Tests of statistics alarm falsely as often as their level says. */
#include "random.h"
#include "unit.h"
#include "verify/laws/laws.h"

/* Tables of Student's distribution, two-sided, to four digits; 1 degree is Cauchy's and 2 has a closed form.
 */
UNIT_TEST(student_p_matches_closed_forms_and_tables) {
    for (double t = 0.1; t < 50; t *= 1.7) {
        assert_near(student_p(t, 1), 1 - 2 / 3.14159265358979324 * atan(t), 1e-13);
        assert_near(student_p(-t, 2), 1 - t / sqrt(2 + t * t), 1e-13);
        /* Both branches: a million degrees differ from the normal distribution by (t³ + t)/4e6 of its
         * density. */
        assert_near(student_p(t, 1e6), student_p(t, 1e7), 1e-6);
    }
    assert_near(student_p(2.2281, 10), 0.05, 1e-5);
    assert_near(student_p(3.6460, 30), 0.001, 1e-6);
    assert_near(student_p(1.9600, 1e9), 0.05, 1e-5);
}

UNIT_TEST(sidak_undoes_its_level) {
    for (double n = 1; n < 1e6; n *= 7) assert_near(sidak(sidak_level(0.01, n), n), 0.01, 1e-14);
    assert_near(sidak(1e-12, 1e3), 1e-9, 1e-15);
    assert_near(sidak(1, 5), 1, 0);
}

/* Standard normal (Box and Muller 1958). */
static double normal(random_state *r) {
    return sqrt(-2 * log(1 - random_unit(r))) * cos(6.28318530717958648 * random_unit(r));
}

static sample_mean of_normals(random_state *r, int n, double center, double spread) {
    double sum = 0, squares = 0;
    for (int i = 0; i < n; ++i) {
        const double x = center + spread * normal(r);
        sum += x, squares += x * x;
    }
    const double mean = sum / n, variance = (squares - n * mean * mean) / (n - 1);
    return (sample_mean){mean, sqrt(variance / n), n - 1};
}

/* So many alarms of `runs` at this level are within five standard errors of what is expected. */
static void assert_level(int alarms, int runs, double level) {
    assert_near(alarms, runs * level, 5 * sqrt(runs * level * (1 - level)));
}

UNIT_TEST(corrected_tests_alarm_as_often_as_their_level) {
    enum { RUNS = 4000, LAWS = 40 };
    const double level = 0.05, each = sidak_level(level, LAWS);
    random_state r = {1};
    int alarms = 0;
    for (int run = 0; run < RUNS; ++run) {
        bool alarm = false;
        for (int i = 0; i < LAWS; ++i) alarm |= mean_p(of_normals(&r, 12, 3, 2), 3, 0) < each;
        alarms += alarm;
    }
    assert_level(alarms, RUNS, level);
}

/* Welch's approximation of the degrees of freedom is good to a few parts in a hundred of the level here. */
UNIT_TEST(welch_alarms_as_often_as_its_level) {
    enum { RUNS = 4000, MEANS = 30 };
    random_state r = {2};
    int alarms = 0;
    for (int run = 0; run < RUNS; ++run) {
        sample_mean a[MEANS], b[MEANS];
        for (int i = 0; i < MEANS; ++i)
            a[i] = of_normals(&r, 16, 1e3 + i, 1), b[i] = of_normals(&r, 40, 1e3 + i, 3);
        alarms += laws_compare(a, b, MEANS, 0).p < 0.05;
    }
    assert_level(alarms, RUNS, 0.05);
}

UNIT_TEST(a_difference_of_eight_errors_is_found) {
    random_state r = {3};
    sample_mean a[50], b[50];
    for (int i = 0; i < 50; ++i) a[i] = of_normals(&r, 100, 5, 1), b[i] = of_normals(&r, 100, 5, 1);
    assert_true(laws_compare(a, b, 50, 0).p > 1e-3);
    b[17].mean += 8 * sqrt(0.02);
    const laws_difference d = laws_compare(a, b, 50, 0);
    assert_true(d.p < 1e-6);
    assert_int_equal(d.worst, 17);
}

UNIT_TEST(small_differences_in_one_direction_add_up) {
    enum { MEANS = 192 };
    sample_mean a[MEANS], b[MEANS];
    for (int i = 0; i < MEANS; ++i) {
        const double off = i % 3 == 1 ? 0.015 : 0; /* 1.5 errors in 64 cells: 12 of their sum */
        a[i] = (sample_mean){5, 0.006, 15}, b[i] = (sample_mean){5 + off, 0.008, 1000};
    }
    const laws_difference d = laws_compare(a, b, MEANS, 0);
    assert_true(d.p < 1e-6);
    assert_int_equal(d.worst, MEANS + 1);
}

UNIT_TEST(equal_constants_agree_and_others_do_not) {
    const sample_mean exact = {2, 0, 10}, same = {2 + 1e-9, 0, 10}, other = {2.1, 0, 10};
    assert_near(welch_p(exact, same, 0, 1e-6), 1, 0);
    assert_near(welch_p(exact, other, 0, 1e-6), 0, 0);
    assert_near(mean_p((sample_mean){(double)NAN, 1, 10}, 2, 1), 0, 0);
}

/* None of a million samples met a light of 1e-12, which another renderer asks for. */
UNIT_TEST(light_too_rare_to_be_met_is_no_difference) {
    sample_mean found[2] = {{3e-12, 1e-13, 100}, {1, 1e-3, 100}}, missed[2] = {{0, 0, 15}, {1, 1e-3, 15}};
    assert_true(welch_p(found[0], missed[0], 0, 0) < 1e-6);
    assert_true(laws_compare(found, missed, 2, 0).p > 0.9);
    missed[0].mean = 1e-4;
    assert_true(laws_compare(found, missed, 2, 0).p < 1e-6);
}

/* One sample in 500 meets light; how bright it is varies by 10^4 as 1 / brightness. */
static sample_mean of_rare_light(random_state *r, int n) {
    double sum = 0, squares = 0;
    for (int i = 0; i < n; ++i) {
        const double x = random_unit(r) < 0.002 ? pow(1e4, random_unit(r)) : 0;
        sum += x, squares += x * x;
    }
    const double mean = sum / n;
    return (sample_mean){mean, sqrt(fmax(squares / n - mean * mean, 0) / (n - 1)), n - 1};
}

/* The variance of such means is known too badly for Welch's test: it alarms in most of the runs. */
UNIT_TEST(rare_bright_samples_do_not_alarm_more_often_than_the_level) {
    enum { RUNS = 200, MEANS = 16 };
    const double each = sidak_level(0.05, MEANS), truth = 0.002 * (1e4 - 1) / log(1e4);
    random_state r = {4};
    int alarms = 0, alone = 0;
    for (int run = 0; run < RUNS; ++run) {
        sample_mean met[MEANS], exact[MEANS];
        bool alarm = false;
        for (int i = 0; i < MEANS; ++i) {
            met[i] = of_rare_light(&r, 4096), exact[i] = (sample_mean){truth, truth * 1e-3, 15};
            alarm |= welch_p(met[i], exact[i], 0, 0) < each;
        }
        alone += alarm, alarms += laws_compare(met, exact, MEANS, 0).p < 0.05;
    }
    assert_true(alone > RUNS / 2);
    assert_true(alarms <= RUNS * 0.05);
}

int main(void) { return unit_main(NULL, NULL); }
