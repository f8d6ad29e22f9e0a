/* Rendering to an error or a time: what is promised of the error, and what may change no pixel. */
#include "job/render.h"

#include "random.h"
#include "render.h"

enum { WIDTH = 96, HEIGHT = 80, SIDE = 32 }; /* three waves across, two and a half down */

/* Edges of light, shadow and mirror images over a floor, and places without any. */
static void add_balls(stage *s) {
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.2f * (float)(c + 1), m.k_s[c] = 0.4f;
    m.specular = FATHOM_SPECULAR_BLINN, m.shininess = 200;
    fathom_id shiny = stage_material(s, &m);
    for (int c = 0; c < 3; ++c) m.k_r[c] = 0.7f;
    fathom_id mirror = stage_material(s, &m);
    stage_sphere(s, -0.9, 0.6, 0, 0.6, shiny);
    stage_sphere(s, 0.8, 0.7, -0.4, 0.7, mirror);
    stage_sphere(s, 0.3, 0.2, 1, 0.2, shiny);
}

/* A floor of thin bars: every pixel far off holds many edges. */
static void add_bars(stage *s) {
    fathom_id bar = stage_emitter(s, 0.8f);
    for (int i = 0; i < 40; ++i)
        stage_quad(s, (double[3]){0.2 * i - 4, 0, -3}, (double[3]){0.05, 0, 0}, (double[3]){0, 0, -4}, bar);
}

/* Small bright quads, from a tenth of a pixel to two pixels wide, a few in each wave: a sample seldom finds
 * them. */
static void add_stars(stage *s) {
    fathom_id bright = stage_emitter(s, 4), pale = stage_emitter(s, 0.5f);
    random_state r = {5};
    for (int i = 0; i < 60; ++i) {
        double half = random_log(&r, 0.003, 0.06);
        double center[3] = {random_in(&r, -3, 3), random_in(&r, -2, 3), -2};
        stage_quad(s, center, (double[3]){half, 0, 0}, (double[3]){0, half, 0}, i % 2 ? bright : pale);
    }
}

typedef enum subject { BALLS, BARS, DARK, STARS, SUBJECTS } subject;

static stage open_subject(subject which) {
    stage s = stage_open(WIDTH, HEIGHT);
    if (which == STARS) add_stars(&s);
    if (which == BALLS || which == DARK) add_balls(&s);
    if (which == BARS || which == DARK) add_bars(&s);
    if (which == BALLS || which == DARK)
        stage_plane(&s, (double[3]){0, -0.01, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.4f));
    stage_point_light(&s, -3, 4, 3, which == DARK ? 0.3f : 30);
    stage_camera(&s, (double[3]){0.4, 2, 5}, (double[3]){0, 0.4, 0}, (double[3]){0, 1, 0}, 0.6);
    if (which == STARS)
        assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0.01f, 0.01f, 0.02f}));
    if (which == BARS) assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0, 0.3f, 2}));
    s.settings.pattern = FATHOM_PATTERN_SOBOL;
    s.settings.spp = 1024;
    return s;
}

static const char *const names[3] = {"R", "G", "B"};

static fathom_film *render(stage *s, fathom_stats *stats) {
    fathom_film *film;
    assert_ok(s->context, fathom_render(s->context, s->scene, &s->settings, NULL, NULL, stats, &film));
    return own_film(film);
}

static size_t film_pixels(const fathom_film *film) {
    uint32_t width, height;
    fathom_film_size(film, &width, &height);
    return (size_t)width * height;
}

static void assert_same(const fathom_film *a, const fathom_film *b) {
    assert_int_equal(film_pixels(a), film_pixels(b));
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(fathom_film_channel(a, names[c]), fathom_film_channel(b, names[c]),
                            film_pixels(a) * sizeof(float));
    }
}

/* The unit of errors, as render.h states it, by the image that is held true. */
static double weight(const float *const rgb[3], size_t pixel) {
    double grey = ((double)rgb[0][pixel] + (double)rgb[1][pixel] + (double)rgb[2][pixel]) / 3;
    return grey < 1 ? 1 / fmax(grey, 0.01) : 1 / (grey * grey);
}

