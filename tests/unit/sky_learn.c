/* Sampling tables of skies, also of skies of which some surfaces see only a part. Statistical tests have
 * fixed numbers and are made at 5 standard errors (6e-7). */
#include "light/sky.h"
#include "math/lane.h"
#include "random.h"
#include "unit.h"

#include <stdlib.h>

enum { WIDTH = 64, HEIGHT = 32, RAYS = 1 << 16 };

#define BRIGHTEST 1e4f

static const vec3_f64 up = {0, 1, 0};

/* Noise, with a texel as bright as a sun towards the lower left. */
static void open_sky(sky_image *s) {
    random_state r = {1};
    *s = (sky_image){.width = WIDTH, .height = HEIGHT, .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    s->texels = malloc(WIDTH * HEIGHT * sizeof *s->texels);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        for (int c = 0; c < 3; ++c) s->texels[i].rgb[c] = (float)random_log(&r, 0.1, 10);
    s->texels[(HEIGHT / 2 - 2) * WIDTH + 20].rgb[1] = BRIGHTEST;
    assert_true(sky_open(s));
}

/* Points with x < 0 see the part of the sky with x < 0, others the part with x > 0. */
static bool sees(vec3_f64 p, vec3_f64 d) { return (p.x < 0) == (d.x < 0); }

static void learn(sky_image *s, bool hidden) {
    sky_ray *rays = unit_memory(RAYS * sizeof *rays);
    random_state r = {2};
    for (int i = 0; i < RAYS; ++i) {
        const vec3_f64 p = {random_in(&r, -3, 3), random_in(&r, -1, 1), random_in(&r, -1, 1)},
                       d = random_direction(&r);
        rays[i] = (sky_ray){narrow(p), narrow(up), narrow(d), !hidden || sees(p, d)};
    }
    assert_true(sky_learn(s, rays, RAYS));
}

static double density_at(const sky_image *s, vec3_f64 p, vec3_f64 n, vec3_f64 d) {
    const lanes3 from = {{(float)p.x}, {(float)p.y}, {(float)p.z}};
    const lanes3_f64 normal = {{n.x}, {n.y}, {n.z}}, direction = {{d.x}, {d.y}, {d.z}};
    sky_light out;
    sky_kernels_best()->at(s, 1, from, normal, direction, &out);
    return out.density[0];
}

/* slope: density divided by luminance. */
static vec3_f64 sample_at(const sky_image *s, random_state *r, vec3_f64 p, vec3_f64 n, double *density,
                          double *slope) {
    const lanes3 from = {{(float)p.x}, {(float)p.y}, {(float)p.z}};
    const lanes3_f64 normal = {{n.x}, {n.y}, {n.z}};
    const float u[LANES] = {(float)random_in(r, 0, 0.999)}, v[LANES] = {(float)random_in(r, 0, 0.999)};
    lanes3_f64 direction;
    sky_light out;
    sky_kernels_best()->sample(s, 1, from, normal, u, v, direction, &out);
    *density = out.density[0];
    *slope = out.density[0] / (0.2126 * (double)out.radiance[0][0] + 0.7152 * (double)out.radiance[1][0] +
                               0.0722 * (double)out.radiance[2][0]);
    return vec_f64(direction[0][0], direction[1][0], direction[2][0]);
}

static vec3_f64 any_point(random_state *r) {
    return vec_f64(random_in(r, -3, 3), random_in(r, -1, 1), random_in(r, -1, 1));
}

/* Without the hidden half, 24 of 25 samples would be wasted on the left: the bright texel is there. */
UNIT_TEST(samples_go_where_the_points_see) {
    sky_image s;
    random_state r = {3};
    open_sky(&s);
    learn(&s, true);
    int seen[2] = {0}, all[2] = {0};
    for (int i = 0; i < 20000; ++i) {
        double density, slope;
        const vec3_f64 p = any_point(&r), d = sample_at(&s, &r, p, up, &density, &slope);
        if (fabs(p.x) < 0.5) continue; /* regions may lie on both sides */
        ++all[p.x > 0], seen[p.x > 0] += sees(p, d);
    }
    for (int k = 0; k < 2; ++k)
        if (seen[k] < 0.85 * all[k]) fail_msg("%d of %d at %d", seen[k], all[k], k);
    sky_close(&s);
}

/* Samples keep 2^-22 of a radian from the edges of cells (sky_image.margin), across and along, where texels
 * may differ by the brightest one. */
UNIT_TEST(samples_have_the_density_of_their_direction) {
    sky_image s;
    random_state r = {4};
    open_sky(&s);
    learn(&s, true);
    for (int i = 0; i < 20000; ++i) {
        double density, slope;
        const vec3_f64 p = any_point(&r), n = i % 3 ? up : random_direction(&r),
                       d = sample_at(&s, &r, p, n, &density, &slope);
        assert_near(density_at(&s, p, n, d), density,
                    2 * 0x1p-22 * HEIGHT / M_PI * (slope * (double)BRIGHTEST + density));
    }
    sky_close(&s);
}

/* By the mean over even directions. The bright texel is left out, and checked by what samples take of it. */
UNIT_TEST(densities_of_a_point_add_up_to_one) {
    enum { COUNT = 25000 };
    sky_image s;
    random_state r = {5};
    open_sky(&s);
    learn(&s, true);
    for (int k = 0; k < 4; ++k) {
        const vec3_f64 p = {k < 2 ? -2.5 : 2.5, 0.5 - k % 2, 0};
        double sum = 0, squares = 0, inverse = 0, inverse_squares = 0;
        for (int i = 0; i < COUNT; ++i) {
            const vec3_f64 d = random_direction(&r);
            const double x = density_at(&s, p, up, d) * 4 * M_PI;
            if (x < 1000) sum += x, squares += x * x;
            double density, slope;
            sample_at(&s, &r, p, up, &density, &slope);
            const double y = density * 4 * M_PI < 1000;
            inverse += y, inverse_squares += y * y;
        }
        const double mean = sum / COUNT, taken = inverse / COUNT,
                     error = sqrt((squares / COUNT - mean * mean + inverse_squares / COUNT - taken * taken) /
                                  COUNT);
        assert_near(mean, taken, 5 * error);
    }
    sky_close(&s);
}

/* A twentieth of the samples: what no ray met is still found. */
UNIT_TEST(every_direction_keeps_a_twentieth) {
    sky_image s, plain;
    random_state r = {6};
    open_sky(&s), open_sky(&plain);
    learn(&s, true);
    for (int i = 0; i < 20000; ++i) {
        const vec3_f64 p = any_point(&r), d = random_direction(&r);
        assert_true(density_at(&s, p, up, d) >= 0.0499 * density_at(&plain, p, up, d));
    }
    sky_close(&s), sky_close(&plain);
}

/* The halves have luminances 1 and 3. A surface that faces up gets 1/4 and 3/4 of its light from them, and
 * scatters half of its rays to each. So 1/4 + (1/4 - 1/2)/2 of the light samples go to the dim half, and 3/4
 * + (3/4 - 1/2)/2 to the other: 7 times as many. */
UNIT_TEST(light_samples_leave_dim_parts_to_scattered_rays) {
    sky_image s = {.width = WIDTH, .height = HEIGHT, .axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
    s.texels = malloc(WIDTH * HEIGHT * sizeof *s.texels);
    for (int i = 0; i < WIDTH * HEIGHT; ++i)
        for (int c = 0; c < 3; ++c) s.texels[i].rgb[c] = i % WIDTH < WIDTH / 2 ? 1 : 3;
    assert_true(sky_open(&s));
    const vec3_f64 dim = {-0.6, 0.8, 0}, bright = {0.6, 0.8, 0};
    const double ratio = density_at(&s, up, up, bright) / density_at(&s, up, up, dim);
    assert_near(ratio, 7, 7 * 4 * 0x1p-24); /* scales and light are floats */
    sky_close(&s);
}

UNIT_TEST(a_sky_in_full_view_stays_as_it_is) {
    sky_image s;
    open_sky(&s);
    learn(&s, false);
    assert_null(s.roots);
    sky_close(&s);
}

int main(void) { return unit_main(NULL, NULL); }
