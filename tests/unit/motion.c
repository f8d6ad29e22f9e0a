/* Motion: keys in parts and together, what tracers meet at a time, and what is refused. */
#include "scene/motion/motion.h"
#include "trace/trace.h"
#include "worlds.h"

#include "random.h"
#include "render.h"

static affine_f64 map_of(double angle, vec3_f64 axis, vec3_f64 shift, vec3_f64 scale) {
    const affine_f64 turn = affine_rotation_axis(axis, angle), stretch = affine_scaling(scale),
                     move = affine_translation(shift);
    const affine_f64 turned = affine_compose(&turn, &stretch);
    return affine_compose(&move, &turned);
}

/* Places `group` by two maps at times 0 and 1. */
static fathom_id place_moving(stage *s, fathom_id group, const affine_f64 *from, const affine_f64 *to) {
    const double times[2] = {0, 1};
    double maps[24];
    memcpy(maps, from->m, sizeof from->m);
    memcpy(maps + 12, to->m, sizeof to->m);
    fathom_instance instance = default_instance();
    fathom_id id;
    instance.group = group;
    instance.key_count = 2, instance.key_times = times, instance.key_transforms = maps;
    assert_ok(s->context, fathom_scene_add_instance(s->scene, &instance, &id));
    return id;
}

/* ---- parts ---- */

UNIT_TEST(a_map_taken_apart_and_put_together_is_the_map) {
    random_state r = {1};
    for (int k = 0; k < 1000; ++k) {
        affine_f64 map;
        for (int i = 0; i < 12; ++i) map.m[i / 4][i % 4] = random_in(&r, -1, 1);
        const motion_parts parts = motion_take_apart(&map);
        const affine_f64 made = motion_put_together(&parts);
        for (int i = 0; i < 12; ++i) assert_true(fabs(made.m[i / 4][i % 4] - map.m[i / 4][i % 4]) < 1e-12);
    }
}

UNIT_TEST(rotations_stay_rigid_and_evenly_fast_between_keys) {
    const vec3_f64 axis = {1, 2, -1}, none = {0, 0, 0}, one = {1, 1, 1};
    const affine_f64 from = map_of(0.2, axis, none, one), to = map_of(2.9, axis, none, one);
    const motion_parts a = motion_take_apart(&from), b = motion_take_apart(&to);
    for (int k = 0; k <= 10; ++k) {
        const motion_parts at = motion_between(&a, &b, k / 10.0);
        const affine_f64 made = motion_put_together(&at), expected = map_of(0.2 + 0.27 * k, axis, none, one);
        for (int i = 0; i < 12; ++i)
            assert_true(fabs(made.m[i / 4][i % 4] - expected.m[i / 4][i % 4]) < 1e-12);
    }
}

UNIT_TEST(halving_an_arc_is_slerp_to_the_last_bits) {
    for (int i = 0; i <= 100; ++i) {
        const double a[4] = {0, 0, 0, 2}, b[4] = {sin(1.4), 0, 0, cos(1.4)};
        double out[4];
        motion_slerp(a, b, i / 100.0, out);
        assert_near(out[0], sin(1.4 * i / 100), 4e-15);
        assert_near(out[3], cos(1.4 * i / 100), 4e-15);
    }
}

/* A box that turns, grows and moves between random keys. Its corners are below 12 from the pivot, and growth
 * moves them by less than 6. So a step of 2^-5 radians is allowed 2^-5 (2^-5 · 12 + 2 · 6) / 8 beyond its
 * chord; and between two looks a corner moves by less than 0.06. */
