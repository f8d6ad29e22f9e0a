/* Laws of light from images around the scene. Statistical tests have fixed numbers and are made at 5 standard
 * errors (6e-7). */
#include "image/image.h"
#include "light/emitters.h"
#include "light/environment.h"
#include "math/lane.h"
#include "random.h"
#include "variants.h"
#include "worlds.h"

#include "unit_folder.h"

UNIT_OWNS(emitters, emitters, emitters_destroy)

VARIANTS(sky_kernels)

/* Blocks of sky.c have one cell or two either way. */
enum { WIDTH = 48, HEIGHT = 24, CELLS = WIDTH * (HEIGHT + 1), BLOCK_COLUMNS = 32, BLOCK_ROWS = 16 };

static const double errors = 5;

static float texels[HEIGHT * WIDTH][3];
static fathom_scene *scene;
static world *w;
static emitters *e;

static int begin(void **state) {
    (void)state;
    memset(texels, 0, sizeof texels);
    scene = new_scene(context);
    return 0;
}

static void write_sky(void) {
    const image_channel channels[3] = {{"R", IMAGE_FLOAT, true, &texels[0][0], 3 * sizeof(float)},
                                       {"G", IMAGE_FLOAT, true, &texels[0][1], 3 * sizeof(float)},
                                       {"B", IMAGE_FLOAT, true, &texels[0][2], 3 * sizeof(float)}};
    const image img = {WIDTH, HEIGHT, 0, 0, WIDTH, HEIGHT, channels, 3, NULL, 0, 0};
    assert_ok(context, exr_write_plain(context, &img, in_folder("sky.exr")));
}

static const double *sky_up; /* NULL: the default */

static void add_sky(double rotation) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr"), light.rotation = rotation;
    if (sky_up) memcpy(light.up, sky_up, sizeof light.up);
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
}

