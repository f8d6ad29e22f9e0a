/* The uniform steps of a world's motion against the keys of its scene. */
#include "scene/motion/motion.h"
#include "scene/world/world.h"
#include "worlds.h"

#include "render.h"

#include <string.h>

static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
static const uint32_t order[3] = {0, 1, 2};

static fathom_mesh triangle(void) {
    fathom_mesh mesh = default_mesh();
    mesh.positions = corners, mesh.vertex_count = 3;
    mesh.indices = order, mesh.triangle_count = 1;
    return mesh;
}

static void add_triangle(stage *s, fathom_id group) {
    const fathom_mesh mesh = triangle();
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, group, &mesh, NULL));
}

/* ---- instances ---- */

enum { KEYS = 5 };

/* Slides by these along x, with a scale. */
static void place_keys(stage *s, fathom_id parent, fathom_id group, const double *times, const double *x,
                       size_t count, double scale) {
    double maps[KEYS][12] = {{0}};
    for (size_t k = 0; k < count; ++k) maps[k][0] = maps[k][5] = maps[k][10] = scale, maps[k][3] = x[k];
    fathom_instance instance = default_instance();
    instance.parent = parent, instance.group = group;
    instance.key_count = (uint32_t)count, instance.key_times = times, instance.key_transforms = maps[0];
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
}

/* The jerk lies between two of the 64 times that each choice of steps is looked at, so only its key shows it.
 */
UNIT_TEST(a_jerk_between_two_keys_is_followed) {
    const double times[KEYS] = {0, 0.5, 0.5 + 1.0 / 128, 0.5 + 1.0 / 64, 1}, x[KEYS] = {0, 0, 1, 0, 0};
    stage s = stage_open(8, 8);
    const fathom_id group = new_group(s.scene, NULL);
    add_triangle(&s, group);
    place_keys(&s, FATHOM_ROOT, group, times, x, KEYS, 1);
    stage_shutter(&s, 0, 1);
    world *w = new_world(s.scene);
    assert_true(w->moves);
    for (int k = 0; k <= 1024; ++k) {
        world_instance moved;
        const double time = k / 1024.0;
        const world_instance *at = world_instance_when(w, 0, (float)time, &moved);
        const affine_f64 exact = motion_place(&s.scene->instances.items[0], time);
        /* A step at each key: places in float, near 1. */
        assert_near((double)at->to_world[0][3] + w->origin.x, exact.m[0][3], 4 * 0x1p-24);
    }
}

/* A triangle at the end of a lever that turns by `angle` about z. Returns the largest error at 999 times of
 * the shutter, which are none of those that choose the steps. */
static double turn_lever(stage *s, double lever, double angle) {
    const fathom_id arm = new_group(s->scene, NULL), body = new_group(s->scene, NULL);
    const double times[2] = {0, 1};
    const double keys[2][12] = {
        {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
        {cos(angle), -sin(angle), 0, 0, sin(angle), cos(angle), 0, 0, 0, 0, 1, 0},
    };
    add_triangle(s, body);
    place_keys(s, arm, body, times, &lever, 1, 1);
    fathom_instance instance = default_instance();
    instance.group = arm, instance.key_count = 2, instance.key_times = times;
    instance.key_transforms = keys[0];
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, NULL));
    stage_shutter(s, 0, 1);
    world *w = new_world(s->scene);
    assert_ok(s->context, world_check(w));
    double most = 0;
    for (int k = 1; k < 1000; ++k) {
        world_instance moved;
        const float time = (float)k / 1000;
        const world_instance *at = world_instance_when(w, 0, time, &moved);
        const double turn = (double)time * angle;
        most = fmax(most, hypot((double)at->to_world[0][3] + w->origin.x - lever * cos(turn),
                                (double)at->to_world[1][3] + w->origin.y - lever * sin(turn)));
    }
    return most;
}

static void keep_warning(void *user, const char *message) { snprintf(user, 300, "%s", message); }

/* 64 straight pieces of the arc would be off by 64 (1/256)^2 / 8 = 1.2e-4. Allowed are 2^-14 of the radius
 * sqrt(1/2) of the triangle's box, and 2^-21 of how far it is. */
UNIT_TEST(long_levers_turn_on_arcs) {
    char told[300] = "";
    stage s = stage_open(8, 8);
    fathom_context_on_warning(s.context, keep_warning, told);
    assert_true(turn_lever(&s, 64, 0.25) <= 0x1p-14 * sqrt(0.5) + 0x1p-21 * 65);
    assert_string_equal(told, "");
}

