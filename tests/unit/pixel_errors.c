/* Stated errors of pixels, by made samples whose distributions are known. Intervals are counted over PIXELS
 * pixels, three channels and ROUNDS films: 196,608 values. These depend on each other through their squares'
 * means, so that the error of a share of them is taken from the spread of the films' shares, and a test
 * fails beyond 5 of that: 6e-7 by chance (normal, two-sided). */
#include "film/film.h"
#include "film/pixel_sums.h"

#include "random.h"
#include "render.h"

enum { SIDE = 64, PIXELS = SIDE * SIDE, ROUNDS = 16 };

/* The mean of a pixel's `count` samples around `truth`, all in the channel's group. */
typedef double (*draw)(random_state *r, double spread, uint32_t count);
typedef double (*spread_at)(uint32_t x, uint32_t y);

static double normal(random_state *r) {
    return sqrt(-2 * log(random_in(r, 0x1p-53, 1))) * cos(random_in(r, 0, 2 * M_PI));
}

static double draw_normal(random_state *r, double spread, uint32_t count) {
    return spread * normal(r) / sqrt(count);
}

/* Exponential, less its mean: a skewness of 2. */
static double draw_skewed(random_state *r, double spread, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i) sum -= log(random_in(r, 0x1p-53, 1)) + 1;
    return spread * sum / count;
}

/* A sample in 320 is bright: a pixel of 16 has a chance of 5 % to meet one. */
#define RARE (1 / 320.0)
static double draw_rare(random_state *r, double spread, uint32_t count) {
    double sum = 0;
    for (uint32_t i = 0; i < count; ++i)
        sum += (random_in(r, 0, 1) < RARE ? 1 : 0) - RARE + 0.001 * normal(r);
    return spread * sum / count;
}

static double flat(uint32_t x, uint32_t y) {
    (void)x, (void)y;
    return 0.05;
}

/* Far noisier on the right, with an edge through squares. */
static double stepped(uint32_t x, uint32_t y) {
    (void)y;
    return x < 34 ? 0.02 : 0.2;
}

/* One pixel in four three times as noisy, anywhere. */
static double mixed(uint32_t x, uint32_t y) { return (x * 7 + y * 13) % 16 < 4 ? 0.15 : 0.05; }

typedef struct subject {
    stage s;
    fathom_film *film;
    pixel_sums sums;
    random_state random;
} subject;

static subject *open_subject(void) {
    subject *u = test_calloc(1, sizeof *u);
    u->s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&u->s.settings, FATHOM_INTEGRATOR_PATH);
    u->s.settings.aovs = FATHOM_AOV_ERROR;
    u->random = (random_state){5};
    const sampler none = {.pattern = FATHOM_PATTERN_SOBOL};
    assert_true(pixel_sums_create(&none, SAMPLE_GROUPS, (film_parts){.hits = false}, &u->sums));
    return u;
}

static void close_subject(subject *u) {
    pixel_sums_destroy(&u->sums);
    test_free(u);
}

/* The truth of every pixel. */
#define TRUTH 2.0

static void draw_square(subject *u, const wave_region *r, const wave_square *q, uint32_t samples, draw one,
                        spread_at spread) {
    const uint32_t slot = wave_slot(q->left - r->left, q->top - r->top);
    for (uint32_t k = 0; k < LANES; ++k) {
        for (uint32_t g = 0; g < SAMPLE_GROUPS; ++g) {
            const uint32_t n = wave_group_count(samples, g, SAMPLE_GROUPS);
            for (int c = 0; c < 3; ++c) {
                const double off = one(&u->random, spread(q->left + k % 4, q->top + k / 4), n);
                u->sums.rgb[g][c][slot + k] = n * (TRUTH + off);
            }
        }
    }
    pixel_sums_store_square(&u->sums, r, q, (sums_count){samples, samples}, u->film);
}

/* A film of made pixels, whose errors are not settled yet. */
static void draw_film(subject *u, uint32_t samples, draw one, spread_at spread) {
    assert_ok(u->s.context, film_create(u->s.context, u->s.scene, &u->s.settings, &u->film));
    const wave_grid grid = film_waves(u->film);
    for (uint32_t i = 0; i < grid.count; ++i) {
        const wave_region r = wave_grid_region(&grid, i);
        wave_square squares[WAVE_SQUARES];
        const uint32_t count = wave_list_squares(&r, wave_region_bits(r), squares);
        for (uint32_t s = 0; s < count; ++s) draw_square(u, &r, &squares[s], samples, one, spread);
    }
}

/* ---- shares over films ---- */

typedef struct shares {
    double sum, squares;
    uint32_t films;
} shares;