/* Mean squared error of a crop of the true image. */
static double true_error(const fathom_film *film, const fathom_film *truth, const uint32_t crop[4]) {
    const float *rgb[3];
    double sum = 0;
    uint32_t width = crop[2] - crop[0], height = crop[3] - crop[1];
    for (int c = 0; c < 3; ++c) rgb[c] = fathom_film_channel(truth, names[c]);
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            size_t at = (size_t)(y + crop[1]) * WIDTH + x + crop[0];
            for (int c = 0; c < 3; ++c) {
                double d =
                    (double)fathom_film_channel(film, names[c])[(size_t)y * width + x] - (double)rgb[c][at];
                sum += d * d * weight(rgb, at) / 3;
            }
        }
    }
    return sum / (width * height);
}

typedef struct tally {
    int waves, covered;
    double squares, estimates; /* sums of squared errors, true and estimated */
} tally;

/* Every wave by itself: its crop brings its own estimate. */
static void compare_waves(stage *s, const fathom_film *truth, tally *t) {
    for (uint32_t y = 0; y < HEIGHT; y += SIDE) {
        for (uint32_t x = 0; x < WIDTH; x += SIDE) {
            const uint32_t crop[4] = {x, y, x + SIDE, y + SIDE < HEIGHT ? y + SIDE : HEIGHT};
            memcpy(s->settings.crop, crop, sizeof crop);
            fathom_stats stats = {.size = sizeof stats};
            fathom_film *film = render(s, &stats);
            double error = true_error(film, truth, crop), estimate = stats.error_estimate;
            ++t->waves;
            t->covered += error <= 4 * estimate * estimate;
            t->squares += error;
            t->estimates += estimate * estimate;
        }
    }
    memset(s->settings.crop, 0, sizeof s->settings.crop);
}

/* The estimate of a wave, twice over, holds its true error in six of seven waves at least, and on the mean
 * estimate and error agree. Derived: with Σ(q - m)² / 12 of four independent groups, which is unbiased, and a
 * single pixel that has all the error, error over estimate is Student's t of 3 degrees of freedom, and
 * |t| > 2 has 13.9 %; more pixels only make it rarer (8: F(8, 24) > 4 has 0.4 %). Were all waves of that
 * kind, the mean squares of 54 would have F(54, 162): above 2, or below 1/2, in 0.1 % together. The true
 * image has 2048 samples a pixel and another seed: its error, along edges, is 1/13 of that of 64 samples. */
UNIT_TEST(estimate_covers_error) {
    /* Statistics of thousands of samples: minutes under sanitizers, which the other tests are for. */
#ifdef FATHOM_SANITIZED
    skip();
#endif
    const double targets[] = {0.03, 0.01};
    for (int which = 0; which < SUBJECTS; ++which) {
        stage s = open_subject((subject)which);
        s.settings.spp = 2048, s.settings.seed = 1000;
        fathom_film *truth = render(&s, NULL);
        tally t = {0};
        for (int i = 0; i < 2; ++i) {
            for (uint64_t seed = 0; seed < 3; ++seed) {
                s.settings.seed = seed, s.settings.target_error = targets[i];
                compare_waves(&s, truth, &t);
            }
        }
        printf("scene %d: %d of %d waves covered, true / estimated error %.3f\n", which, t.covered, t.waves,
               sqrt(t.squares / t.estimates));
        assert_true(7 * t.covered >= 6 * t.waves);
        assert_true(t.squares <= 2 * t.estimates && t.estimates <= 2 * t.squares);
    }
}

/* Decisions belong to waves: threads, tiles and block widths change no bit, nor what is counted. */
UNIT_TEST(same_bits_however_rendered) {
    stage s = open_subject(BALLS);
    s.settings.target_error = 0.01;
    s.settings.aovs = FATHOM_AOV_ALPHA | FATHOM_AOV_N | FATHOM_AOV_Z | FATHOM_AOV_SAMPLES;
    fathom_stats first_stats = {.size = sizeof first_stats}, stats = {.size = sizeof stats};
    fathom_film *first = render(&s, &first_stats);
    for (unsigned threads = 1; threads <= 7; threads += 2) {
        fathom_context_set_threads(s.context, threads);
        s.settings.tile_size = 32 * (1 + threads / 2);
        s.settings.block_width = 16 >> threads / 2 % 3;
        fathom_film *other = render(&s, &stats);
        assert_same(first, other);
        const char *more[] = {"A", "N.X", "Z"};
        for (int i = 0; i < 3; ++i) {
            assert_memory_equal(fathom_film_channel(first, more[i]), fathom_film_channel(other, more[i]),
                                WIDTH * HEIGHT * sizeof(float));
        }
        assert_int_equal(first_stats.samples, stats.samples);
        assert_true(first_stats.error_estimate == stats.error_estimate);
    }
}

