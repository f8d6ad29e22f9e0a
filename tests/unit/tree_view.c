/* Views of the light tree: their lists give each light the probability with which it is chosen. */
#include "light/tree_view.h"
#include "math/lane.h"
#include "random.h"
#include "unit.h"

#include <string.h>

UNIT_OWNS(tree, tree, tree_destroy)
UNIT_OWNS(view, tree_view, tree_view_destroy)

enum { LIGHTS = 3000, NUMBERS = 1 << 14, POINTS = 400 };

typedef struct room {
    tree_item items[LIGHTS];
    uint32_t slot_of[LIGHTS];
    float points[POINTS][6];
    tree lights;
    tree_view view;
    random_state r;
} room;
static room s;

static void put(float to[3], vec3_f64 v) { store_f32(to, narrow(v)); }

/* Lights of all kinds. */
static tree_item any_light(uint32_t k, double distance) {
    const vec3_f64 at = scale_f64(distance, random_direction(&s.r));
    const double size = random_log(&s.r, 1e-3, 0.1) * distance;
    tree_item item = {.spread = 1, .power = (float)random_log(&s.r, 0.1, 10), .light = k};
    put(item.lower, at), put(item.upper, add_f64(at, (vec3_f64){size, size, size}));
    if (k % 3) put(item.axis, random_direction(&s.r));
    if (k % 3 == 2) item.beam = true, item.spread = (float)random_in(&s.r, 0.1, 0.99);
    return item;
}

/* A point of the region, a floor. */
static vec3_f32 any_point(void) {
    return (vec3_f32){(float)random_in(&s.r, -1, 1), 0, (float)random_in(&s.r, -1, 1)};
}

/* Ten lights at a distance, and the others much farther away. */
static void open_room(double near) {
    s = (room){.r = {7}};
    for (uint32_t k = 0; k < LIGHTS; ++k)
        s.items[k] = any_light(k, k < 10 ? near : near * random_log(&s.r, 10, 100));
    assert_true(tree_build(s.items, LIGHTS, &s.lights, s.slot_of));
    own_tree(&s.lights);
    for (int k = 0; k < POINTS; ++k) store_f32(s.points[k], any_point()), s.points[k][4] = 1;
    assert_true(tree_view_list(&s.lights, (const float(*)[6])s.points, POINTS, &s.view));
    own_view(&s.view);
}

/* How often numbers that divide [0, 1) evenly choose each light. */
static void count_choices(const tree_view *view, vec3_f32 p, vec3_f32 n, unsigned counts[LIGHTS]) {
    const tree_view *views[LANES];
    lanes3 at, normal;
    memset(counts, 0, LIGHTS * sizeof *counts);
    for (unsigned i = 0; i < LANES; ++i) {
        views[i] = view;
        put_lane_f32(at, i, p), put_lane_f32(normal, i, n);
    }
    for (int k = 0; k < NUMBERS; k += LANES) {
        double u[LANES], chance[LANES] = {0};
        uint32_t light[LANES];
        for (int i = 0; i < LANES; ++i) u[i] = (k + i + 0.5) / NUMBERS;
        s.lights.kernels->choose(&s.lights, at, normal, views, (1u << LANES) - 1, u, light, chance);
        for (int i = 0; i < LANES; ++i) {
            if (!(chance[i] > 0)) continue;
            ++counts[light[i]];
            assert_near(chance[i], tree_chance(&s.lights, p, n, view, s.slot_of[light[i]]), 1e-12);
        }
    }
}

/* Each light has one interval of u, so counts are off by less than 1, and by the roundings of u. */
static void expect_chances(const tree_view *view, vec3_f32 p, vec3_f32 n) {
    static unsigned counts[LIGHTS];
    count_choices(view, p, n, counts);
    for (uint32_t k = 0; k < LIGHTS; ++k)
        assert_near(counts[k], NUMBERS * tree_chance(&s.lights, p, n, view, s.slot_of[k]), 1.001);
}

UNIT_TEST(lights_are_chosen_with_their_probabilities) {
    open_room(3);
    assert_true(s.view.near_count > 0 && s.view.far_count > 0);
    for (int k = 0; k < 16; ++k) {
        const vec3_f32 p = any_point(), n = k % 4 ? narrow(random_direction(&s.r)) : (vec3_f32){0, 0, 0};
        assert_true(tree_view_holds(&s.view, p));
        expect_chances(k % 2 ? &s.view : NULL, p, n);
    }
}

/* Lights that reach a point keep a probability, also under normals that no point of the region has. */
UNIT_TEST(lists_hide_no_light) {
    open_room(3);
    assert_true(s.view.near_count > 0);
    for (int k = 0; k < 50; ++k) {
        const vec3_f32 p = any_point(), n = narrow(random_direction(&s.r));
        for (uint32_t i = 0; i < LIGHTS; ++i)
            if (tree_chance(&s.lights, p, n, NULL, s.slot_of[i]) > 0)
                assert_true(tree_chance(&s.lights, p, n, &s.view, s.slot_of[i]) > 0);
    }
}

UNIT_TEST(a_list_ends_with_its_box) {
    open_room(3);
    assert_true(s.view.near_count > 0);
    const vec3_f32 p = {1.5f, 0, 0}, n = {0, 1, 0};
    assert_false(tree_view_holds(&s.view, p));
    expect_chances(&s.view, p, n);
    for (uint32_t i = 0; i < LIGHTS; ++i)
        assert_true(tree_chance(&s.lights, p, n, &s.view, s.slot_of[i]) ==
                    tree_chance(&s.lights, p, n, NULL, s.slot_of[i]));
}

UNIT_TEST(lights_inside_a_region_need_cuts) {
    open_room(0.1);
    assert_int_equal(s.view.near_count, 0);
}

int main(void) { return unit_main(NULL, NULL); }