static void open_sky(double rotation) {
    write_sky();
    add_sky(rotation);
    w = new_world(scene);
    assert_ok(context, emitters_create(context, w, NULL, NULL, &e));
    own_emitters(e);
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

UNIT_TEST(a_constant_sky_sends_its_radiance) {
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

/* The first number's eighth alone decides between surfaces, the sky and suns: samples of a pixel that are a
 * net are nets in each of these, too. Returns the number of eighths that surfaces have. */
static int expect_eighths(void) {
    emitter_query q;
    emitter_sample s;
    _Alignas(64) lanes3 u;
    int count[EMITTER_PARTS] = {0};
    fill(&q, up);
    for (int eighth = 0; eighth < 8; ++eighth) {
        for (int i = 0; i < LANES; ++i)
            u[0][i] = ((float)eighth + (float)i / LANES) / 8, u[1][i] = u[2][i] = 0.5f;
        emitters_sample(e, &q, u, &s);
        for (int i = 0; i < LANES; ++i) {
            assert_true(s.density[i] > 0);
            assert_true(s.part[i] == s.part[0]);
            assert_true(isinf(s.distance[i]) == (s.part[i] != EMITTER_FINITE));
        }
        ++count[s.part[0]];
    }
    assert_true(count[EMITTER_OUTSIDE]);
    return count[EMITTER_FINITE];
}

static void add_ball(float emission) {
    fathom_material m = default_material();
    fathom_sphere ball = default_sphere();
    for (int c = 0; c < 3; ++c) m.k_e[c] = emission;
    assert_ok(context, fathom_scene_add_material(scene, NULL, &m, &ball.material));
    ball.center[1] = 3;
    assert_ok(context, fathom_scene_add_sphere(scene, FATHOM_ROOT, &ball, NULL));
}

static void add_sun(void) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_DIRECTIONAL, light.direction[1] = -1, light.direction[2] = 0;
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
}

/* Half of the samples of each class bring light: `finite` from surfaces, 1 from elsewhere. */
static void learn_glances(double finite) {
    enum { COUNT = 3000 };
    static emitter_glance glances[COUNT];
    random_state r = {5};
    emitters *scout;
    assert_true(emitters_scout(e, &scout) && scout);
    for (int k = 0; k < COUNT; ++k) {
        emitter_glance *g = &glances[k];
        *g = (emitter_glance){.direction = {0, 1, 0}, .density = 1, .part = (uint32_t)k % EMITTER_PARTS};
        for (int c = 0; c < 3; ++c) g->at[c] = (float)random_in(&r, -1, 1), g->at[3 + c] = c == 1;
        if (random_in(&r, 0, 1) < 0.5) g->light = g->part == EMITTER_FINITE ? (float)finite : 1;
    }
    const emitter_lesson lesson = {.by = scout, .seen = 1, .glances = glances, .glance_count = COUNT};
    assert_true(emitters_learn(e, &lesson));
    free(scout);
}

UNIT_TEST(eighths_of_the_numbers_take_one_kind_of_light_each) {
    for (int sun = 0; sun < 2; ++sun) {
        int eighths = 1;
        for (double finite = 0x1p-8; finite < 0x1p9; finite *= 2) {
            for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = 0.5f;
            add_ball(1);
            if (sun) add_sun();
            open_sky(0);
            learn_glances(finite);
            const int now = expect_eighths();
            assert_true(now >= eighths);
            if (finite == 0x1p-8) assert_int_equal(now, 1);
            eighths = now;
            begin(state);
        }
        assert_int_equal(eighths, sun ? 6 : 7);
    }
}

/* ---- cells between the centres of texels, as sky.h has them ---- */

static double row_cosine(int row) { return cos(M_PI * fmin(fmax(row - 0.5, 0), HEIGHT) / HEIGHT); }

static double solid_angle(int cell) {
    return (row_cosine(cell / WIDTH) - row_cosine(cell / WIDTH + 1)) * 2 * M_PI / WIDTH;
}

/* Channel c, so far from the corner at the upper left. */
static double radiance_in(int cell, double u, double v, int c) {
    const int x = cell % WIDTH, next = (x + 1) % WIDTH, y = cell / WIDTH, above = y ? y - 1 : 0,
              below = y < HEIGHT ? y : HEIGHT - 1;
    const double top = (1 - u) * (double)texels[above * WIDTH + x][c] +
                       u * (double)texels[above * WIDTH + next][c],
                 bottom = (1 - u) * (double)texels[below * WIDTH + x][c] +
                          u * (double)texels[below * WIDTH + next][c];
    return (1 - v) * top + v * bottom;
}

static double luminance_in(int cell, double u, double v) {
    return 0.2126 * radiance_in(cell, u, v, 0) + 0.7152 * radiance_in(cell, u, v, 1) +
           0.0722 * radiance_in(cell, u, v, 2);
}

static int cell_of(vec3_f64 d, double *u, double *v) {
    const double x = fmod((atan2(d.x, -d.z) / (2 * M_PI) + 1.5) * WIDTH - 0.5, WIDTH),
                 y = acos(fmin(fmax(d.y, -1), 1)) / M_PI * HEIGHT + 0.5;
    const int column = (int)fmin(x, WIDTH - 1), row = (int)fmin(y, HEIGHT);
    *u = x - column, *v = (row_cosine(row) - d.y) / (row_cosine(row) - row_cosine(row + 1));
    return row * WIDTH + column;
}

static vec3_f64 direction_in(int cell, double u, double v) {
    const double y = row_cosine(cell / WIDTH) * (1 - v) + row_cosine(cell / WIDTH + 1) * v,
                 turn = 2 * M_PI * ((cell % WIDTH + 0.5 + u) / WIDTH - 0.5), around = sqrt(1 - y * y);
    return vec_f64(around * sin(turn), y, -around * cos(turn));
}

/* Anywhere, poles and the seam at the back included; the program rounds directions to double alone. */
UNIT_TEST(radiance_is_interpolated) {
    random_state r = {13};
    environment *sky;
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_in(&r, 0, 2);
    write_sky();
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(context, environment_create(context, &light, &sky));
    for (int i = 0; i < CELLS * 4; ++i) {
        const double u = random_in(&r, 0, 1), v = random_in(&r, 0, 1);
        float found[3];
        environment_radiance(sky, direction_in(i % CELLS, u, v), found);
        for (int c = 0; c < 3; ++c) assert_near((double)found[c], radiance_in(i % CELLS, u, v, c), 1e-6);
    }
    environment_destroy(sky);
}

/* One bright texel: right of the centre and above the horizon, which is towards +x, -z and +y. A quarter
 * turn, counter-clockwise from above, takes +x to -z and -z to -x. Its light reaches the centres of the
 * texels around it, and is as strong as it is at its own. */
UNIT_TEST(an_image_lies_as_documented) {
    static const double ups[4][3] = {{0, 1, 0}, {0, 2, 0}, {0, 0, 3}, {0, -1, 0}};
    for (int turn = 0; turn < 4; ++turn) {
        float *bright = texels[(HEIGHT / 2 - 1) * WIDTH + WIDTH / 2];
        bright[0] = bright[1] = 7;
        sky_up = ups[turn];
        open_sky(turn == 1 ? M_PI / 2 : 0);
        sky_up = ups[0];
        random_state r = {2};
        emitter_sample s;
        draw(&r, nowhere, &s);
        const double step = M_PI / HEIGHT;
        /* The cosine is not quite linear in the height: off by step tan(step) / 8 of a cell, 0.015 of 7. */
        for (int i = 0; i < LANES; ++i) {
            vec3_f64 d = widen(lane(s.direction, i));
            if (turn == 2)
                d = vec_f64(d.x, d.z, -d.y); /* the image's top points along z, its centre along y */
            if (turn == 3) d = vec_f64(d.x, -d.y, -d.z);
            double right = turn == 1 ? -d.z : d.x, ahead = turn == 1 ? -d.x : -d.z;
            const double phi = atan2(right, ahead) - step / 2, height = asin(d.y) - step / 2;
            assert_true(fabs(phi) < step && fabs(height) < step);
            assert_near((double)s.radiance[0][i], 7 * (1 - fabs(phi) / step) * (1 - fabs(height) / step),
                        0.03);
            assert_true(s.radiance[2][i] == 0 && isinf(s.distance[i]) && s.sized[i]);
        }
        begin(state);
    }
}

/* Also where a background is added: then both send their light, and either is sampled. A direction in float
 * is off by 2^-24: some 2^-21 of a cell at the horizon either way, and more towards the poles, where cells
 * are narrower and lower in cosine by the sine of the angle to the pole. It changes radiance and density by
 * so much of its brightest corner, at most a hundred times as bright as the place. */
UNIT_TEST(samples_and_rays_that_leave_agree) {
    random_state r = {3};
    for (int with = 0; with < 2; ++with) {
        for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_log(&r, 0.1, 10);
        if (with) assert_ok(context, fathom_scene_set_background(scene, (float[3]){30, 20, 10}));
        open_sky(0.3);
        for (int b = 0; b < 500; ++b) {
            emitter_sample s;
            emitter_query q;
            lanes3 radiance;
            float density[LANES];
            draw(&r, up, &s);
            fill(&q, up);
            emitters_outside(e, (1u << LANES) - 1, q.p, q.n, s.direction, radiance, density);
            for (int i = 0; i < LANES; ++i) {
                const double off =
                    100 * 0x1p-20 / hypot((double)s.direction[0][i], (double)s.direction[2][i]);
                assert_near((double)density[i], (double)s.density[i], off * (double)s.density[i]);
                for (int c = 0; c < 3; ++c)
                    assert_near((double)radiance[c][i], (double)s.radiance[c][i],
                                off * (double)radiance[c][i]);
            }
        }
        begin(state);
    }
}

/* chi² over the quarters of cells, of which some at the poles are brighter. The mean of a bilinear function
 * over a quarter is its value at the middle. */
UNIT_TEST(places_are_taken_by_luminance_and_solid_angle) {
    random_state r = {4};
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        for (int c = 0; c < 3; ++c) texels[i][c] = (float)random_in(&r, 0.5, 2);
    }
    texels[3][1] = 20, texels[(HEIGHT - 1) * WIDTH + 5][1] = 20;
    open_sky(0);
    static double taken[CELLS][4], share[CELLS][4];
    double chi = 0, total = 0, used = 0;
    const int blocks = 200000, count = blocks * LANES;
    memset(taken, 0, sizeof taken);
    for (int b = 0; b < blocks; ++b) {
        emitter_sample s;
        draw(&r, nowhere, &s);
        for (int i = 0; i < LANES; ++i) {
            double u, v;
            const int cell = cell_of(widen(lane(s.direction, i)), &u, &v);
            ++taken[cell][2 * (v > 0.5) + (u > 0.5)];
        }
    }
    for (int i = 0; i < 4 * CELLS; ++i)
        total += share[i / 4][i % 4] =
            luminance_in(i / 4, i % 2 ? 0.75 : 0.25, i & 2 ? 0.75 : 0.25) * solid_angle(i / 4);
    for (int i = 0; i < 4 * CELLS; ++i) {
        const double expected = share[i / 4][i % 4] / total * count;
        assert_true(expected > 5); /* Cochran's rule */
        chi += pow(taken[i / 4][i % 4] - expected, 2) / expected, ++used;
    }
    const double k = used - 1, f = 2 / (9 * k);
    if (!(fabs((cbrt(chi / k) - (1 - f)) / sqrt(f)) < errors)) fail_msg("chi² %g of %g", chi, k);
}

