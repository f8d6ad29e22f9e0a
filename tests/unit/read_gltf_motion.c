/* Animations of glTF while the shutter is open: keys against the still scenes of their times, and images
 * against the mean of still ones. */
#include "gltf_build.h"
#include "scene/motion/motion.h"
#include "stills.h"

#include <math.h>

#define TRIANGLE 0, 0, 0, 1, 0, 0, 0, 1, 0
#define FACING 0, 0, 1, 0, 0, 1, 0, 0, 1

static fathom_scene *read_blurred(double time, double shutter) {
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = time, asked.shutter = shutter;
    fathom_scene *scene = read_as(&asked);
    return scene;
}

/* A node with a triangle, a lamp or both, one channel, and a camera. */
static void write_channel(build *b, const char *path, const char *way, const char *more, int input,
                          int output) {
    const int positions = PUT_FLOATS(b, "VEC3", 3, TRIANGLE);
    build_write(
        b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'cameras':[{'type':'perspective',"
        "'perspective':{'yfov':1}}],'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},"
        "'nodes':[{'name':'it','mesh':0%s}],'animations':[{'samplers':[{'input':%d,'output':%d,"
        "'interpolation':'%s'}],'channels':[{'sampler':0,'target':{'node':0,'path':'%s'}}]}]",
        positions, more, input, output, way, path);
}

UNIT_TEST(an_even_slide_is_two_keys) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 0, 4), values = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 8, 0, 0);
    write_channel(&b, "translation", "LINEAR", "", times, values);
    fathom_scene *scene = read_blurred(1, 0.5);
    const fathom_instance *it = &scene->instances.items[0];
    assert_int_equal(warning_count, 0);
    assert_int_equal(it->key_count, 2);
    const double expected[2][2] = {{1, 2}, {1.5, 3}};
    for (int k = 0; k < 2; ++k) {
        assert_true(it->key_times[k] == expected[k][0] && it->key_transforms[12 * k + 3] == expected[k][1]);
        assert_true(scene->camera.shutter[k] == expected[k][0]);
    }
    scene = read_blurred(4, 1); /* it rests */
    assert_int_equal(scene->instances.items[0].key_count, 0);
}

/* A turn, a spline and a kink: at keys the very places of the still scene, between them off by no more than
 * twice 2^-8 of the way (twice: poses are compared at twice the keys, and a kink may lie between those). */
UNIT_TEST(keys_follow_the_stills) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), kinks = PUT_FLOATS(&b, "SCALAR", 3, 0, 0.3f, 1),
              turns = PUT_FLOATS(&b, "VEC4", 2, 0, 0, 0, 1, 0, 0, 0.9f, 0.435889f),
              spline = PUT_FLOATS(&b, "VEC3", 6, 0, 0, 0, 1, 0, 0, 3, 0, 0, -1, 9, 0, 5, 0, 0, 0, 0, 0),
              kinked = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 4, 0, 0, 4, 3, 0);
    const struct {
        const char *path, *way;
        int input, output;
    } cases[] = {{"rotation", "LINEAR", times, turns},
                 {"translation", "CUBICSPLINE", times, spline},
                 {"translation", "LINEAR", kinks, kinked}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        build own = b;
        write_channel(&own, cases[i].path, cases[i].way, ",'camera':0", cases[i].input, cases[i].output);
        fathom_scene *moving = read_blurred(0, 1);
        const fathom_instance *it = &moving->instances.items[0];
        assert_in_range(it->key_count, 3, 65);
        assert_int_equal(moving->camera.key_count, it->key_count);
        for (int k = 0; k <= 256; ++k) {
            fathom_scene *still = read_at(k / 256.0);
            const affine_f64 there = motion_place(it, k / 256.0);
            const fathom_camera camera = motion_camera(&moving->camera, k / 256.0);
            const bool at_key = (unsigned)k * (it->key_count - 1) % 256 == 0;
            for (int e = 0; e < 12; ++e)
                assert_near(there.m[e / 4][e % 4], still->instances.items[0].transform[e],
                            at_key ? 0 : 2 * 6 * 0x1p-8);
            for (int c = 0; c < 3; ++c)
                assert_near(camera.origin[c], still->camera.origin[c], at_key ? 0 : 2 * 6 * 0x1p-8);
        }
    }
}

/* A triangle turns by 60 degrees inside a parent that is flat to a tenth: off by no more than twice 2^-8 of
 * its way, as above, which is 1. */