/* The error of 128 pieces of an arc: 4096 (0.8 / 128)^2 / 8 = 0.02. Places near 4096 are rounded by 2^-12. */
UNIT_TEST(levers_too_long_for_the_steps_are_told) {
    char told[300] = "";
    stage s = stage_open(8, 8);
    fathom_context_on_warning(s.context, keep_warning, told);
    assert_near(turn_lever(&s, 4096, 0.8), 0.02, 2 * 0x1p-12);
    assert_non_null(strstr(told, " moves along a curve that 128 straight pieces miss by up to 0.02"));
}

/* Each alone is fine. */
UNIT_TEST(nested_places_that_leave_the_range_of_float_are_refused) {
    const double times[2] = {0, 1}, x[2] = {0, 1e-30};
    stage s = stage_open(8, 8);
    const fathom_id outer = new_group(s.scene, NULL), inner = new_group(s.scene, NULL);
    add_triangle(&s, inner);
    place_keys(&s, outer, inner, times, x, 2, 1e-25);
    place_keys(&s, FATHOM_ROOT, outer, times, x, 2, 1e-25);
    stage_shutter(&s, 0, 1);
    world *w;
    assert_fails(s.context, world_create(s.scene, &w), FATHOM_BAD_INPUT,
                 "its frame, with those around it, flattens space or leaves the range of float");
}

/* ---- vertices ---- */

/* The normals of a surface that stands still turn from z to x to y. */
UNIT_TEST(normals_that_turn_alone_are_motion) {
    static const double times[3] = {0, 1, 2};
    float keys[27], normals[27] = {0};
    for (int k = 0; k < 3; ++k) {
        memcpy(keys + 9 * k, corners, sizeof corners);
        for (int i = 0; i < 3; ++i) normals[9 * k + 3 * i + (k + 2) % 3] = 1;
    }
    stage s = stage_open(8, 8);
    fathom_mesh mesh = triangle();
    mesh.normals = normals, mesh.normal_count = 3;
    mesh.key_count = 3, mesh.key_times = times, mesh.key_positions = keys, mesh.key_normals = normals;
    assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
    stage_shutter(&s, 0.5, 1.5);
    world *w = new_world(s.scene);
    assert_true(w->moves);
    for (int k = 0; k <= 8; ++k) {
        vec3_f32 corner[3], normal[3];
        world_corners_when(w, &w->geometries.items[0], 0, (float)k / 8, corner, normal);
        const double time = 0.5 + k / 8.0;
        for (int i = 0; i < 3; ++i) {
            assert_near(normal[i].z, fmax(1 - time, 0), 0x1p-24);
            assert_near(normal[i].x, 1 - fabs(1 - time), 0x1p-24);
            assert_near(normal[i].y, fmax(time - 1, 0), 0x1p-24);
        }
        assert_true(corner[1].x - corner[0].x == 1);
    }
}

/* Keys 0 to 1 move, 1 to 2 stand, 2 to 3 move. */
UNIT_TEST(vertices_that_stand_while_the_shutter_is_open_stand) {
    static const double shutters[][2] = {{1, 2}, {1.25, 1.5}, {0.5, 2}, {1, 2.5}, {0.5, 0.5}};
    for (size_t i = 0; i < sizeof shutters / sizeof *shutters; ++i) {
        static const float x[4] = {0, 2, 2, 8};
        float keys[36];
        for (int k = 0; k < 4; ++k) {
            memcpy(keys + 9 * k, corners, sizeof corners);
            for (int c = 0; c < 3; ++c) keys[9 * k + 3 * c] += x[k];
        }
        stage s = stage_open(8, 8);
        fathom_mesh mesh = triangle();
        mesh.key_count = 4, mesh.key_times = (const double[]){0, 1, 2, 3}, mesh.key_positions = keys;
        assert_ok(s.context, fathom_scene_add_mesh(s.scene, FATHOM_ROOT, &mesh, NULL));
        stage_shutter(&s, shutters[i][0], shutters[i][1]);
        world *w = new_world(s.scene);
        assert_int_equal(w->moves, i == 2 || i == 3);
        for (int k = 0; k <= 12; ++k) {
            vec3_f32 corner[3];
            const double time = shutters[i][0] + k / 12.0 * (shutters[i][1] - shutters[i][0]);
            const double expected = time < 1 ? 2 * time : time < 2 ? 2 : 2 + 6 * (time - 2);
            world_corners_when(w, &w->geometries.items[0], 0, (float)(k / 12.0), corner, NULL);
            assert_near((double)corner[0].x + w->origin.x, expected, 4 * 0x1p-22);
        }
    }
}

int main(void) { return unit_main(NULL, NULL); }
