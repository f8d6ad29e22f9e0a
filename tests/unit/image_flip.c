/* FLIP against values worked out by hand from its equations. */
#include "unit.h"

#include "image/compare/flip.h"
#include "random.h"

#define WIDTH 48
#define HEIGHT 32
#define COUNT (WIDTH * HEIGHT)

typedef struct picture {
    float values[3][COUNT];
    metric_image image;
} picture;

static void fill(picture *p, float r, float g, float b) {
    const float rgb[3] = {r, g, b};
    p->image = (metric_image){{p->values[0], p->values[1], p->values[2]}, WIDTH, HEIGHT};
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < COUNT; ++i) p->values[c][i] = rgb[c];
    }
}

static double flip_of(const picture *a, const picture *b, float *map) {
    flip_view *one = flip_view_create(&a->image, FLIP_PPD), *other = flip_view_create(&b->image, FLIP_PPD);
    assert_non_null(one);
    assert_non_null(other);
    double mean = flip_mean(one, other, map);
    flip_view_destroy(one);
    flip_view_destroy(other);
    return mean;
}

/* What the colour difference of exponent 0.7 becomes, by the paper's constants, with the largest worked out
 * by hand: of green, X Y Z over white's are 0.376242, 0.715183, 0.109466 and so L* a* b* are 87.7362,
 * -86.1787, 83.1826; of blue 32.2982, 79.1936, -107.8586. The Hunt effect makes that -75.6099, 72.9812
 * and 25.5781, -34.8364; HyAB is 55.4380 + √(101.1880² + 107.8176²) = 203.302. */
static double spread(double hyab) {
    double d = pow(hyab, 0.7), most = pow(203.302, 0.7), knee = 0.4 * most;
    return d < knee ? 0.95 * d / knee : 0.95 + 0.05 * (d - knee) / (most - knee);
}

UNIT_TEST(colour_spaces_match_the_paper) {
    double green[3], blue[3], back[3], opponent[3];
    flip_hunt((const double[3]){0, 1, 0}, green);
    flip_hunt((const double[3]){0, 0, 1}, blue);
    /* The figures above have four digits after the point. */
    assert_near(green[0], 87.7362, 1e-4);
    assert_near(green[1], -75.6099, 1e-4);
    assert_near(green[2], 72.9812, 1e-4);
    assert_near(blue[0], 32.2982, 1e-4);
    assert_near(blue[1], 25.5781, 1e-4);
    assert_near(blue[2], -34.8364, 1e-4);
    flip_opponent((const double[3]){1, 1, 1}, opponent);
    assert_near(opponent[0], 100, 1e-13);
    assert_near(opponent[1], 0, 1e-12);
    assert_near(opponent[2], 0, 1e-12);
    const double rgb[3] = {0.2, 0.7, 0.4};
    flip_opponent(rgb, opponent);
    flip_opponent_rgb(opponent, back);
    /* The inverse is rounded to 16 digits, and YCxCz lose three to their factors. */
    for (int c = 0; c < 3; ++c) assert_near(back[c], rgb[c], 1e-13);
}

UNIT_TEST(equal_images_have_no_difference) {
    picture a;
    fill(&a, 0.1f, 0.7f, 0.3f);
    random_state r = {1};
    for (int i = 0; i < COUNT; ++i) a.values[i % 3][i] = (float)random_unit(&r);
    assert_true(flip_of(&a, &a, NULL) == 0);
}

/* Greys 1/8 and 27/125: L* = 116 · 0.5 - 16 = 42 and 116 · 0.6 - 16 = 53.6; nothing else differs, and there
 * are no features. The tolerances are those of 203.302's six digits, and of 0.216 in float. */
UNIT_TEST(uniform_greys_match_the_equations) {
    picture a, b;
    fill(&a, 0.125f, 0.125f, 0.125f);
    fill(&b, 0.216f, 0.216f, 0.216f);
    assert_near(flip_of(&a, &b, NULL), spread(11.6), 1e-5);
    assert_true(flip_of(&a, &b, NULL) == flip_of(&b, &a, NULL));
    fill(&a, 0, 0, 0);
    fill(&b, 1, 1, 1);
    assert_near(flip_of(&a, &b, NULL), spread(100), 1e-5);
    /* Beyond what a screen shows there is nothing to see. */
    picture c;
    fill(&c, 8, 2, 1);
    assert_true(flip_of(&b, &c, NULL) == 0);
}