UNIT_TEST(bounds_hold_the_whole_way_between_keys) {
    const scene_bounds box = {{-1, -2, 0.5}, {3, 1, 4}};
    const double key_times[3] = {0, 1, 3}, shutter[2] = {0.25, 2.5};
    random_state r = {5};
    for (int i = 0; i < 50; ++i) {
        double maps[3][12];
        scene_bounds seen = bounds_empty();
        for (int k = 0; k < 3; ++k) {
            const vec3_f64 axis = {random_in(&r, -1, 1), random_in(&r, -1, 1), random_in(&r, 0.1, 1)},
                           shift = {random_in(&r, -5, 5), random_in(&r, -5, 5), random_in(&r, -5, 5)},
                           scale = {random_in(&r, 1, 2), random_in(&r, 1, 2), random_in(&r, 1, 2)};
            const affine_f64 map = map_of(random_in(&r, -3, 3), axis, shift, scale);
            memcpy(maps[k], map.m, sizeof map.m);
        }
        const fathom_instance instance = {.key_count = 3, .key_times = key_times, .key_transforms = maps[0]};
        const scene_bounds all = motion_bounds(&instance, shutter, &box);
        for (int k = 0; k <= 2000; ++k) {
            const affine_f64 map = motion_place(&instance, 0.25 + 2.25 * k / 2000);
            const scene_bounds there = bounds_transformed(&box, &map);
            bounds_join(&seen, &there);
        }
        const vec3_f64 below = sub_f64(seen.lower, all.lower), above = sub_f64(all.upper, seen.upper);
        const double most = 0x1p-5 * (0x1p-5 * 12 + 2 * 6) / 8 + 0.06;
        assert_true(below.x >= 0 && below.y >= 0 && below.z >= 0 && below.x < most && below.y < most &&
                    below.z < most);
        assert_true(above.x >= 0 && above.y >= 0 && above.z >= 0 && above.x < most && above.y < most &&
                    above.z < most);
    }
}

/* ---- what tracers meet ---- */

static void moving_vertices(stage *s) {
    const float from[] = {-1, -2, -1, 1, -2, -1, 0, -1, -1}, to[] = {-1, -2, 1, 2, -2, 1, 0, -0.5f, 0};
    float keys[18];
    memcpy(keys, from, sizeof from);
    memcpy(keys + 9, to, sizeof to);
    fathom_mesh mesh = default_mesh();
    mesh.positions = from, mesh.vertex_count = 3;
    mesh.indices = (const uint32_t[]){0, 1, 2}, mesh.triangle_count = 1;
    mesh.key_count = 2, mesh.key_times = (const double[]){0, 1}, mesh.key_positions = keys;
    assert_ok(s->context, fathom_scene_add_mesh(s->scene, FATHOM_ROOT, &mesh, NULL));
}

/* A ball of triangles that turns far and is stretched, a sphere that flies, a triangle whose corners move. */
static stage moving_stage(void) {
    stage s = stage_open(32, 32);
    const fathom_id ball = new_group(s.scene, NULL), sphere = new_group(s.scene, NULL);
    const vec3_f64 axis = {1, 1, 0.3}, still = {0, 0, 0}, one = {1, 1, 1}, wide = {1, 1.5, 0.7};
    const affine_f64 from = map_of(0, axis, still, one), to = map_of(2.5, axis, vec_f64(0.5, 0, 0), wide);
    const affine_f64 left = map_of(0, axis, vec_f64(-2, 2, 0), one),
                     right = map_of(0, axis, vec_f64(2, 2, 0), one);
    stage_mesh_sphere(&s, ball, 12, 16, 0);
    fathom_sphere round = default_sphere();
    round.radius = 0.5;
    assert_ok(s.context, fathom_scene_add_sphere(s.scene, sphere, &round, NULL));
    place_moving(&s, ball, &from, &to);
    place_moving(&s, sphere, &left, &right);
    moving_vertices(&s);
    stage_quad(&s, (double[3]){0, 0, -3}, (double[3]){4, 0, 0}, (double[3]){0, 4, 0}, 0);
    stage_shutter(&s, 0, 1);
    return s;
}

static trace_tracer *trace_by(const stage *s, const world *w, const char *words) {
    const trace_options options = {.words = words, .width = 16, .threads = 1, .timed = true};
    trace_tracer *tracer;
    assert_ok(s->context, trace_create(s->context, w, &options, &tracer));
    return tracer;
}

static void random_rays(random_state *r, trace_rays *rays) {
    memset(rays, 0, sizeof *rays);
    for (int i = 0; i < LANES; ++i) {
        rays->org_x[i] = (float)random_in(r, -3, 3), rays->org_y[i] = (float)random_in(r, -3, 3);
        rays->org_z[i] = 8;
        rays->dir_x[i] = (float)random_in(r, -0.2, 0.2), rays->dir_y[i] = (float)random_in(r, -0.2, 0.2);
        rays->dir_z[i] = -1;
        rays->t_far[i] = INFINITY;
        rays->time[i] = (float)random_unit(r);
    }
}

/* The speed at which a ray nears the surface that it met, in the space of the object: an error of place there
 * moves t by the error over this speed. */
