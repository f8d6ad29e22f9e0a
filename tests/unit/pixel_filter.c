/* Pixel filters by closed form: where samples lie, and what a bright edge adds to the pixels around it. */
#include "camera/filter.h"
#include "render.h"

static const fathom_filter filters[] = {FATHOM_FILTER_BOX, FATHOM_FILTER_GAUSSIAN,
                                        FATHOM_FILTER_BLACKMAN_HARRIS};

/* The filter's integral from the middle to x, in widths. */
static double integral(fathom_filter filter, double x) {
    if (filter == FATHOM_FILTER_GAUSSIAN) return sqrt(M_PI / 32) * erf(sqrt(8) * x) - exp(-2) * x;
    if (filter == FATHOM_FILTER_BLACKMAN_HARRIS)
        return 0.35875 * x + 0.48829 * sin(2 * M_PI * x) / (2 * M_PI) +
               0.14128 * sin(4 * M_PI * x) / (4 * M_PI) + 0.01168 * sin(6 * M_PI * x) / (6 * M_PI);
    return x;
}

/* The part of the filter before x pixels from the pixel's centre. */
static double part_before(fathom_filter filter, double width, double x) {
    const double t = fmin(fmax(x / width, -0.5), 0.5);
    return 0.5 + integral(filter, t) / (2 * integral(filter, 0.5));
}

/* Between two places of the table the part grows linearly. The filter is monotonous there, so the part is off
 * by less than a step of the table, and one of the sums that made it: four for a step, each at most 1 /
 * 0.35875 times the mean. */
static const double tolerance = (1 + 1 / (4 * 0.35875)) / FILTER_STEPS;

UNIT_TEST(samples_lie_as_the_filter_says) {
    static const double widths[] = {0, 0.01, 1, 1.5, 16}, usual[] = {1, 3, 4};
    for (int i = 0; i < 15; ++i) {
        fathom_settings settings = default_settings();
        pixel_filter f;
        settings.filter = filters[i % 3], settings.filter_width = widths[i / 3];
        filter_prepare(&settings, &f);
        if (i < 3) settings.filter_width = usual[i];
        double last = -1e9;
        for (int k = 0; k < 5000; ++k) {
            const double u = (k + 0.5) / 5000, place = filter_place(&f, u) - 0.5;
            assert_true(place > last && fabs(place) < settings.filter_width / 2);
            assert_near(part_before(settings.filter, settings.filter_width, place), u, tolerance);
            last = place;
        }
    }
}

/* The mean of a column. */
static double column(const float *pixels, int width, int x) {
    double sum = 0;
    for (int y = 0; y < width; ++y) sum += (double)pixels[y * width + x];
    return sum / width;
}

/* Between the middles of two pixels stands the edge of a bright half-plane, seen in parallel. */
UNIT_TEST(an_edge_is_as_wide_as_the_filter) {
    enum { WIDTH = 12, SAMPLES = 4096 };
    static const fathom_integrator integrators[] = {FATHOM_INTEGRATOR_CLASSIC, FATHOM_INTEGRATOR_PATH,
                                                    FATHOM_INTEGRATOR_REFERENCE};
    static const double edge = 0.25; /* from the image's middle, in pixels */
    for (int i = 0; i < 9; ++i) {
        const double width = i % 2 ? 4 : 1;
        stage s = stage_open(WIDTH, WIDTH);
        fathom_settings_set_integrator(&s.settings, integrators[i / 3]);
        s.settings.spp = SAMPLES, s.settings.target_error = 0;
        s.settings.filter = filters[i % 3], s.settings.filter_width = width;
        stage_quad(&s, (double[3]){edge - 20, 0, -1}, (double[3]){20, 0, 0}, (double[3]){0, 20, 0},
                   stage_emitter(&s, 1));
        assert_ok(s.context, fathom_scene_set_background(s.scene, (const float[3]){0, 0, 0}));
        fathom_camera camera = default_camera();
        camera.orthographic = true, camera.h = WIDTH;
        assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
        fathom_film *film = stage_render(&s);
        for (int x = 0; x < WIDTH; ++x) {
            const double want = part_before(s.settings.filter, width, edge - (x + 0.5 - WIDTH / 2.0));
            /* The samples of a pixel are divided into at least 2^6 columns of even samples: the edge crosses
             * one. The reference's are independent: 1/64 is 6.9 standard errors of a column's mean. */
            assert_near(column(fathom_film_channel(film, "R"), WIDTH, x), want, tolerance + 1.0 / 64);
        }
    }
}

/* By differences of places around the middle of each step, where the density is constant. */
UNIT_TEST(the_filters_density_is_that_of_its_places) {
    for (int k = 0; k < 3; ++k) {
        fathom_settings settings;
        pixel_filter f;
        fathom_settings_default(&settings);
        settings.filter = filters[k];
        filter_prepare(&settings, &f);
        for (int step = 0; step < FILTER_STEPS; ++step) {
            const double u = (step + 0.5) / FILTER_STEPS, h = 0.25 / FILTER_STEPS;
            const double slope = (filter_place(&f, u + h) - filter_place(&f, u - h)) / (2 * h);
            assert_near(filter_density(&f, filter_place(&f, u)) * slope, 1, 1e-9);
        }
        assert_true(filter_density(&f, filter_place(&f, 0) - 0.01) == 0);
        assert_true(filter_density(&f, filter_place(&f, 1 - 0x1p-30) + 0.01) == 0);
    }
}

int main(void) { return unit_main(NULL, NULL); }