/* A crop that cuts through waves shows what the whole shows. */
UNIT_TEST(crop_is_a_part) {
    stage s = open_subject(BALLS);
    s.settings.target_error = 0.01;
    fathom_film *whole = render(&s, NULL);
    const uint32_t crop[4] = {17, 5, 70, 71};
    memcpy(s.settings.crop, crop, sizeof crop);
    fathom_film *part = render(&s, NULL);
    for (uint32_t y = crop[1]; y < crop[3]; ++y) {
        assert_memory_equal(fathom_film_channel(part, "G") + (size_t)(y - crop[1]) * 53,
                            fathom_film_channel(whole, "G") + (size_t)y * WIDTH + crop[0],
                            53 * sizeof(float));
    }
}

/* A target below what floats can hold is never reached: then all pixels take the most samples. These are the
 * samples that every pixel of a path-traced image takes without a target if its errors are asked for. */
UNIT_TEST(no_error_is_all_samples) {
    stage s = open_subject(BARS);
    s.settings.integrator = FATHOM_INTEGRATOR_PATH;
    s.settings.spp = 32, s.settings.aovs = ~0u >> 24; /* all */
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *evenly = render(&s, NULL);
    s.settings.target_error = 1e-12;
    fathom_film *adaptive = render(&s, &stats);
    assert_same(evenly, adaptive);
    const char *more[] = {"A", "Z", "N.X", "P.Y", "albedo.G"};
    for (size_t i = 0; i < sizeof more / sizeof *more; ++i) {
        assert_memory_equal(fathom_film_channel(evenly, more[i]), fathom_film_channel(adaptive, more[i]),
                            WIDTH * HEIGHT * sizeof(float));
    }
    assert_memory_equal(fathom_film_channel_id(evenly, "samples"),
                        fathom_film_channel_id(adaptive, "samples"), WIDTH * HEIGHT * sizeof(uint32_t));
    assert_int_equal(stats.samples, 32 * WIDTH * HEIGHT);
    assert_true(stats.error_estimate > s.settings.target_error);
}

/* Samples go where edges are, and are counted: halves of powers of two from the least on. */
UNIT_TEST(samples_where_needed) {
    stage s = open_subject(BALLS);
    s.settings.target_error = 0.02, s.settings.min_spp = 16, s.settings.aovs = FATHOM_AOV_SAMPLES;
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *film = render(&s, &stats);
    const uint32_t *samples = fathom_film_channel_id(film, "samples");
    uint64_t sum = 0;
    size_t least = 0, more = 0;
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i) {
        assert_true(samples[i] >= 16 && samples[i] <= 1024 && __builtin_popcount(samples[i]) <= 2);
        sum += samples[i];
        least += samples[i] == 16, more += samples[i] > 16;
    }
    assert_int_equal(sum, stats.samples);
    assert_true(least > more && more > 100);
}

/* What is found in one square of a wave is looked for in all: none has more than four times the samples of
 * another. */
UNIT_TEST(samples_stay_near_each_other) {
    stage s = open_subject(STARS);
    s.settings.target_error = 0.01, s.settings.aovs = FATHOM_AOV_SAMPLES;
    fathom_film *film = render(&s, NULL);
    const uint32_t *samples = fathom_film_channel_id(film, "samples");
    uint32_t apart = 0;
    for (uint32_t w = 0; w < 9; ++w) {
        uint32_t least = UINT32_MAX, most = 0;
        for (uint32_t y = w / 3 * SIDE; y < w / 3 * SIDE + SIDE && y < HEIGHT; ++y) {
            for (uint32_t x = w % 3 * SIDE; x < w % 3 * SIDE + SIDE; ++x) {
                uint32_t here = samples[y * WIDTH + x];
                least = here < least ? here : least, most = here > most ? here : most;
            }
        }
        assert_true(most <= 4 * least);
        apart += most == 4 * least;
    }
    assert_true(apart > 3); /* it is not for want of anything to sample */
}

