/* The choice among many spot lights. Statistical tests are made once, with fixed numbers, at 5 standard
 * errors (6e-7). */
#include "light/emitters_inner.h"
#include "unit_light.h"

enum { COUNT = 200, BLOCKS = 4000 };

static fathom_light spot(vec3_f64 at, vec3_f64 direction, double outer) {
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_SPOT;
    store_f64(light.position, at), store_f64(light.direction, direction);
    light.outer_angle = (float)outer, light.inner_angle = (float)(outer / 2);
    for (int c = 0; c < 3; ++c) light.intensity[c] = 1;
    return light;
}

static void add(const fathom_light *light) { assert_ok(context, fathom_scene_add_light(scene, light, NULL)); }

/* Narrow, wide, and almost all directions; some are points. */
static fathom_light any_spot(random_state *r, int k) {
    fathom_light light = spot(vec_f64(random_in(r, -4, 4), random_in(r, -4, 4), random_in(r, -4, 4)),
                              random_direction(r), random_log(r, 1e-3, 1.55));
    if (k % 16 == 0) light.type = FATHOM_LIGHT_POINT;
    return light;
}

/* ---- irradiance over pi ---- */

/* KHR_lights_punctual, up to a sign. */
static double sent_by(const fathom_light *light, vec3_f64 p, vec3_f64 n) {
    const vec3_f64 to = sub_f64(load_f64(light->position), p), d = normalize_f64(to);
    const double inner = cos((double)light->inner_angle), outer = cos((double)light->outer_angle);
    const double along = -dot_f64(d, normalize_f64(load_f64(light->direction)));
    const double part = fmin(fmax((along - outer) / (inner - outer), 0), 1);
    const double falloff = light->type == FATHOM_LIGHT_SPOT ? part * part : 1;
    return falloff * fmax(dot_f64(n, d), 0) / dot_f64(to, to);
}

/* 1e-5: the falloff of narrow spots in float. */
UNIT_TEST(many_spots_send_the_sum_of_each) {
    random_state r = {7};
    fathom_light all[COUNT];
    for (int k = 0; k < COUNT; ++k) all[k] = any_spot(&r, k), add(&all[k]);
    open_light();
    for (int trial = 0; trial < 8; ++trial) {
        const vec3_f64 p = {random_in(&r, -4, 4), random_in(&r, -4, 4), random_in(&r, -4, 4)},
                       n = random_direction(&r);
        double expected = 0;
        for (int k = 0; k < COUNT; ++k) expected += sent_by(&all[k], p, n);
        const received got = receive(p, n, BLOCKS);
        assert_near(got.mean, expected, 5 * got.error + 1e-5 * expected);
    }
}

/* A ceiling of 400 spots, 1 apart and 3 above the floor: two or three light a point of the floor. Without
 * regard to their cones 95 % of the samples go to others. */
UNIT_TEST(spots_that_miss_a_point_take_few_samples) {
    for (int k = 0; k < 400; ++k) {
        const fathom_light light = spot(vec_f64(k % 20 - 9.7, k / 20 - 9.4, 3), vec_f64(0, 0, -1), 0.3);
        add(&light);
    }
    open_light();
    for (int k = 0; k < 4; ++k)
        assert_true(receive(vec_f64(k - 1.6, 0.9 - k, 0), vec_f64(0, 0, 1), BLOCKS).dark < 0.5);
}

/* From a distance of 1e10 times their extent, where squares of squares overflow. */
UNIT_TEST(a_far_cluster_sends_the_sum_of_its_lamps) {
    const vec3_f64 p = {0, 0, -1e4}, n = {0, 0, 1};
    double expected = 0;
    for (int k = 0; k < COUNT; ++k) {
        fathom_light light = spot(vec_f64(k % 4 * 2e-7, k / 4 * 2e-7, 0), vec_f64(0, 0, -1), 0.3);
        light.type = FATHOM_LIGHT_POINT;
        add(&light);
        expected += sent_by(&light, p, n);
    }
    open_light();
    /* All are chosen alike, so that no variance is left. */
    assert_near(receive(p, n, BLOCKS).mean, expected, 1e-5 * expected);
}

/* ---- bounds ---- */

/* Lamps with a radius are lit from all of their points. */
UNIT_TEST(a_spot_that_lights_a_point_has_a_chance) {
    random_state r = {11};
    const vec3_f32 both = {0, 0, 0};
    int lit = 0;
    for (int k = 0; k < COUNT; ++k) {
        fathom_light light = any_spot(&r, k);
        if (k % 2) light.radius = (float)random_log(&r, 1e-3, 2);
        add(&light);
    }
    open_light();
    for (int trial = 0; trial < 100000; ++trial) {
        const uint32_t k = (uint32_t)(trial % COUNT);
        const emitter_lamp *lamp = &e->lamps[k];
        const vec3_f64 from =
            madd_f64(widen(lamp->light.position), (double)lamp->radius, random_direction(&r));
        vec3_f64 way = neg_f64(widen(lamp->light.to_light));
        if (lamp->light.type == FATHOM_LIGHT_POINT) way = random_direction(&r);
        const double aside = random_log(&r, 1e-4, 1), length = random_log(&r, 1e-3, 10);
        way = normalize_f64(madd_f64(way, aside, random_direction(&r)));
        const vec3_f32 p = narrow(madd_f64(from, length, way)), to = narrow(neg_f64(way));
        if (lamp->light.type == FATHOM_LIGHT_SPOT && !(light_falloff(&lamp->light, to.x, to.y, to.z) > 0))
            continue;
        assert_true(tree_chance(&e->lights, p, both, NULL, e->slot_of[e->surface_count + k]) > 0);
        ++lit;
    }
    assert_true(lit > 10000);
}

int main(void) { return unit_main_each(begin_light, NULL); }
