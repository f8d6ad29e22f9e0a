/* Laws of light from images around the scene. Statistical tests have fixed numbers and are made at 5 standard
 * errors (6e-7). */
#include "image/image.h"
#include "light/emitters.h"
#include "light/environment.h"
#include "random.h"
#include "unit_folder.h"

/* Blocks of sky_choice.c have one texel or two either way. */
enum { WIDTH = 48, HEIGHT = 24, BLOCK_COLUMNS = 32, BLOCK_ROWS = 16 };

static const double errors = 5;

static float texels[HEIGHT * WIDTH][3];
static fathom_scene *scene;
static world *w;
static emitters *e;

static int begin(void **state) {
    (void)state;
    memset(texels, 0, sizeof texels);
    return fathom_scene_create(context, &scene) == FATHOM_OK ? 0 : -1;
}

static int end(void **state) {
    (void)state;
    emitters_destroy(e);
    world_destroy(w);
    fathom_scene_destroy(scene);
    e = NULL, w = NULL;
    unlink(in_folder("sky.exr"));
    return 0;
}

static void write_sky(void) {
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], 3 * sizeof(float)},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], 3 * sizeof(float)},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], 3 * sizeof(float)}};
    const image img = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, channels, 3, NULL, 0};
    assert_ok(context, exr_write_plain(context, &img, in_folder("sky.exr")));
}

static void add_sky(double rotation) {
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr"), light.rotation = rotation;
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
}

static void open_sky(double rotation) {
    write_sky();
    add_sky(rotation);
    assert_ok(context, world_create(scene, &w));
    assert_ok(context, emitters_create(context, w, NULL, NULL, &e));
}

static void fill(emitter_query *q, vec3_f64 n) {
    memset(q, 0, sizeof *q);
    for (int i = 0; i < LANES; ++i) q->n[0][i] = (float)n.x, q->n[1][i] = (float)n.y, q->n[2][i] = (float)n.z;
}

static void draw(random_state *r, vec3_f64 n, emitter_sample *out) {
    emitter_query q;
    lanes3 u;
    fill(&q, n);
    for (int c = 0; c < 3; ++c) {
        for (int i = 0; i < LANES; ++i) u[c][i] = (float)(random_bits(r) >> 40) * 0x1p-24f;
    }
    emitters_sample(e, &q, u, out);
}

static vec3_f32 lane(const lanes3 v, int i) { return vec_f32(v[0][i], v[1][i], v[2][i]); }

static const vec3_f64 up = {0, 1, 0}, nowhere = {0, 0, 0};

/* ---- laws ---- */

static void a_constant_sky_sends_its_radiance(void **state) {
    (void)state;
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = 0.5f;
    open_sky(1);
    random_state r = {1};
    double sum = 0, squares = 0;
    const int blocks = 4000, count = blocks * LANES;
    for (int b = 0; b < blocks; ++b) {
        emitter_sample s;
        draw(&r, up, &s);
        for (int i = 0; i < LANES; ++i) {
            double x = (double)s.radiance[0][i] * fmax((double)s.direction[1][i], 0) / (double)s.density[i];
            sum += x / M_PI, squares += x * x / (M_PI * M_PI);
        }
    }
    double mean = sum / count, error = sqrt((squares / count - mean * mean) / count);
    assert_near(mean, 0.5, errors * error);
}

/* One bright texel: right of the centre and above the horizon, which is towards +x, -z and +y. A quarter
 * turn, counter-clockwise from above, takes +x to -z and -z to -x. */
static void an_image_lies_as_documented(void **state) {
    (void)state;
    for (int turn = 0; turn < 2; ++turn) {
        float *bright = texels[(HEIGHT / 2 - 1) * WIDTH + WIDTH / 2];
        bright[0] = bright[1] = 7;
        open_sky(turn * M_PI / 2);
        random_state r = {2};
        emitter_sample s;
        draw(&r, nowhere, &s);
        for (int i = 0; i < LANES; ++i) {
            vec3_f64 d = widen(lane(s.direction, i));
            double right = turn ? -d.z : d.x, ahead = turn ? -d.x : -d.z;
            double phi = atan2(right, ahead), height = asin(d.y);
            assert_true(phi > 0 && phi < 2 * M_PI / WIDTH && height > 0 && height < M_PI / HEIGHT);
            assert_true(s.radiance[0][i] == 7 && s.radiance[2][i] == 0 && isinf(s.distance[i]) && s.sized[i]);
        }
        end(state), begin(state);
    }
}