UNIT_TEST(uniform_colours_match_the_equations) {
    picture a, b;
    fill(&a, 0, 1, 0);
    fill(&b, 0, 0, 1);
    assert_near(flip_of(&a, &b, NULL), 1, 1e-12);
}

/* The weights of lightness' blur along one line, at 67 pixels a degree; 10 = ⌈3 √(0.04 / 2π²) 67⌉. */
static double blur_weight(int x) {
    double sum = 0;
    for (int i = -10; i <= 10; ++i) sum += exp(-M_PI * M_PI * i * i / (67.0 * 67 * 0.0047));
    return exp(-M_PI * M_PI * x * x / (67.0 * 67 * 0.0047)) / sum;
}

/* A step from grey 0.1 to 0.4 between columns 23 and 24, against grey 0.1. In column 23 all positive weights
 * of the edge filter lie on the bright side, so that the edge is 0.3, and no filter finds more; the blur
 * brings 0.3 (1 - w0) / 2 there. */
UNIT_TEST(a_step_matches_the_equations) {
    picture a, b;
    fill(&a, 0.1f, 0.1f, 0.1f);
    fill(&b, 0.1f, 0.1f, 0.1f);
    for (int i = 0; i < COUNT; ++i) {
        for (int c = 0; c < 3 && i % WIDTH >= 24; ++c) b.values[c][i] = 0.4f;
    }
    static float map[COUNT];
    flip_of(&a, &b, map);
    double seen = 0.1 + 0.3 * (1 - blur_weight(0)) / 2;
    double colour = spread(116 * (cbrt(seen) - cbrt(0.1)));
    double feature = sqrt(0.3 / M_SQRT2);
    /* Six digits of 203.302, and floats. */
    assert_near((double)map[16 * WIDTH + 23], pow(colour, 1 - feature), 1e-5);
    /* Far from the step the dark sides agree: filters reach 10 columns. */
    assert_true(map[16 * WIDTH + 12] == 0);
}

/* A line of grey 0.4 in column 24 on 0.1: there the edge filter finds nothing, and the point filter 0.3 of
 * its middle weight, with deviation 0.041 · 67 pixels and negative weights that sum to one. */
UNIT_TEST(a_line_matches_the_equations) {
    picture a, b;
    fill(&a, 0.1f, 0.1f, 0.1f);
    fill(&b, 0.1f, 0.1f, 0.1f);
    for (int i = 24; i < COUNT; i += WIDTH) b.values[0][i] = b.values[1][i] = b.values[2][i] = 0.4f;
    static float map[COUNT];
    flip_of(&a, &b, map);
    double sigma = 0.041 * 67, below = 0;
    for (int x = -2; x <= 2; ++x) below += (1 - x * x / sigma / sigma) * exp(-x * x / (2 * sigma * sigma));
    double seen = 0.1 + 0.3 * blur_weight(0);
    double colour = spread(116 * (cbrt(seen) - cbrt(0.1)));
    assert_near((double)map[16 * WIDTH + 24], pow(colour, 1 - sqrt(0.3 / below / M_SQRT2)), 1e-5);
}

/* What a blur of one Gaussian, exp(-π² x² / b), leaves of a line in its middle, and what it counts in a sum
 * of such: the square of what its weights sum to, over √b. */
static double line_left(double b, double *share) {
    double sum = 0;
    for (int i = -10; i <= 10; ++i) sum += exp(-M_PI * M_PI * i * i / (67.0 * 67 * b));
    *share = sum * sum / sqrt(b);
    return 1 / sum;
}

