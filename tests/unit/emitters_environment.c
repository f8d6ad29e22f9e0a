/* Laws of light from images around the scene. Statistical tests have fixed numbers and are made at 5 standard
 * errors (6e-7). */
#include "image/image.h"
#include "light/emitters.h"
#include "light/environment.h"
#include "random.h"
#include "unit_folder.h"

enum { WIDTH = 16, HEIGHT = 8 };

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
            draw(&r, up, &s);
            for (int i = 0; i < LANES; ++i) {
                float radiance[3], density;
                emitters_outside(e, narrow(nowhere), narrow(up), lane(s.direction, i), radiance, &density);
                assert_true(density == s.density[i]);
                for (int c = 0; c < 3; ++c) assert_true(radiance[c] == s.radiance[c][i]);
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
    const int blocks = 6000, count = blocks * LANES;
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

/* A grid of N x N numbers gives a row of texels N times its share of them, give or take one, and a texel N
 * times its share of the row, give or take one, from each. An alias table, or any choice that does not keep
 * order, fails: its counts scatter by the root of the count, some 25. */
static void even_numbers_are_even_over_the_light(void **state) {
    (void)state;
    enum { N = 256 };
    random_state r = {9};
    double taken[HEIGHT][WIDTH] = {{0}}, share[HEIGHT][WIDTH], rows[HEIGHT] = {0}, total = 0;
    fathom_light light;
    environment *sky;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) texels[i][1] = (float)random_in(&r, 0.1, 2);
    write_sky();
    fathom_light_default(&light);
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(context, environment_create(context, &light, &sky));
    for (int i = 0; i < N * N; ++i) {
        const vec3_f64 d = environment_sample(sky, (i % N + 0.5) / N, (i / N + 0.5) / N);
        const double x = (atan2(d.x, -d.z) / (2 * M_PI) + 0.5) * WIDTH, y = acos(d.y) / M_PI * HEIGHT;
        ++taken[(int)fmin(y, HEIGHT - 1)][(int)fmin(x, WIDTH - 1)];
    }
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            const double angle = cos(M_PI * y / HEIGHT) - cos(M_PI * (y + 1.0) / HEIGHT);
            rows[y] += share[y][x] = (double)texels[y * WIDTH + x][1] * angle;
        }
        total += rows[y];
    }
    for (int y = 0; y < HEIGHT; ++y) {
        for (int x = 0; x < WIDTH; ++x) {
            const double of_rows = N * rows[y] / total, of_row = N * share[y][x] / rows[y];
            assert_true(fabs(taken[y][x] - of_rows * of_row) <= of_rows + of_row + 1);
        }
    }
    environment_destroy(sky);
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
        cmocka_unit_test_setup_teardown(a_texel_a_million_times_as_bright_is_met_by_its_share, begin, end),
        cmocka_unit_test_setup_teardown(bad_texels_are_refused_with_their_place, begin, end),
        cmocka_unit_test_setup_teardown(an_environment_needs_a_file, begin, end),
        cmocka_unit_test_setup_teardown(another_image_is_another_scene, begin, end),
    };
    return cmocka_run_group_tests(tests, open_folder, remove_folder);
}