/* Also where a background is added: then both send their light, and either is sampled. */
static void samples_and_rays_that_leave_agree(void **state) {
    random_state r = {3};
    for (int with = 0; with < 2; ++with) {
        for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_log(&r, 1e-4, 1e4);
        if (with) assert_ok(context, fathom_scene_set_background(scene, (float[3]){30, 20, 10}));
        open_sky(0.3);
        for (int b = 0; b < 500; ++b) {
            emitter_sample s;
            emitter_query q;
            lanes3 radiance;
            float density[LANES];
            draw(&r, up, &s);
            fill(&q, up);
            emitters_outside(e, (1u << LANES) - 1, q.n, s.direction, radiance, density);
            for (int i = 0; i < LANES; ++i) {
                assert_true(density[i] == s.density[i]);
                for (int c = 0; c < 3; ++c) assert_true(radiance[c][i] == s.radiance[c][i]);
            }
        }
        end(state), begin(state);
    }
}

/* chi² over the texels, of which some at the poles are brighter. */
static void texels_are_taken_by_luminance_and_solid_angle(void **state) {
    (void)state;
    random_state r = {4};
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        for (int c = 0; c < 3; ++c) texels[i][c] = (float)random_in(&r, 0.5, 2);
    }
    texels[3][1] = 1e2f, texels[(HEIGHT - 1) * WIDTH + 5][1] = 1e2f;
    open_sky(0);
    double taken[HEIGHT * WIDTH] = {0}, chi = 0, total = 0, share[HEIGHT * WIDTH];
    const int blocks = 60000, count = blocks * LANES;
    for (int b = 0; b < blocks; ++b) {
        emitter_sample s;
        draw(&r, nowhere, &s);
        for (int i = 0; i < LANES; ++i) {
            vec3_f64 d = widen(lane(s.direction, i));
            double x = (atan2(d.x, -d.z) / (2 * M_PI) + 0.5) * WIDTH, y = acos(d.y) / M_PI * HEIGHT;
            ++taken[(int)fmin(y, HEIGHT - 1) * WIDTH + (int)fmin(x, WIDTH - 1)];
        }
    }
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        const double y = i / WIDTH;
        double light =
            0.2126 * (double)texels[i][0] + 0.7152 * (double)texels[i][1] + 0.0722 * (double)texels[i][2];
        total += share[i] = light * (cos(M_PI * y / HEIGHT) - cos(M_PI * (y + 1) / HEIGHT));
    }
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        double expected = share[i] / total * count;
        assert_true(expected > 20);
        chi += pow(taken[i] - expected, 2) / expected;
    }
    const double k = WIDTH * HEIGHT - 1, f = 2 / (9 * k);
    assert_true(fabs((cbrt(chi / k) - (1 - f)) / sqrt(f)) < errors);
}

static int block_row(int y) { return y * BLOCK_ROWS / HEIGHT; }
static int block_column(int x) { return x * BLOCK_COLUMNS / WIDTH; }

/* Sums of the light of texels: of all, of rows of blocks, of blocks, of rows within blocks, of each. */
typedef struct light_sums {
    double all, rows[BLOCK_ROWS], blocks[BLOCK_ROWS][BLOCK_COLUMNS], lines[HEIGHT][BLOCK_COLUMNS],
        each[HEIGHT][WIDTH];
} light_sums;

static void add_up(light_sums *s) {
    memset(s, 0, sizeof *s);
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            const double angle = cos(M_PI * y / HEIGHT) - cos(M_PI * (y + 1.0) / HEIGHT);
            const double light = s->each[y][x] = (double)texels[y * WIDTH + x][1] * angle;
            s->lines[y][block_column(x)] += light, s->blocks[block_row(y)][block_column(x)] += light;
            s->rows[block_row(y)] += light, s->all += light;
        }
    }
}