static void add_share(shares *s, double share) {
    s->sum += share, s->squares += share * share;
    ++s->films;
}

static double mean_of(const shares *s) { return s->sum / s->films; }

static double error_of(const shares *s) {
    const double mean = mean_of(s);
    return sqrt(fmax(s->squares / s->films - mean * mean, 0) / (s->films - 1.0));
}

static bool holds(const fathom_film *film, int c, size_t i) {
    return fabs((double)film->rgb[c][i] - TRUTH) <= FILM_ERROR_T * (double)film->error[c][i];
}

typedef struct found {
    shares held, marked;
    double failed_marked, marks, failed_others, others;
} found;

static void count_film(const fathom_film *film, found *f) {
    double held = 0, marked = 0;
    for (size_t i = 0; i < PIXELS; ++i) {
        const bool mark = film->doubt[i] > FILM_DOUBTFUL;
        assert_true(film->doubt[i] < 1);
        for (int c = 0; c < 3; ++c) {
            const bool ok = holds(film, c, i);
            held += ok;
            if (mark)
                f->failed_marked += !ok, ++f->marks;
            else
                f->failed_others += !ok, ++f->others;
        }
        marked += mark;
    }
    add_share(&f->held, held / (3.0 * PIXELS));
    add_share(&f->marked, marked / PIXELS);
}

static found measure(uint32_t samples, draw one, spread_at spread) {
    found f = {.marks = 0};
    subject *u = open_subject();
    for (int round = 0; round < ROUNDS; ++round) {
        draw_film(u, samples, one, spread);
        film_settle_errors(u->film);
        count_film(u->film, &f);
        fathom_film_destroy(u->film);
    }
    close_subject(u);
    printf("held %.2f ± %.2f %%, marked %.2f ± %.2f %%, failed: marked %.1f %%, others %.1f %%\n",
           100 * mean_of(&f.held), 100 * error_of(&f.held), 100 * mean_of(&f.marked),
           100 * error_of(&f.marked), f.marks > 0 ? 100 * f.failed_marked / f.marks : 0,
           100 * f.failed_others / f.others);
    return f;
}

static void assert_holds(const found *f) {
    const double margin = 5 * error_of(&f->held);
    assert_true(mean_of(&f->held) > 0.94 - margin && mean_of(&f->held) < 0.96 + margin);
}

/* ---- laws ---- */

UNIT_TEST(intervals_of_flat_pixels_hold) {
    for (uint32_t samples = 16; samples <= 64; samples *= 4) {
        const found f = measure(samples, draw_normal, flat);
        assert_holds(&f);
    }
}

UNIT_TEST(intervals_at_edges_hold) {
    found f = measure(16, draw_normal, stepped);
    assert_holds(&f);
    f = measure(16, draw_normal, mixed);
    assert_holds(&f);
}

UNIT_TEST(intervals_of_skewed_pixels_hold) {
    const found f = measure(16, draw_skewed, flat);
    assert_holds(&f);
}

/* Pixels that met one fail, and few others do. Of normal pixels, the variance of one in 18,000 is 3.9 times
 * the stated one by chance (chi-squared, 9 degrees of freedom over three channels). More than 18 of the
 * 65,536 are a chance of 4e-8 (Poisson, a mean of 3.6). */
UNIT_TEST(rare_bright_samples_are_marked) {
    const found f = measure(16, draw_rare, flat);
    assert_holds(&f);
    assert_true(f.failed_marked / f.marks > 10 * f.failed_others / f.others);
    const found plain = measure(16, draw_normal, flat);
    assert_true(mean_of(&plain.marked) * ROUNDS * PIXELS < 18.5);
}

/* The estimate of the squared variance that tells pixels from noise: unbiased also where the samples are
 * skewed, and where the groups have 2, 2, 1 and 1 of them. */
UNIT_TEST(squared_variances_are_unbiased) {
    subject *u = open_subject();
    for (uint32_t samples = 6; samples <= 16; samples += 10) {
        shares estimates = {.films = 0};
        for (int round = 0; round < ROUNDS; ++round) {
            draw_film(u, samples, draw_skewed, flat);
            double sum = 0;
            for (size_t i = 0; i < PIXELS; ++i) {
                for (int c = 0; c < 3; ++c)
                    sum += FILM_ERROR_PRODUCTS * (double)u->film->doubt[i] *
                           pow((double)u->film->error[c][i], 4);
            }
            add_share(&estimates, sum / (3.0 * PIXELS));
            fathom_film_destroy(u->film);
        }
        const double truth = pow(flat(0, 0), 4) / (samples * samples);
        printf("%u samples: %.4f ± %.4f of the truth\n", samples, mean_of(&estimates) / truth,
               error_of(&estimates) / truth);
        assert_true(fabs(mean_of(&estimates) - truth) < 5 * error_of(&estimates));
        assert_true(error_of(&estimates) < 0.02 * truth);
    }
    close_subject(u);
}