/* A line as light as what is about it: no feature, and each opponent colour is blurred in its own way. */
UNIT_TEST(a_coloured_line_matches_the_equations) {
    /* 2613072 R + 8788810 G + 887015 B is the same for both, to float's rounding. */
    const double about[3] = {0.3, 0.3, 0.1};
    const double rgb[3] = {0.4, 0.3 - (0.1 * 2613072 + 0.8 * 887015) / 8788810, 0.9};
    picture a, b;
    fill(&a, 0.3f, 0.3f, 0.1f);
    fill(&b, 0.3f, 0.3f, 0.1f);
    for (int i = 0; i < 3 * COUNT; ++i) {
        if (i % COUNT % WIDTH == 24) b.values[i / COUNT][i % COUNT] = (float)rgb[i / COUNT];
    }
    static float map[COUNT];
    flip_of(&a, &b, map);
    double share[2], left[3], before[3], seen[3], here[3], there[3];
    left[0] = line_left(0.0047, &share[0]);
    left[1] = line_left(0.0053, &share[0]);
    double wide = line_left(0.04, &share[0]), narrow = line_left(0.025, &share[1]);
    left[2] = (34.1 * share[0] * wide + 13.5 * share[1] * narrow) / (34.1 * share[0] + 13.5 * share[1]);
    flip_opponent(about, before);
    flip_opponent(rgb, seen);
    for (int c = 0; c < 3; ++c) seen[c] = before[c] + left[c] * (seen[c] - before[c]);
    flip_opponent_rgb(seen, there);
    flip_hunt(there, there);
    flip_hunt(about, here);
    /* The lightnesses differ by a rounding of 0.9 at most, 2^-25: a feature of √(2^-25 / √2) < 1.5e-4, which
     * in the exponent of d changes it by |d ln d| < 0.37 of that. The rest is the six digits of 203.302. */
    assert_near((double)map[16 * WIDTH + 24], spread(flip_hyab(here, there)), 6.5e-5);
}

/* A picture turned on its side has the same difference, turned: rows and columns are filtered alike. */
UNIT_TEST(turning_both_images_changes_nothing) {
    picture a, b, sides[2];
    fill(&a, 0.2f, 0.3f, 0.4f);
    fill(&b, 0.2f, 0.3f, 0.4f);
    random_state r = {2};
    for (int i = 0; i < COUNT; ++i) b.values[i % 3][i] = (float)random_unit(&r);
    const picture *upright[2] = {&a, &b};
    for (int k = 0; k < 2; ++k) {
        fill(&sides[k], 0, 0, 0);
        sides[k].image.width = HEIGHT, sides[k].image.height = WIDTH;
        for (int i = 0; i < 3 * COUNT; ++i) {
            int c = i / COUNT, x = i % COUNT % WIDTH, y = i % COUNT / WIDTH;
            sides[k].values[c][x * HEIGHT + y] = upright[k]->values[c][y * WIDTH + x];
        }
    }
    static float map[2][COUNT];
    flip_of(&a, &b, map[0]);
    flip_of(&sides[0], &sides[1], map[1]);
    /* Sums of 21 by 21 products in another order, and the map's floats. */
    for (int i = 0; i < COUNT; ++i)
        assert_near((double)map[0][i], (double)map[1][i % WIDTH * HEIGHT + i / WIDTH], 1e-6);
}

UNIT_TEST(more_noise_is_a_larger_difference) {
    picture a, b;
    double last = 0;
    fill(&a, 0.5f, 0.5f, 0.5f);
    for (float amplitude = 0.01f; amplitude < 0.5f; amplitude *= 2) {
        fill(&b, 0.5f, 0.5f, 0.5f);
        random_state r = {3};
        for (int i = 0; i < 3 * COUNT; ++i)
            b.values[i / COUNT][i % COUNT] += amplitude * (float)(2 * random_unit(&r) - 1);
        double now = flip_of(&a, &b, NULL);
        assert_true(now > last && now < 1);
        assert_true(now == flip_of(&b, &a, NULL));
        last = now;
    }
}

/* A broken pixel is the largest error, and reaches no other through the filters but as what is shown of it:
 * NaN as black. */
UNIT_TEST(a_pixel_that_is_not_finite_is_the_largest_error) {
    picture a, b;
    fill(&a, 0, 0, 0);
    fill(&b, 0, 0, 0);
    b.values[1][500] = NAN;
    static float map[COUNT];
    assert_near(flip_of(&a, &b, map), 1.0 / COUNT, 1e-15);
    assert_true(map[500] == 1 && map[501] == 0);
}

int main(void) { return unit_main(NULL, NULL); }