/* A texel takes a rectangle of the square of numbers. A grid of N x N numbers gives it a count as large as
 * its area, give or take one row and one column. An alias table, or any choice that does not keep order,
 * fails: its counts scatter by the root of the count. */
static void even_numbers_are_even_over_the_light(void **state) {
    (void)state;
    enum { N = 512 };
    random_state r = {9};
    static double taken[HEIGHT][WIDTH];
    static light_sums s;
    fathom_light light;
    environment *sky;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) texels[i][1] = (float)random_in(&r, 0.1, 2);
    write_sky();
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(context, environment_create(context, &light, &sky));
    for (int i = 0; i < N * N; ++i) {
        const double u[LANES] = {(i % N + 0.5) / N}, v[LANES] = {(i / N + 0.5) / N};
        const lanes3_f64 n = {{0}};
        lanes3_f64 d;
        environment_light answer;
        environment_sample(sky, 1, n, u, v, d, &answer);
        const double x = (atan2(d[0][0], -d[2][0]) / (2 * M_PI) + 0.5) * WIDTH,
                     y = acos(d[1][0]) / M_PI * HEIGHT;
        ++taken[(int)fmin(y, HEIGHT - 1)][(int)fmin(x, WIDTH - 1)];
    }
    add_up(&s);
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            const int row = block_row(y), column = block_column(x);
            const double block = s.blocks[row][column], line = s.lines[y][column];
            const double high = N * s.rows[row] / s.all * line / block,
                         wide = N * block / s.rows[row] * s.each[y][x] / line;
            assert_true(fabs(taken[y][x] - high * wide) <= high + wide + 1);
        }
    }
    environment_destroy(sky);
}

/* All densities add up to 1, and no texel that a normal faces is left out. Over the samples of a normal,
 * light times cosine over density has the sum of all texels as its mean. */
static void a_surface_asks_all_that_it_faces(void **state) {
    (void)state;
    random_state r = {11};
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_log(&r, 1e-3, 1e3);
    open_sky(0.7);
    for (int k = 0; k < 200; ++k) {
        const vec3_f64 n =
            normalize_f64(vec_f64(random_in(&r, -1, 1), random_in(&r, -1, 1), random_in(&r, -1, 1)));
        double whole = 0;
        emitter_query q;
        fill(&q, n);
        for (int i = 0; i < WIDTH * HEIGHT; i += LANES) {
            lanes3 direction, radiance;
            float density[LANES];
            for (int j = 0; j < LANES; ++j) {
                const double v = M_PI * ((i + j) / WIDTH + 0.5) / HEIGHT,
                             u = 2 * M_PI * ((i + j) % WIDTH + 0.5) / WIDTH - 0.7;
                direction[0][j] = (float)(-sin(v) * sin(u)), direction[1][j] = (float)cos(v);
                direction[2][j] = (float)(sin(v) * cos(u));
            }
            emitters_outside(e, (1u << LANES) - 1, q.n, direction, radiance, density);
            for (int j = 0; j < LANES; ++j) {
                const double top = M_PI * ((i + j) / WIDTH) / HEIGHT;
                whole += (double)density[j] * (cos(top) - cos(top + M_PI / HEIGHT)) * 2 * M_PI / WIDTH;
                assert_true(density[j] > 0 || !(dot_f64(n, widen(lane(direction, j))) > 0));
            }
        }
        assert_near(whole, 1, 1e-5); /* texels and densities in float */
    }
}

/* A surface does not ask the sky clearly behind it. The samples of the light in front differ by the cosine
 * alone, which a block knows within the spread of its normals and texels. */
static void light_behind_a_surface_is_not_asked(void **state) {
    (void)state;
    random_state r = {12};
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        texels[i][0] = texels[i][1] = texels[i][2] = i < WIDTH * (HEIGHT * 5 / 8) ? 1 : 100;
    open_sky(0);
    double sum = 0, squares = 0;
    const int blocks = 2000, count = blocks * LANES;
    for (int b = 0; b < blocks; ++b) {
        emitter_sample s;
        draw(&r, up, &s);
        for (int i = 0; i < LANES; ++i) {
            const double x = s.density[i] > 0 ? (double)s.radiance[0][i] *
                                                    fmax((double)s.direction[1][i], 0) / (double)s.density[i]
                                              : 0;
            sum += x / M_PI, squares += x * x / (M_PI * M_PI);
        }
    }
    const double mean = sum / count, variance = squares / count - mean * mean;
    assert_near(mean, 1, errors * sqrt(variance / count));
    /* Without the choice by the normal some 98 of 100 samples fall behind, and the variance is above 50. */
    assert_true(variance < 0.5);
}