/* The image's error is the mean over its pixels whatever they take from each other, and unbiased: nearby
 * pixels of other noise change nothing. The weight of a pixel is 1 / TRUTH², but for the noise of its grey:
 * 3 (0.2² / 48) / TRUTH², less than 0.1 %. */
UNIT_TEST(error_of_the_image_is_unbiased) {
    subject *u = open_subject();
    double truth = 0;
    shares errors = {.films = 0};
    for (uint32_t i = 0; i < PIXELS; ++i)
        truth += pow(stepped(i % SIDE, i / SIDE), 2) / (16 * TRUTH * TRUTH * PIXELS);
    for (int round = 0; round < ROUNDS; ++round) {
        film_error error;
        draw_film(u, 16, draw_normal, stepped);
        assert_false(film_error_of(u->film, &error));
        film_settle_errors(u->film);
        assert_true(film_error_of(u->film, &error));
        add_share(&errors, error.error * error.error);
        fathom_film_destroy(u->film);
    }
    printf("squared error of the image: %.4f ± %.4f of the truth\n", mean_of(&errors) / truth,
           error_of(&errors) / truth);
    assert_true(fabs(mean_of(&errors) - truth) < 5 * error_of(&errors) + 1e-3 * truth);
    close_subject(u);
}

/* ---- what is unseen ---- */

/* Two texels of an image in memory, of shared exponents (RGBE): 1 and 64. */
static fathom_id add_bright_texels(stage *s) {
    static const unsigned char bytes[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"
                                         "\x80\x80\x80\x81\x80\x80\x80\x87";
    fathom_texture t = default_texture();
    t.bytes = bytes, t.byte_count = sizeof bytes - 1, t.name = "bright.hdr";
    t.filter = FATHOM_TEXTURE_NEAREST;
    return new_texture(s->scene, &t);
}

/* The error of the green of the image's first pixel, which shows nothing but black. */
static double error_of_black(stage *s) {
    stage_camera(s, (double[]){0, 0, 1}, (double[]){0, 0, 2}, (double[]){0, 1, 0}, 1);
    assert_ok(s->context, fathom_scene_set_background(s->scene, (float[3]){0, 0, 0}));
    fathom_settings_set_integrator(&s->settings, FATHOM_INTEGRATOR_PATH);
    s->settings.target_error = 0, s->settings.spp = 16, s->settings.aovs = FATHOM_AOV_ERROR;
    fathom_film *film = stage_render(s);
    const double error = (double)fathom_film_channel(film, "error.G")[0];
    assert_true(fathom_film_channel(film, "error.doubt")[0] == 1);
    return error;
}

/* The rule of three, over 1.96; two roundings to float. */
static void assert_bounds(double error, double brightest) {
    const double expected = (1 - pow(0.05, 1 / 16.0)) * brightest / FILM_ERROR_T;
    assert_near(error, expected, 2 * 0x1p-24 * expected);
}

UNIT_TEST(black_pixels_know_the_brightest_texel_of_emission) {
    stage s = stage_open(8, 8);
    fathom_material m = default_material();
    m.k_e[0] = m.k_e[1] = m.k_e[2] = 2;
    m.maps[FATHOM_MAP_EMISSIVE].texture = add_bright_texels(&s);
    stage_quad(&s, (double[]){0, 0, 0}, (double[]){1, 0, 0}, (double[]){0, 1, 0}, stage_material(&s, &m));
    assert_bounds(error_of_black(&s), 128);
}

/* Of an unlit mesh, colours multiply the emission. */
UNIT_TEST(black_pixels_know_the_brightest_colour_of_emission) {
    static const float positions[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0}, colors[9] = {1, 1, 1, 1, 7, 1, 1, 1, 1};
    static const uint32_t indices[3] = {0, 1, 2};
    stage s = stage_open(8, 8);
    fathom_material m = default_material();
    fathom_mesh mesh = default_mesh();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.specular_factor = 0;
    for (int c = 0; c < 3; ++c) m.base_color[c] = 0, m.emissive[c] = 3;
    mesh.positions = positions, mesh.vertex_count = 3, mesh.indices = indices, mesh.triangle_count = 1;
    mesh.colors = colors, mesh.material = stage_material(&s, &m);
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
    assert_bounds(error_of_black(&s), 21);
}

int main(void) { return unit_main(NULL, NULL); }
