/* Noise and random numbers under the generators. */
#include "generate/generate.h"
#include "unit.h"

/* A central difference with step h is off by h² f''' / 6 and by the rounding of f over h. The third
 * derivative of the noise is below 300 (the fade's is at most 60, the ramps' slope below 2), and of an octave
 * with frequency F and height A by A F³ as much. */
static double slope_tolerance(double scale) {
    const double h = 1e-4;
    return scale * h * h * 300 / 6 + 16 * 0x1p-53 * 8 / h;
}

static double slope(vec3_f64 p, int axis, double (*f)(vec3_f64 p)) {
    const double h = 1e-4;
    vec3_f64 step = {axis == 0 ? h : 0, axis == 1 ? h : 0, axis == 2 ? h : 0};
    return (f(add_f64(p, step)) - f(sub_f64(p, step))) / (2 * h);
}

static double value_3d(vec3_f64 p) { return noise_3d(5, p).value; }
static double value_2d(vec3_f64 p) { return noise_2d(5, p.x, p.y).value; }
static double value_fbm(vec3_f64 p) { return noise_fbm(5, p, 4, 0.5).value; }

UNIT_TEST(gradients_are_slopes) {
    noise_random random = noise_random_from(1, 2);
    for (int i = 0; i < 2000; ++i) {
        vec3_f64 p = scale_f64(random_between(&random, 0, 20), random_direction(&random));
        noise_value solid = noise_3d(5, p), flat = noise_2d(5, p.x, p.y), sum = noise_fbm(5, p, 4, 0.5);
        const double g3[3] = {solid.gradient.x, solid.gradient.y, solid.gradient.z};
        const double g2[3] = {flat.gradient.x, flat.gradient.y, flat.gradient.z};
        const double gs[3] = {sum.gradient.x, sum.gradient.y, sum.gradient.z};
        for (int a = 0; a < 3; ++a) {
            assert_near(g3[a], slope(p, a, value_3d), slope_tolerance(1));
            assert_near(g2[a], slope(p, a, value_2d), slope_tolerance(1));
            /* 1 + 0.5·8 + 0.25·64 + 0.125·512 */
            assert_near(gs[a], slope(p, a, value_fbm), slope_tolerance(85));
        }
    }
}

/* Zero on the lattice, continuous across it, and neither constant nor beyond its bounds between. */
UNIT_TEST(noise_is_bounded) {
    noise_random random = noise_random_from(3, 4);
    double least = 0, most = 0;
    for (int i = 0; i < 100000; ++i) {
        vec3_f64 p = scale_f64(random_between(&random, 0, 1000), random_direction(&random));
        double value = noise_3d(9, p).value;
        least = fmin(least, value), most = fmax(most, value);
        vec3_f64 corner = {floor(p.x), floor(p.y), floor(p.z)};
        assert_true(noise_3d(9, corner).value == 0);
        vec3_f64 edge = {corner.x, p.y, p.z}, before = {corner.x - 1e-9, p.y, p.z};
        assert_near(noise_3d(9, edge).value, noise_3d(9, before).value, 1e-8);
    }
    assert_true(least < -0.6 && least >= -1.5 && most > 0.6 && most <= 1.5);
}

/* Octaves stop when waves become shorter than asked for. */
UNIT_TEST(octaves_stop) {
    assert_int_equal(noise_octaves(1, 1), 1);
    assert_int_equal(noise_octaves(1, 100), 1);
    assert_int_equal(noise_octaves(1, 0.25), 2);
    assert_int_equal(noise_octaves(2, 0.001), 9);
    assert_int_equal(noise_octaves(1, 0), NOISE_MAX_OCTAVES);
}

/* A mean of n even numbers in [0,1) lies within 5 standard deviations, 5 / sqrt(12 n); that of a coordinate
 * of a unit vector within 5 / sqrt(3 n). */
UNIT_TEST(random_numbers_are_even) {
    const int n = 200000;
    noise_random random = noise_random_from(7, 0);
    double sum = 0;
    vec3_f64 center = {0};
    for (int i = 0; i < n; ++i) {
        double u = random_unit(&random);
        assert_true(u >= 0 && u < 1);
        sum += u;
        vec3_f64 d = random_direction(&random), t = random_turn(&random);
        assert_near(dot_f64(d, d), 1, 16 * 0x1p-53);
        assert_near(dot_f64(t, t), 1, 16 * 0x1p-53);
        assert_true(t.y == 0);
        center = add_f64(center, d);
    }
    assert_near(sum / n, 0.5, 5 / sqrt(12.0 * n));
    assert_near(center.x / n, 0, 5 / sqrt(3.0 * n));
    assert_near(center.y / n, 0, 5 / sqrt(3.0 * n));
    assert_near(center.z / n, 0, 5 / sqrt(3.0 * n));
    noise_random other = noise_random_from(7, 1);
    assert_true(random_unit(&other) != random_unit(&random));
}

UNIT_TEST(turns_are_cosines) {
    for (int i = 0; i < 5000; ++i) {
        double turns = i * 0.00173;
        vec3_f64 t = tree_turn(turns);
        /* The series ends with a term of (pi/4)^14 / 14! < 2^-41 of cosine; and the argument is rounded. */
        assert_near(t.x, cos(turns * 6.283185307179586), 0x1p-41 + 64 * 0x1p-53);
        assert_near(t.z, sin(turns * 6.283185307179586), 0x1p-41 + 64 * 0x1p-53);
    }
}

int main(void) { return unit_main(NULL, NULL); }