static double nearing(const stage *s, const trace_block *b, int i) {
    const vec3_f64 normal = {b->hits.ng_x[i], b->hits.ng_y[i], b->hits.ng_z[i]};
    vec3_f64 way = {b->rays.dir_x[i], b->rays.dir_y[i], b->rays.dir_z[i]};
    if (b->hits.instance[i] != FATHOM_NONE) {
        const fathom_instance *instance = &s->scene->instances.items[b->hits.instance[i]];
        affine_f64 to_world = motion_place(instance, (double)b->rays.time[i]), to_object;
        assert_true(affine_invert(&to_world, &to_object));
        way = affine_vector(&to_object, way);
    }
    return fabs(dot_f64(normalize_f64(normal), way));
}

/* A ball of triangles turns by 540 degrees inside a group that is flat to a 50th. Where an axis of the ball
 * passes the flat one, the rotation of motion_take_apart() is 50 times as fast. */
static stage squashed_stage(void) {
    stage s = stage_open(32, 32);
    const fathom_id flat = new_group(s.scene, NULL), ball = new_group(s.scene, NULL);
    const vec3_f64 axis = {0, 0, 1}, still = {0, 0, 0}, one = {1, 1, 1};
    const affine_f64 squash = map_of(0, axis, still, vec_f64(1, 0.02, 1));
    double times[7], maps[7][12];
    for (int k = 0; k < 7; ++k) {
        const affine_f64 map = map_of(k * M_PI / 2, axis, still, one);
        memcpy(maps[k], map.m, sizeof maps[k]);
        times[k] = k / 6.0;
    }
    stage_mesh_sphere(&s, ball, 12, 16, 0);
    fathom_instance instance = default_instance();
    instance.group = flat;
    memcpy(instance.transform, squash.m, sizeof instance.transform);
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    instance = default_instance();
    instance.group = ball, instance.parent = flat;
    instance.key_count = 7, instance.key_times = times, instance.key_transforms = maps[0];
    assert_ok(s.context, fathom_scene_add_instance(s.scene, &instance, NULL));
    stage_shutter(&s, 0, 1);
    return s;
}

/* Embree interpolates places in float, the linear search in double: at most a few rays pass a rim by
 * rounding, and none is off by more than some roundings. */
UNIT_TEST(embree_meets_what_the_linear_search_meets_at_the_ray_s_time) {
    stage s = moving_stage();
    world *w = new_world(s.scene);
    assert_true(w->moves);
    trace_tracer *fast = trace_by(&s, w, "embree"), *slow = trace_by(&s, w, "linear:f32");
    random_state r = {7};
    int met[4] = {0}, differ = 0;
    double off = 0;
    for (int k = 0; k < 600; ++k) {
        trace_block a, b;
        random_rays(&r, &a.rays);
        b = a;
        const unsigned mode = trace_thread_begin();
        trace_closest(fast, &a, LANES, TRACE_INCOHERENT);
        trace_closest(slow, &b, LANES, TRACE_INCOHERENT);
        trace_thread_end(mode);
        for (int i = 0; i < LANES; ++i) {
            const bool both_missed = a.hits.geometry[i] == FATHOM_NONE && b.hits.geometry[i] == FATHOM_NONE;
            if (both_missed) continue;
            const bool same = a.hits.geometry[i] == b.hits.geometry[i] &&
                              a.hits.instance[i] == b.hits.instance[i] &&
                              a.hits.primitive[i] == b.hits.primitive[i];
            differ += !same;
            if (!same) continue;
            ++met[a.hits.instance[i] == FATHOM_NONE ? 2 + (int)(a.hits.geometry[i] & 1)
                                                    : (int)a.hits.instance[i]];
            off = fmax(off, fabs((double)a.rays.t_far[i] - (double)b.rays.t_far[i]) * nearing(&s, &b, i));
        }
    }
    for (int k = 0; k < 4; ++k) assert_true(met[k] > 50);
    assert_true(differ <= 2);
    /* About 16 roundings make the map of a time, move the ray and meet the triangle; all is within 9 units.
     */
    assert_true(off < 16 * 0x1p-24 * 9);
    trace_destroy(fast);
    trace_destroy(slow);
}