UNIT_TEST(keys_follow_the_stills_in_a_squashed_parent) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE), times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1),
              turns = PUT_FLOATS(&b, "VEC4", 2, 0, 0, 0.6087614f, 0.7933533f, 0, 0, 0.7933533f, 0.6087614f);
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[{'scale':[1,0.1,1],"
                "'children':[1]},{'mesh':0}],'scenes':[{'nodes':[0]}],'animations':[{'samplers':[{'input':%d,"
                "'output':%d}],'channels':[{'sampler':0,'target':{'node':1,'path':'rotation'}}]}]",
                positions, times, turns);
    fathom_scene *moving = read_blurred(0, 1);
    assert_int_equal(warning_count, 0);
    for (int k = 0; k <= 256; ++k) {
        const fathom_scene *still = read_at(k / 256.0);
        const affine_f64 there = motion_place(&moving->instances.items[0], k / 256.0);
        for (int e = 0; e < 12; ++e)
            assert_near(there.m[e / 4][e % 4], still->instances.items[0].transform[e], 2 * 0.6 * 0x1p-8);
    }
}

/* A slide begins at a quarter of the shutter time, between two of the 64 poses. Straight between these, it is
 * off by a quarter of the way from one to the next at most. */
UNIT_TEST(motion_may_begin_while_the_shutter_is_open) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 0.26f, 1),
              values = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 1, 0, 0);
    write_channel(&b, "translation", "LINEAR", "", times, values);
    fathom_scene *moving = read_blurred(0, 1);
    assert_int_equal(warning_count, 0);
    for (int k = 0; k <= 256; ++k) {
        const double x = motion_place(&moving->instances.items[0], k / 256.0).m[0][3];
        assert_near(x, fmax(k / 256.0 - 0.26, 0) / 0.74, 0.25 / (0.74 * 64) + 1e-7);
    }
}

/* Eight turns in 24 keys: at each eighth of the time it is back where it was. */
UNIT_TEST(a_wheel_does_not_seem_to_stand) {
    build b = {.size = 0};
    float at[25], turns[25][4] = {{0}};
    for (int k = 0; k < 25; ++k) {
        at[k] = (float)k / 24;
        turns[k][2] = (float)sin(k * 3.14159265358979 / 3),
        turns[k][3] = (float)cos(k * 3.14159265358979 / 3);
    }
    const int times = put_typed(&b, 5126, "SCALAR", 25, at, sizeof at, ""),
              values = put_typed(&b, 5126, "VEC4", 25, turns, sizeof turns, "");
    write_channel(&b, "rotation", "LINEAR", "", times, values);
    fathom_scene *scene = read_blurred(0, 1);
    assert_true(scene->instances.items[0].key_count > 24);
}

/* Its axle moves only by the rounding of the quaternions, with a kink at the second key. The shutter takes in
 * a turn by 98 degrees, which 8 chords approximate to 2^-8 of the way; poses are compared at twice the keys.
 */
UNIT_TEST(a_tilted_wheel_needs_few_keys) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 3, 10 / 24.f, 11 / 24.f, 0.5f),
              turns = PUT_FLOATS(&b, "VEC4", 3, 0.281712025f, -0.648566365f, 0.648566365f, 0.281712025f,
                                 0.586817443f, -0.394519061f, 0.39451912f, 0.586817443f, 0.706923604f,
                                 -0.0160958841f, 0.016095886f, 0.706923544f);
    write_channel(&b, "rotation", "LINEAR", "", times, turns);
    fathom_scene *scene = read_blurred(10 / 24.0, 1.5 / 24);
    assert_int_equal(warning_count, 0);
    assert_in_range(scene->instances.items[0].key_count, 9, 17);
}

/* ---- vertices ---- */

/* A triangle with two morph targets whose weights change, and a skin of two joints, of which one turns. */
static void write_figure(void) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE), normals = PUT_FLOATS(&b, "VEC3", 3, FACING),
              target = PUT_FLOATS(&b, "VEC3", 3, 0, 0, 0, 0.5f, 0, 0.25f, 0, 0, 0),
              joints = PUT_BYTES(&b, "VEC4", 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0),
              weights = PUT_FLOATS(&b, "VEC4", 3, 1, 0, 0, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 2), morphs = PUT_FLOATS(&b, "SCALAR", 2, 0, 1),
              turns = PUT_FLOATS(&b, "VEC4", 2, 0, 0, 0, 1, 0, 0.5f, 0, 0.8660254f);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d,'JOINTS_0':%d,'WEIGHTS_0':%d},"
        "'targets':[{'POSITION':%d,'NORMAL':%d}]}]}],'skins':[{'joints':[1,2]}],'cameras':[{'type':"
        "'perspective','perspective':{'yfov':0.7}}],'nodes':[{'mesh':0,'skin':0},{'translation':[-1,0,0]},"
        "{'translation':[0,-0.5,0]},{'camera':0,'translation':[0,0,4],'extensions':{'KHR_lights_punctual':{"
        "'light':0}}}],'extensions':{'KHR_lights_punctual':{'lights':[{'type':'directional'}]}},"
        "'animations':[{'samplers':[{'input':%d,'output':%d},{'input':%d,'output':%d}],'channels':["
        "{'sampler':0,'target':{'node':0,'path':'weights'}},"
        "{'sampler':1,'target':{'node':2,'path':'rotation'}}]}]",
        positions, normals, joints, weights, target, target, times, morphs, times, turns);
}