static int block_row(int y) { return y * BLOCK_ROWS / (HEIGHT + 1); }
static int block_column(int x) { return x * BLOCK_COLUMNS / WIDTH; }

/* Sums of the light of cells: of all, of rows of blocks, of blocks, of rows within blocks, of each. */
typedef struct light_sums {
    double all, rows[BLOCK_ROWS], blocks[BLOCK_ROWS][BLOCK_COLUMNS], lines[HEIGHT + 1][BLOCK_COLUMNS],
        each[HEIGHT + 1][WIDTH];
} light_sums;

static void add_up(light_sums *s) {
    memset(s, 0, sizeof *s);
    for (int i = 0; i < CELLS; ++i) {
        const int x = i % WIDTH, y = i / WIDTH;
        const double light = s->each[y][x] = luminance_in(i, 0.5, 0.5) * solid_angle(i);
        s->lines[y][block_column(x)] += light, s->blocks[block_row(y)][block_column(x)] += light;
        s->rows[block_row(y)] += light, s->all += light;
    }
}

/* A cell takes a rectangle of the square of numbers. A grid of N x N numbers gives it a count as large as
 * its area, give or take one row and one column. An alias table, or any choice that does not keep order,
 * fails: its counts scatter by the root of the count. */
UNIT_TEST(even_numbers_are_even_over_the_light) {
    enum { N = 512 };
    random_state r = {9};
    static double taken[HEIGHT + 1][WIDTH];
    static light_sums s;
    fathom_light light = default_light();
    environment *sky;
    for (int i = 0; i < WIDTH * HEIGHT; ++i) texels[i][1] = (float)random_in(&r, 0.1, 2);
    write_sky();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr");
    assert_ok(context, environment_create(context, &light, &sky));
    for (int i = 0; i < N * N; ++i) {
        const float u[LANES] = {(float)((i % N + 0.5) / N)}, v[LANES] = {(float)((i / N + 0.5) / N)};
        const lanes3_f64 n = {{0}};
        const lanes3 p = {{0}};
        lanes3_f64 d;
        sky_light answer;
        environment_sample(sky, 1, p, n, u, v, d, &answer);
        double across, down;
        const int cell = cell_of(vec_f64(d[0][0], d[1][0], d[2][0]), &across, &down);
        ++taken[cell / WIDTH][cell % WIDTH];
    }
    add_up(&s);
    for (int y = 0; y <= HEIGHT; ++y) {
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

/* All densities add up to 1, and no cell that a normal faces is left out: over a cell the mean density is the
 * one in its middle. */
UNIT_TEST(a_surface_asks_all_that_it_faces) {
    random_state r = {11};
    for (int i = 0; i < WIDTH * HEIGHT * 3; ++i) texels[i / 3][i % 3] = (float)random_log(&r, 1e-3, 1e3);
    open_sky(0.7);
    for (int k = 0; k < 200; ++k) {
        const vec3_f64 n =
            normalize_f64(vec_f64(random_in(&r, -1, 1), random_in(&r, -1, 1), random_in(&r, -1, 1)));
        double whole = 0;
        emitter_query q;
        fill(&q, n);
        for (int i = 0; i < CELLS; i += LANES) {
            const int count = CELLS - i < LANES ? CELLS - i : LANES;
            lanes3 direction, radiance;
            float density[LANES];
            for (int j = 0; j < count; ++j) {
                const vec3_f64 d = direction_in(i + j, 0.5, 0.5);
                put_lane_f32(
                    direction, (unsigned)j,
                    narrow(vec_f64(d.x * cos(0.7) + d.z * sin(0.7), d.y, d.z * cos(0.7) - d.x * sin(0.7))));
            }
            emitters_outside(e, (1u << count) - 1, q.p, q.n, direction, radiance, density);
            for (int j = 0; j < count; ++j) {
                whole += (double)density[j] * solid_angle(i + j);
                assert_true(density[j] > 0 || !(dot_f64(n, widen(lane(direction, j))) > 0));
            }
        }
        assert_near(whole, 1, 1e-5); /* directions, texels and densities in float */
    }
}

/* ---- instruction sets ---- */

typedef struct answer {
    lanes3_f64 direction;
    sky_light sampled, seen;
} answer;

static void ask(const sky_kernels *k, const sky_image *s, unsigned lanes, uint64_t seed, answer *out) {
    random_state r = {seed};
    lanes3_f64 n, d;
    lanes3 p;
    float u[LANES], v[LANES];
    memset(out, 0, sizeof *out);
    for (unsigned i = 0; i < LANES; ++i) {
        const vec3_f64 any = {random_in(&r, -1, 1), random_in(&r, -1, 1), random_in(&r, -1, 1)};
        put_lane_f32(p, i, narrow(vec_f64(random_in(&r, -1, 1), random_in(&r, -1, 1), 0)));
        put_lane_f64(n, i, random_unit(&r) < 0.1 ? nowhere : normalize_f64(any));
        u[i] = (float)(random_bits(&r) >> 40) * 0x1p-24f, v[i] = (float)(random_bits(&r) >> 40) * 0x1p-24f;
        put_lane_f64(d, i, direction_in((int)(random_unit(&r) * CELLS), random_unit(&r), random_unit(&r)));
    }
    k->sample(s, lanes, p, n, u, v, out->direction, &out->sampled);
    k->at(s, lanes, p, n, d, &out->seen);
}

/* Points with x + y > 0 see the half of the sky with x > 0. */
static void teach(environment *sky) {
    enum { COUNT = 20000 };
    static sky_ray rays[COUNT];
    random_state r = {15};
    for (int i = 0; i < COUNT; ++i) {
        const vec3_f64 p = {random_in(&r, -1, 1), random_in(&r, -1, 1), 0},
                       d = direction_in((int)(random_unit(&r) * CELLS), random_unit(&r), random_unit(&r)),
                       n = normalize_f64(
                           vec_f64(random_in(&r, -1, 1), random_in(&r, -1, 1), random_in(&r, -1, 1)));
        rays[i] = (sky_ray){narrow(p), i % 4 ? narrow(i % 4 > 1 ? up : n) : narrow(nowhere), narrow(d),
                            p.x + p.y > 0 && d.x > 0};
    }
    assert_true(environment_learn(sky, rays, COUNT));
    assert_non_null(environment_sky(sky)->roots);
}

/* To the last bit, and they leave other lanes alone. Parts of the sky are black, and hidden from some points.
 */
UNIT_TEST(all_instruction_sets_ask_alike) {
    random_state r = {14};
    environment *sky;
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        for (int c = 0; c < 3; ++c)
            texels[i][c] = i % WIDTH < WIDTH / 3 ? 0 : (float)random_log(&r, 1e-3, 1e3);
    write_sky();
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = in_folder("sky.exr"), light.rotation = 0.3;
    assert_ok(context, environment_create(context, &light, &sky));
    teach(sky);
    for (unsigned k = 1; sky_kernels_at(k); ++k) {
        for (uint64_t trial = 1; trial <= 2000; ++trial) {
            const unsigned lanes = trial % 2 ? (unsigned)random_bits(&r) & 0xffff : 0xffff;
            answer plain, wide;
            ask(sky_kernels_at(0), environment_sky(sky), lanes, trial, &plain);
            ask(sky_kernels_at(k), environment_sky(sky), lanes, trial, &wide);
            assert_memory_equal(&plain, &wide, sizeof plain);
            for (unsigned i = 0; i < LANES; ++i)
                assert_true(lanes >> i & 1 || (wide.seen.density[i] == 0 && wide.direction[1][i] == 0));
        }
    }
    environment_destroy(sky);
}

/* A surface does not ask the sky clearly behind it. The samples of the light in front differ by the cosine
 * alone, which a block knows within the spread of its normals and texels. */
UNIT_TEST(light_behind_a_surface_is_not_asked) {
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

UNIT_TEST(a_texel_a_million_times_as_bright_is_met_by_its_share) {
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

UNIT_TEST(bad_texels_are_refused_with_their_place) {
    const float bad[2] = {NAN, INFINITY};
    for (int k = 0; k < 2; ++k) {
        texels[5 * WIDTH + 9][1] = bad[k];
        write_sky();
        add_sky(0);
        w = new_world(scene);
        assert_fails(context, emitters_create(context, w, NULL, NULL, &e), FATHOM_BAD_INPUT, "sky.exr");
        assert_non_null(strstr(fathom_context_message(context), "texel (9, 5)"));
        begin(state);
    }
    add_sky(0);
    w = new_world(scene);
    assert_fails(context, emitters_create(context, w, NULL, NULL, &e), FATHOM_BAD_INPUT, "sky.exr");
}

UNIT_TEST(an_environment_needs_a_file) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT;
    assert_fails(context, fathom_scene_add_light(scene, &light, NULL), FATHOM_BAD_INPUT, "file");
    light.file = in_folder("sky.exr"), light.rotation = NAN;
    assert_fails(context, fathom_scene_add_light(scene, &light, NULL), FATHOM_BAD_INPUT, "rotation");
    light.rotation = 0, light.up[1] = 0;
    assert_fails(context, fathom_scene_add_light(scene, &light, NULL), FATHOM_BAD_INPUT, "up: expected");
}

UNIT_TEST(another_image_is_another_scene) {
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
    scene->environments.items[0].up[0] = 1;
    assert_ok(context, scene_fingerprint(scene, &after));
    assert_true(before != after);
}

int main(void) {
    unit_each(begin, NULL);
    return unit_main(open_folder, remove_folder);
}
