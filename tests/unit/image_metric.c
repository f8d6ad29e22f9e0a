/* RMSE and relative MSE against values worked out by hand. */
#include "unit.h"

#include "image/compare/metric.h"

#define COUNT 4

typedef struct picture {
    float values[3][COUNT];
    metric_image image;
} picture;

static void fill(picture *p, float value) {
    p->image = (metric_image){{p->values[0], p->values[1], p->values[2]}, 2, 2};
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < COUNT; ++i) p->values[c][i] = value;
    }
}

UNIT_TEST(equal_images_have_no_error) {
    picture a;
    fill(&a, 0.3f);
    assert_true(metric_rmse(&a.image, &a.image) == 0);
    assert_true(metric_relmse(&a.image, &a.image) == 0);
    assert_true(metric_nonfinite(&a.image, &a.image) == 0);
}

/* An offset d everywhere: RMSE is |d|, relative MSE d² / (r² + 0.01). The values are exact in float; sums of
 * 12 terms and a root round by less than 16 units. */
UNIT_TEST(an_offset_is_the_rmse) {
    picture a, b;
    fill(&a, 0.5f);
    fill(&b, 0.75f);
    assert_near(metric_rmse(&a.image, &b.image), 0.25, 16 * 0x1p-53);
    assert_true(metric_rmse(&a.image, &b.image) == metric_rmse(&b.image, &a.image));
    assert_near(metric_relmse(&a.image, &b.image), 0.0625 / 0.26, 16 * 0x1p-53);
    assert_near(metric_relmse(&b.image, &a.image), 0.0625 / 0.5725, 16 * 0x1p-53);
}

/* One of the 12 values is off by 3, the others by nothing: √(9 / 12), and 9 / 0.01 / 12. */
UNIT_TEST(one_value_matches_the_definition) {
    picture a, b;
    fill(&a, 0);
    fill(&b, 0);
    b.values[1][2] = -3;
    assert_near(metric_rmse(&a.image, &b.image), sqrt(0.75), 16 * 0x1p-53);
    assert_near(metric_relmse(&a.image, &b.image), 75, 16 * 75 * 0x1p-53);
}

/* Wherever it stands, and though both images have it. */
UNIT_TEST(values_that_are_not_finite_make_errors_infinite) {
    const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t k = 0; k < 3; ++k) {
        picture a, b;
        fill(&a, 0.5f);
        fill(&b, 0.5f);
        a.values[2][1] = bad[k];
        for (int both = 0; both < 2; ++both) {
            assert_true(metric_nonfinite(&a.image, &b.image) == 1);
            assert_true(metric_nonfinite(&b.image, &a.image) == 1);
            assert_true(isinf(metric_rmse(&a.image, &b.image)));
            assert_true(isinf(metric_relmse(&a.image, &b.image)));
            assert_true(isinf(metric_relmse(&b.image, &a.image)));
            b.values[2][1] = bad[k];
        }
        b.values[0][1] = NAN, b.values[0][0] = NAN;
        assert_true(metric_nonfinite(&a.image, &b.image) == 2);
    }
}

int main(void) { return unit_main(NULL, NULL); }