static void a_texel_a_million_times_as_bright_is_met_by_its_share(void **state) {
    (void)state;
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = 1;
    for (int c = 0; c < 3; ++c) texels[2 * WIDTH + 3][c] = 1e6f;
    open_sky(0);
    random_state r = {5};
    emitter_sample s;
    double least = INFINITY, most = 0;
    for (int b = 0; b < 100; ++b) {
        draw(&r, nowhere, &s);
        for (int i = 0; i < LANES; ++i) {
            double x = (double)s.radiance[0][i] / (double)s.density[i];
            least = fmin(least, x), most = fmax(most, x);
        }
    }
    /* Grey: each sample has the same, but for roundings of float. */
    assert_near(least, most, 1e-6 * most);
}

static void bad_texels_are_refused_with_their_place(void **state) {
    (void)state;
    const float bad[2] = {NAN, INFINITY};
    for (int k = 0; k < 2; ++k) {
        texels[5 * WIDTH + 9][1] = bad[k];
        write_sky();
        add_sky(0);
        assert_ok(context, world_create(scene, &w));
        assert_fails(context, emitters_create(context, w, NULL, NULL, &e), FATHOM_BAD_INPUT, "sky.exr");
        assert_non_null(strstr(fathom_context_message(context), "texel (9, 5)"));
        end(state), begin(state);
    }
    add_sky(0);
    assert_ok(context, world_create(scene, &w));
    assert_fails(context, emitters_create(context, w, NULL, NULL, &e), FATHOM_BAD_INPUT, "sky.exr");
}

static void an_environment_needs_a_file(void **state) {
    (void)state;
    fathom_light light;
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT;
    assert_fails(context, fathom_scene_add_light(scene, &light, NULL), FATHOM_BAD_INPUT, "file");
    light.file = in_folder("sky.exr"), light.rotation = NAN;
    assert_fails(context, fathom_scene_add_light(scene, &light, NULL), FATHOM_BAD_INPUT, "rotation");
}

static void another_image_is_another_scene(void **state) {
    (void)state;
    uint64_t before, after;
    write_sky();
    add_sky(0);
    assert_ok(context, scene_fingerprint(scene, &before));
    texels[5][0] = 1;
    write_sky();
    assert_ok(context, scene_fingerprint(scene, &after));
    assert_true(before != after);
    scene->environments.items[0].rotation = 1;
    assert_ok(context, scene_fingerprint(scene, &before));
    assert_true(before != after);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_constant_sky_sends_its_radiance, begin, end),
        cmocka_unit_test_setup_teardown(an_image_lies_as_documented, begin, end),
        cmocka_unit_test_setup_teardown(samples_and_rays_that_leave_agree, begin, end),
        cmocka_unit_test_setup_teardown(texels_are_taken_by_luminance_and_solid_angle, begin, end),
        cmocka_unit_test_setup_teardown(even_numbers_are_even_over_the_light, begin, end),
        cmocka_unit_test_setup_teardown(a_surface_asks_all_that_it_faces, begin, end),
        cmocka_unit_test_setup_teardown(light_behind_a_surface_is_not_asked, begin, end),
        cmocka_unit_test_setup_teardown(a_texel_a_million_times_as_bright_is_met_by_its_share, begin, end),
        cmocka_unit_test_setup_teardown(bad_texels_are_refused_with_their_place, begin, end),
        cmocka_unit_test_setup_teardown(an_environment_needs_a_file, begin, end),
        cmocka_unit_test_setup_teardown(another_image_is_another_scene, begin, end),
    };
    return cmocka_run_group_tests(tests, open_folder, remove_folder);
}