/* ---- the error of each pixel ---- */

/* Samples to an error state it for each pixel, even classic samples cannot. Where the image is black the
 * channel says what the brightest star could add unseen. */
UNIT_TEST(errors_are_stated) {
    stage s = open_subject(STARS);
    s.settings.spp = 64, s.settings.aovs = FATHOM_AOV_ERROR;
    fathom_film *film;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, "error needs the pattern sobol");
    s.settings.target_error = 0.05;
    film = render(&s, NULL);
    const float *error = fathom_film_channel(film, "error.G"),
                *doubt = fathom_film_channel(film, "error.doubt");
    uint32_t bounds = 0, estimates = 0;
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i) {
        assert_true(isfinite(error[i]) && error[i] >= 0 && doubt[i] >= 0 && doubt[i] <= 1);
        if (doubt[i] < 1) ++estimates;
        if (doubt[i] < 1) continue;
        ++bounds;
        /* From 4 to 64 samples: 1 - 0.05^(1/n) of a star of 4 over the background of 0.01, or over a pale
         * star of 0.5, over the normal quantile. */
        assert_true((double)error[i] < 0.5272 * 3.99 / 1.9599 && (double)error[i] > 0.0457 * 3.5 / 1.9600);
    }
    assert_true(bounds > estimates && estimates > 0);
}

/* ---- no bias ---- */

/* Quads of some share of a pixel, which face the camera, none over another: one to each square of 4 × 4. The
 * camera's pixels are 0.1 wide at distance 10. */
static void add_small_stars(stage *s, double share, float emission) {
    const fathom_id material = stage_emitter(s, emission);
    random_state r = {11};
    for (int i = 0; i < 64; ++i) {
        const double x = 0.1 * (i % 8 * 4 - 14 + random_in(&r, -1, 1)),
                     y = 0.1 * (i / 8 * 4 - 14 + random_in(&r, -1, 1)), half = 0.05 * sqrt(share);
        stage_quad(s, (double[3]){x, y, 0}, (double[3]){half, 0, 0}, (double[3]){0, half, 0}, material);
    }
}

static double mean_red(const fathom_film *film) {
    const float *red = fathom_film_channel(film, "R");
    double sum = 0;
    for (size_t i = 0; i < film_pixels(film); ++i) sum += (double)red[i];
    return sum / (double)film_pixels(film);
}

/* Student's t of the mean of the red of a wave of stars over seeds. Its true value is 64 shares of 1024
 * pixels. */
static double stars_t(double share, float emission, uint32_t seeds) {
    stage s = stage_open(32, 32);
    add_small_stars(&s, share, emission);
    stage_camera(&s, (double[3]){0, 0, 10}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 2 * atan(0.16));
    s.settings.pattern = FATHOM_PATTERN_SOBOL;
    s.settings.spp = 64, s.settings.target_error = 0.05;
    const double truth = 64 * share * (double)emission / 1024;
    double sum = 0, squares = 0;
    for (uint32_t seed = 0; seed < seeds; ++seed) {
        s.settings.seed = seed;
        fathom_film *film = render(&s, NULL);
        const double d = mean_red(film) - truth;
        sum += d, squares += d * d;
    }
    const double mean = sum / seeds, variance = (squares - sum * mean) / (seeds - 1);
    printf("stars of %g pixels: %.4f of their light, t = %.2f\n", share, 1 + mean / truth,
           mean / sqrt(variance / seeds));
    return mean / sqrt(variance / seeds);
}

/* Decisions by the samples that are in the image lose light: where the first samples miss, no more are
 * taken. Each case has |t| > 4 in less than 0.01 % at 255 degrees of freedom. */
UNIT_TEST(small_lights_lose_nothing) {
    if (SANITIZED) skip(); /* statistics, as those of estimate_covers_error */
    assert_true(fabs(stars_t(0.1, 4, 256)) < 4);
    assert_true(fabs(stars_t(0.01, 20, 256)) < 4);
    assert_true(fabs(stars_t(0.001, 100, 256)) < 4);
}

/* Light as strong as can be: squares of colours stay numbers, and sampling ends. */
UNIT_TEST(stays_finite) {
    stage s = open_subject(BALLS);
    stage_point_light(&s, 3, 4, 3, 3e38f);
    s.settings.target_error = 0.05, s.settings.spp = 16;
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *film = render(&s, &stats);
    assert_true(isfinite(stats.error_estimate) && stats.error_estimate > 0);
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i) assert_true(isfinite(fathom_film_channel(film, "R")[i]));
}