UNIT_TEST(vertices_follow_the_stills) {
    write_figure();
    fathom_scene *moving = read_blurred(0.5, 1);
    const fathom_mesh *m = &moving->meshes.items[0];
    assert_int_equal(moving->instances.items[0].key_count, 0);
    assert_in_range(m->key_count, 3, 65);
    for (uint32_t k = 0; k < m->key_count; ++k) {
        fathom_scene *still = read_at(m->key_times[k]);
        const fathom_mesh *there = &still->meshes.items[0];
        assert_memory_equal(m->key_positions + 9 * k, there->positions, 9 * sizeof(float));
        assert_memory_equal(m->key_normals + 9 * k, there->normals, 9 * sizeof(float));
    }
}

static stage figure_at(double open, double close) {
    stage s = stage_open(32, 32);
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = open, asked.shutter = close - open;
    assert_ok(s.context, fathom_scene_read_with(s.context, file_path, &asked, &s.scene));
    own_scene(s.scene);
    assert_ok(s.context, fathom_scene_set_background(s.scene, (float[3]){0.3f, 0.4f, 0.5f}));
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.target_error = 0, s.settings.max_depth = 3;
    return s;
}

UNIT_TEST(a_blurred_figure_is_the_mean_of_still_ones) {
    write_figure();
    assert_mean_of_stills(figure_at, 0, 2);
}

/* ---- what cannot be blurred ---- */

UNIT_TEST(what_cannot_blur_stands_as_in_the_middle_and_is_named) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 0.5f, 1),
              slide = PUT_FLOATS(&b, "VEC3", 2, 1, 0, 0, 8, 0, 0),
              flat = PUT_FLOATS(&b, "VEC3", 2, 1, 1, 1, 0, 1, 1),
              flips = PUT_FLOATS(&b, "VEC3", 2, 1, 1, 1, 1, -0.5f, -0.25f);
    const struct {
        const char *path, *way, *more, *said;
        int output, entry; /* of the transform */
        double shutter, middle;
    } cases[] = {{"translation", "STEP", "",
                  "nodes[0] (\"it\"): a node jumps while the shutter is open, by STEP, and is not blurred",
                  slide, 3, 1, 8},
                 {"scale", "LINEAR", "",
                  "nodes[0] (\"it\"): a node is flat or turned inside out while the shutter is open", flat, 0,
                  0.5, 0.5},
                 {"scale", "LINEAR", "",
                  "nodes[0] (\"it\"): a node is flat or turned inside out while the shutter is open", flips,
                  5, 0.5, 0.25},
                 {"translation", "LINEAR", ",'extensions':{'KHR_lights_punctual':{'light':0}}",
                  "nodes[0] (\"it\"): a light moves while the shutter is open, and is not blurred", slide, 3,
                  0.5, 4.5}};
    for (int i = 0; i < 4; ++i) {
        build own = b;
        write_channel(&own, cases[i].path, cases[i].way, cases[i].more, times, cases[i].output);
        fathom_scene *scene = read_blurred(0.5, cases[i].shutter);
        assert_int_equal(warning_count, 1);
        expect_warning(cases[i].said);
        assert_int_equal(scene->instances.items[0].key_count > 0, i == 3);
        const double found =
            i == 3 ? scene->lights.items[0].position[0] : scene->instances.items[0].transform[cases[i].entry];
        assert_near(found, cases[i].middle, 1e-12);
    }
}

/* A morph target that moves all points by 4 along x, by a weight that grows from 0 to 1. */
UNIT_TEST(points_stand_as_in_the_middle) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE),
              target = PUT_FLOATS(&b, "VEC3", 3, 4, 0, 0, 4, 0, 0, 4, 0, 0),
              times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), weights = PUT_FLOATS(&b, "SCALAR", 2, 0, 1);
    build_write(
        &b,
        "'meshes':[{'primitives':[{'mode':0,'attributes':{'POSITION':%d},'targets':[{'POSITION':%d}]}]}],"
        "'nodes':[{'mesh':0}],'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':["
        "{'sampler':0,'target':{'node':0,'path':'weights'}}]}]",
        positions, target, times, weights);
    const fathom_scene *scene = read_blurred(0, 1);
    assert_near((double)scene->meshes.items[0].positions[0], 2, 0);
}

int main(void) { return unit_main(open_folder, remove_folder); }