/* As above, by rays that meet the flat side almost straight on. */
UNIT_TEST(embree_meets_what_turns_in_a_squashed_group) {
    stage s = squashed_stage();
    world *w = new_world(s.scene);
    trace_tracer *fast = trace_by(&s, w, "embree"), *slow = trace_by(&s, w, "linear:f32");
    random_state r = {7};
    int met = 0, differ = 0;
    double off = 0;
    for (int k = 0; k < 300; ++k) {
        trace_block a, b;
        random_rays(&r, &a.rays);
        for (int i = 0; i < LANES; ++i) {
            a.rays.org_x[i] = (float)random_in(&r, -1, 1), a.rays.org_z[i] = (float)random_in(&r, -1, 1);
            a.rays.org_y[i] = 8, a.rays.dir_y[i] = -1, a.rays.dir_x[i] = a.rays.dir_z[i] = 0.01f;
        }
        b = a;
        const unsigned mode = trace_thread_begin();
        trace_closest(fast, &a, LANES, TRACE_INCOHERENT);
        trace_closest(slow, &b, LANES, TRACE_INCOHERENT);
        trace_thread_end(mode);
        for (int i = 0; i < LANES; ++i) {
            const bool same = a.hits.primitive[i] == b.hits.primitive[i];
            differ += !same;
            if (!same || b.hits.geometry[i] == FATHOM_NONE) continue;
            ++met;
            off = fmax(off, fabs((double)a.rays.t_far[i] - (double)b.rays.t_far[i]));
        }
    }
    assert_true(met > 3000);
    assert_true(differ <= 2);
    assert_true(off < 16 * 0x1p-24 * 9);
    trace_destroy(fast);
    trace_destroy(slow);
}

/* The vertices of a mesh that turns half around are as far from its centre at every time. */
UNIT_TEST(turning_meshes_stay_rigid) {
    stage s = stage_open(8, 8);
    const fathom_id ball = new_group(s.scene, NULL);
    const vec3_f64 axis = {1, 2, 3}, far = {100, 50, -20}, one = {1, 1, 1};
    const affine_f64 from = map_of(0, axis, far, one), to = map_of(3.1, axis, far, one);
    stage_mesh_sphere(&s, ball, 4, 6, 0);
    place_moving(&s, ball, &from, &to);
    stage_shutter(&s, 0, 1);
    world *w = new_world(s.scene);
    assert_int_equal(w->instances.count, 1);
    for (int k = 0; k <= 1000; ++k) {
        world_instance moved;
        const world_instance *at = world_instance_when(w, 0, (float)k / 1000, &moved);
        for (int i = 0; i < 3; ++i) {
            double square = 0;
            for (int c = 0; c < 3; ++c) square += pow((double)at->to_world[c][i], 2);
            assert_true(fabs(square - 1) < 4 * 0x1p-24);
        }
    }
}

/* ---- what is refused ---- */

static void assert_refused(const stage *s, fathom_status status, const char *what) {
    assert_int_not_equal(status, FATHOM_OK);
    const char *message = fathom_context_message(s->context);
    if (!strstr(message, what)) fail_msg("\"%s\" lacks \"%s\"", message, what);
}

UNIT_TEST(tracers_without_times_are_refused) {
    stage s = moving_stage();
    trace_tracer *tracer;
    world *w = new_world(s.scene);
    static const char *const words[] = {"bvh", "embree:user"};
    for (int k = 0; k < 2; ++k) {
        const trace_options options = {.words = words[k], .width = 16, .threads = 1, .timed = true};
        assert_refused(&s, trace_create(s.context, w, &options, &tracer), words[k]);
    }
    const trace_options options = {.words = "embree", .width = 16, .threads = 1};
    assert_refused(&s, trace_create(s.context, w, &options, &tracer), "shutter");
    fathom_film *film;
    assert_refused(&s, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, NULL, &film), "shutter");
}

UNIT_TEST(bad_keys_are_refused) {
    stage s = stage_open(8, 8);
    double maps[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    double times[2] = {1, 1};
    fathom_instance instance = default_instance();
    instance.group = new_group(s.scene, NULL);
    instance.key_count = 2, instance.key_times = times, instance.key_transforms = maps;
    assert_refused(&s, fathom_scene_add_instance(s.scene, &instance, NULL), "later than the one before");
    times[1] = 2, maps[12] = -1;
    assert_refused(&s, fathom_scene_add_instance(s.scene, &instance, NULL), "mirrors");
    maps[12] = 0;
    assert_refused(&s, fathom_scene_add_instance(s.scene, &instance, NULL), "flattens");
    instance.key_transforms = NULL;
    assert_refused(&s, fathom_scene_add_instance(s.scene, &instance, NULL), "key_transforms");
    fathom_camera camera = default_camera();
    camera.shutter[0] = 1;
    assert_refused(&s, fathom_scene_set_camera(s.scene, &camera), "shutter");
}

int main(void) { return unit_main(NULL, NULL); }