/* However little time there was, each pixel has a sample, and the estimate is told where there is one. A time
 * too short for that is refused. */
UNIT_TEST(to_a_time) {
    stage s = open_subject(BALLS);
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    s.settings.max_time = 1e-9;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, &stats, &film),
                 FATHOM_BAD_USAGE, "too short");
    s.settings.max_time = 0.5, s.settings.spp = 65536, s.settings.aovs = FATHOM_AOV_SAMPLES;
    film = render(&s, &stats);
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i) assert_true(fathom_film_channel_id(film, "samples")[i] >= 1);
    assert_true(stats.error_estimate > 0);
}

typedef struct asked {
    int times;
    double left, answer;
    bool all_sampled;
} asked;

static double ask(void *user, const fathom_film *film, double left) {
    asked *a = user;
    ++a->times, a->left = left, a->all_sampled = true;
    for (size_t i = 0; i < WIDTH * HEIGHT; ++i)
        a->all_sampled &= fathom_film_channel_id(film, "samples")[i] == 1;
    return a->answer;
}

/* What comes after rendering is asked for once, when each pixel has its first sample. All the time there is:
 * then that is the image. None: then rendering goes on. */
UNIT_TEST(leaves_time) {
    stage s = open_subject(BALLS);
    s.settings.max_time = 1000, s.settings.spp = 8, s.settings.aovs = FATHOM_AOV_SAMPLES;
    const double answers[] = {1e6, 0};
    for (int i = 0; i < 2; ++i) {
        asked a = {.answer = answers[i]};
        const job_reserve reserve = {ask, &a};
        const render_request request = {.reserve = &reserve};
        fathom_film *film;
        fathom_stats stats = {.size = sizeof stats};
        assert_ok(s.context, render_film(s.context, s.scene, &s.settings, &request, &stats, &film));
        assert_int_equal(a.times, 1);
        assert_true(a.all_sampled && a.left > 0 && a.left < 1000);
        assert_int_equal(stats.samples, WIDTH * HEIGHT * (i ? 8 : 1));
        fathom_film_destroy(film);
    }
}

/* With time to spare, rounds over all waves end at the target, or at the most samples, before it is up: at
 * the most samples everywhere it is the even image. */
UNIT_TEST(time_to_spare) {
    stage s = open_subject(BARS);
    fathom_stats stats = {.size = sizeof stats};
    s.settings.integrator = FATHOM_INTEGRATOR_PATH;
    s.settings.max_time = 1000, s.settings.target_error = 0.02, s.settings.aovs = FATHOM_AOV_ERROR;
    fathom_film *film = render(&s, &stats);
    assert_true(stats.samples < 1024 * WIDTH * HEIGHT);
    s.settings.target_error = 1e-12, s.settings.spp = 8;
    film = render(&s, &stats);
    s.settings.max_time = s.settings.target_error = 0;
    fathom_film *evenly = render(&s, NULL);
    assert_same(evenly, film);
}

static void refuse(fathom_settings settings, const char *text) {
    stage s = open_subject(BALLS);
    fathom_film *film;
    s.settings = settings;
    assert_fails(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_INPUT, text);
}

UNIT_TEST(bad_settings) {
    fathom_settings good = default_settings();
    good.pattern = FATHOM_PATTERN_SOBOL, good.spp = 64, good.target_error = 0.01;
    fathom_settings bad = good;
    bad.target_error = -0.01;
    refuse(bad, "target error: expected 0 or a number above 0");
    bad.target_error = (double)NAN;
    refuse(bad, "target error");
    bad = good, bad.max_time = (double)INFINITY;
    refuse(bad, "max time: expected 0 or a number above 0");
    bad = good, bad.pattern = FATHOM_PATTERN_GRID;
    refuse(bad, "needs the pattern sobol");
    bad = good, bad.spp = 100;
    refuse(bad, "power of two");
    bad = good, bad.min_spp = 128;
    refuse(bad, "min spp: expected a power of two from 4 to spp, which is 64, found 128");
    bad.min_spp = 5;
    refuse(bad, "min spp");
}

int main(void) { return unit_main(NULL, NULL); }
