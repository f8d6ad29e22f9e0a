/* glTF that moves: animations, skins, morph targets, each against its closed form. */
#include "read/gltf/gltf_pose.h"

#include "gltf_build.h"
#include "materials.h"

#include <math.h>

#define TRIANGLE 0, 0, 0, 1, 0, 0, 0, 1, 0

/* ---- animations of nodes ---- */

/* A node with a triangle and one channel. */
static void write_channel(build *b, const char *path, const char *way, int input, int output) {
    const int positions = PUT_FLOATS(b, "VEC3", 3, TRIANGLE);
    build_write(
        b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[{'mesh':0}],'animations':[{"
        "'name':'go','samplers':[{'input':%d,'output':%d,'interpolation':'%s'}],'channels':[{'sampler':0,"
        "'target':{'node':0,'path':'%s'}}]}]",
        positions, input, output, way, path);
}

static void assert_moved(double time, double x) {
    fathom_scene *scene = read_at(time);
    assert_vec(placed_corner(scene, 0, 0, 0), x, 0, 0, 1e-12);
}

UNIT_TEST(translations_follow_their_interpolation) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 1, 3), values = PUT_FLOATS(&b, "VEC3", 2, 2, 0, 0, 6, 0, 0);
    build linear = b, step = b;
    write_channel(&linear, "translation", "LINEAR", times, values);
    const double at[][2] = {{-1, 2}, {0, 2}, {1, 2}, {2, 4}, {2.5, 5}, {3, 6}, {9, 6}};
    for (size_t i = 0; i < sizeof at / sizeof *at; ++i) assert_moved(at[i][0], at[i][1]);
    write_channel(&step, "translation", "STEP", times, values);
    assert_moved(2.999, 2);
    assert_moved(3, 6);
}

/* The times of half of these keys are floats above the frame's. */
UNIT_TEST(frames_meet_the_keys_at_their_times) {
    static const int rates[] = {24, 25, 30, 60};
    enum { KEYS = 40 };
    float times[KEYS], values[KEYS][3] = {{0}};
    for (size_t i = 0; i < sizeof rates / sizeof *rates; ++i) {
        build b = {.size = 0};
        for (int k = 0; k < KEYS; ++k) times[k] = (float)k / (float)rates[i], values[k][0] = (float)k;
        const int input = put_typed(&b, 5126, "SCALAR", KEYS, times, sizeof times, ""),
                  output = put_typed(&b, 5126, "VEC3", KEYS, values, sizeof values, "");
        write_channel(&b, "translation", "STEP", input, output);
        for (int k = 0; k < KEYS; ++k) assert_moved((double)k / rates[i], k);
    }
}

UNIT_TEST(the_last_of_equal_keys_counts_from_then_on) {
    static const char *const ways[] = {"LINEAR", "STEP"};
    for (int i = 0; i < 2; ++i) {
        build b = {.size = 0};
        const int times = PUT_FLOATS(&b, "SCALAR", 6, 0, 1, 1, 1, 2, 2),
                  values = PUT_FLOATS(&b, "VEC3", 6, 0, 0, 0, 2, 0, 0, 7, 0, 0, 4, 0, 0, 6, 0, 0, 8, 0, 0);
        write_channel(&b, "translation", ways[i], times, values);
        forget_warnings();
        assert_moved(0.5, i ? 0 : 1);
        assert_int_equal(warning_count, 1);
        expect_warning("samplers[0].input: a key has the time of the one before it; from "
                       "then on the last counts (3 such)");
        assert_moved(1, 4);
        assert_moved(1.5, i ? 4 : 5);
        assert_moved(2, 8);
        assert_moved(9, 8);
    }
}

/* KHR_animation_pointer: to a node's part it is as the node's own channel; other pointers are told. */
UNIT_TEST(pointers_to_nodes_are_followed) {
    static const char *const pointers[] = {"/nodes/0/translation", "/materials/0/alphaCutoff"};
    for (int i = 0; i < 2; ++i) {
        build b = {.size = 0};
        const int times = PUT_FLOATS(&b, "SCALAR", 2, 1, 3),
                  values = PUT_FLOATS(&b, "VEC3", 2, 2, 0, 0, 6, 0, 0),
                  positions = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE);
        build_write(&b,
                    "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[{'mesh':0}],"
                    "'extensionsRequired':['KHR_animation_pointer'],'animations':[{'samplers':[{'input':%d,"
                    "'output':%d}],'channels':[{'sampler':0,'target':{'path':'pointer','extensions':{"
                    "'KHR_animation_pointer':{'pointer':'%s'}}}}]}]",
                    positions, times, values, pointers[i]);
        assert_moved(2, i == 0 ? 4 : 0);
        assert_int_equal(warning_count, i);
    }
    expect_warning("the animation of \"/materials/*/alphaCutoff\" is ignored (1 such)");
}

/* Three values a key; the spline through (0, 1) and (2, 5) with slopes 3 and -1. Hermite's cubic has these
 * values and slopes at its ends, and no other cubic does. */
UNIT_TEST(cubic_splines_have_the_slopes_of_their_tangents) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 0, 2),
              values = PUT_FLOATS(&b, "VEC3", 6, 9, 9, 9, 1, 0, 0, 3, 0, 0, -1, 0, 0, 5, 0, 0, 9, 9, 9);
    write_channel(&b, "translation", "CUBICSPLINE", times, values);
    assert_moved(0, 1);
    assert_moved(2, 5);
    /* x(t) = 1 + 3 t + c t^2 + d t^3 with x(2) = 5 and x'(2) = -1: c = 1/2, d = -1/2. */
    for (double t = 0.25; t < 2; t += 0.25) assert_moved(t, 1 + 3 * t + (t * t - t * t * t) / 2);
}

/* Equal times turn by equal angles, the shorter way even where a file has the other sign. */
UNIT_TEST(rotations_turn_evenly_the_shorter_way) {
    const double half = 0.75, quarter = half / 2; /* radians: of the whole turn's half angle */
    for (int sign = -1; sign <= 1; sign += 2) {
        build b = {.size = 0};
        const float s = (float)(sign * sin(half)), c = (float)(sign * cos(half));
        const int times = PUT_FLOATS(&b, "SCALAR", 2, 0, 4),
                  turns = PUT_FLOATS(&b, "VEC4", 2, 0, 0, 0, 1, 0, 0, s, c);
        write_channel(&b, "rotation", "LINEAR", times, turns);
        for (int k = 0; k <= 8; ++k) {
            fathom_scene *scene = read_at(k / 2.0);
            const double angle = 4 * quarter * k / 8;
            /* The keys are floats. */
            assert_vec(placed_corner(scene, 0, 0, 1), cos(angle), sin(angle), 0, 1e-7);
        }
    }
}

static void assert_refused(fathom_status expected, const fathom_read_options *asked, const char *text) {
    fathom_scene *scene;
    assert_int_equal(read_asked(asked, &scene), expected);
    if (!strstr(fathom_context_message(context), text)) fail_msg("%s", fathom_context_message(context));
}

/* The last of three animations moves what the first moves. */
UNIT_TEST(what_does_not_move_the_same_is_posed_together) {
    build b = {.size = 0};
    const int positions = PUT_FLOATS(&b, "VEC3", 3, TRIANGLE), times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1),
              near = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 2, 0, 0),
              far = PUT_FLOATS(&b, "VEC3", 2, 0, 0, 0, 8, 0, 0),
              large = PUT_FLOATS(&b, "VEC3", 2, 1, 1, 1, 3, 3, 3);
    build_write(&b,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'nodes':[{'mesh':0},{'mesh':0}],"
                "'animations':[{'samplers':[{'input':%d,'output':%d}],'channels':[{'sampler':0,'target':{"
                "'node':0,'path':'translation'}}]},{'samplers':[{'input':%d,'output':%d}],'channels':[{"
                "'sampler':0,'target':{'node':0,'path':'scale'}},{'sampler':0,'target':{'node':1,'path':"
                "'translation'}}]},{'name':'far','samplers':[{'input':%d,'output':%d}],'channels':[{"
                "'sampler':0,'target':{'node':0,'path':'translation'}}]}]",
                positions, times, near, times, large, times, far);
    fathom_scene *scene = read_at(1);
    assert_vec(placed_corner(scene, 0, 0, 1), 2 + 3, 0, 0, 1e-12);
    assert_vec(placed_corner(scene, 1, 0, 0), 3, 3, 3, 1e-12);
    assert_non_null(strstr(
        warned, "animations[2].channels[0]: an animation that moves what an earlier one moves is left out; "
                "give --animation NAME|N for each to apply: 0, 1, 2 \"far\""));
    fathom_read_options asked = default_read_options();
    asked.animations = (const char *const[]){"far", NULL}, asked.choose_time = true, asked.time = 1;
    scene = read_as(&asked);
    assert_vec(placed_corner(scene, 0, 0, 1), 8 + 1, 0, 0, 1e-12);
    assert_vec(placed_corner(scene, 1, 0, 0), 0, 0, 0, 1e-12);
    asked.animations = (const char *const[]){"far", "1", NULL};
    scene = read_as(&asked);
    assert_vec(placed_corner(scene, 0, 0, 1), 8 + 3, 0, 0, 1e-12);
    assert_vec(placed_corner(scene, 1, 0, 0), 3, 3, 3, 1e-12);
    asked.animations = (const char *const[]){"far", "1", "0", NULL};
    assert_refused(FATHOM_BAD_USAGE, &asked,
                   "animations[0].channels[0]: moves what another of the chosen animations moves; expected "
                   "animations of different things out of 0, 1, 2 \"far\"");
}

UNIT_TEST(without_a_time_everything_rests_and_it_is_said) {
    build b = {.size = 0};
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 1, 3), values = PUT_FLOATS(&b, "VEC3", 2, 2, 0, 0, 6, 0, 0);
    write_channel(&b, "translation", "LINEAR", times, values);
    fathom_scene *scene = read_file();
    assert_vec(placed_corner(scene, 0, 0, 0), 0, 0, 0, 0);
    assert_int_equal(warning_count, 1);
    assert_non_null(
        strstr(warned, "animations are not played; --time SECONDS poses them: 0 \"go\" (1 such)"));
}

/* ---- morph targets ---- */

#define MORPHED                                                                                              \
    "'meshes':[{%s'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d},'targets':[{'POSITION':%d},{"      \
    "'POSITION':%d,'NORMAL':%d}]}]}],'nodes':[{'mesh':0%s},{'mesh':0}]%s"

/* Two targets: the first moves a corner by (4,0,0), the second by (0,8,0). */
typedef struct morphed {
    int positions, normals, first, second;
} morphed;

static morphed put_morphed(build *b) {
    morphed m;
    m.positions = PUT_FLOATS(b, "VEC3", 3, TRIANGLE);
    m.normals = PUT_FLOATS(b, "VEC3", 3, 0, 0, 1, 0, 0, 1, 0, 0, 1);
    m.first = PUT_FLOATS(b, "VEC3", 3, 4, 0, 0, 0, 0, 0, 0, 0, 0);
    m.second = PUT_FLOATS(b, "VEC3", 3, 0, 8, 0, 0, 0, 0, 0, 0, 0);
    return m;
}

/* Targets add up by their weights: the node's, else the mesh's, else none. */
UNIT_TEST(targets_add_up_by_weight) {
    build b = {.size = 0};
    const morphed m = put_morphed(&b);
    const int turned = PUT_FLOATS(&b, "VEC3", 3, 1, 0, 0, 0, 0, 0, 0, 0, 0);
    build_write(&b, MORPHED, "'weights':[0.5,0],", m.positions, m.normals, m.first, m.second, turned,
                ",'weights':[0.25,-1]", "");
    fathom_scene *scene = read_file();
    assert_int_equal(scene->meshes.count, 2);
    assert_vec(corner(scene, 0, 0, 0), 1, -8, 0, 0);
    assert_vec(corner(scene, 0, 0, 1), 1, 0, 0, 0);
    assert_vec(widen(load_f32(scene->meshes.items[0].normals)), -1, 0, 1, 0);
    assert_vec(corner(scene, 1, 0, 0), 2, 0, 0, 0);
    assert_vec(widen(load_f32(scene->meshes.items[1].normals)), 0, 0, 1, 0);
    assert_int_equal(warning_count, 0);
}

UNIT_TEST(weights_are_animated_together) {
    build b = {.size = 0};
    const morphed m = put_morphed(&b);
    const int times = PUT_FLOATS(&b, "SCALAR", 2, 0, 1), weights = PUT_FLOATS(&b, "SCALAR", 4, 0, 1, 1, 0);
    build_write(
        &b, MORPHED, "", m.positions, m.normals, m.first, m.second, m.normals, "",
        ",'animations':[{'samplers':[{'input':4,'output':5}],'channels':[{'sampler':0,'target':{'node':0,"
        "'path':'weights'}}]}]");
    assert_int_equal(times, 4);
    assert_int_equal(weights, 5);
    fathom_scene *scene = read_at(0.25);
    assert_vec(corner(scene, 0, 0, 0), 1, 6, 0, 0);
    assert_vec(corner(scene, 1, 0, 0), 0, 0, 0, 0);
}

/* ---- skins ---- */

/* Two joints, the second one 2 above the first; `more` goes into the attributes, `node` into the mesh's
 * node, which must not matter. */
static void write_skin(build *b, int joints, int weights, const char *more, const char *node) {
    const int positions = PUT_FLOATS(b, "VEC3", 3, TRIANGLE),
              normals = PUT_FLOATS(b, "VEC3", 3, 0, 0, 1, 0, 0, 1, 0, 0, 1),
              bind = PUT_FLOATS(b, "MAT4", 2, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0,
                                1, 0, 0, 0, 0, 1, 0, 0, -2, 0, 1);
    build_write(
        b,
        "'meshes':[{'primitives':[{'attributes':{'POSITION':%d,'NORMAL':%d,'JOINTS_0':%d,'WEIGHTS_0':%d%s}}]}"
        "],"
        "'skins':[{'joints':[1,2],'inverseBindMatrices':%d}],'nodes':[{'mesh':0,'skin':0%s},{'translation':["
        "10,0,0],'children':[2]},{'translation':[0,2,0],'rotation':[0,0,1,0]}]",
        positions, normals, joints, weights, more, bind, node);
}

UNIT_TEST(vertices_follow_their_joints_and_no_node) {
    build b = {.size = 0};
    const int joints = PUT_BYTES(&b, "VEC4", 3, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0),
              weights = PUT_FLOATS(&b, "VEC4", 3, 1, 0, 0, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0);
    write_skin(&b, joints, weights, "", ",'translation':[5,5,5],'scale':[3,3,3]");
    fathom_scene *scene = read_file();
    /* Joint 0 moves by (10,0,0); joint 1 turns by half a turn about (10,2) what its bind pose has at (0,2).
     */
    assert_vec(placed_corner(scene, 0, 0, 0), 10, 0, 0, 1e-6);
    assert_vec(placed_corner(scene, 0, 0, 1), 9, 4, 0, 1e-6);
    assert_vec(placed_corner(scene, 0, 0, 2), 10, 0.75 * 1 + 0.25 * 3, 0, 1e-6);
    assert_vec(widen(load_f32(scene->meshes.items[0].normals)), 0, 0, 1, 0);
    assert_int_equal(warning_count, 0);
}

/* Weights count by their sum over all sets, whatever it is; without any, the first joint has the vertex. */
UNIT_TEST(weights_of_all_sets_count_by_their_sum) {
    build b = {.size = 0};
    const int joints = PUT_BYTES(&b, "VEC4", 3, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0),
              weights = PUT_FLOATS(&b, "VEC4", 3, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0),
              others = PUT_BYTES(&b, "VEC4", 3, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0),
              more = PUT_FLOATS(&b, "VEC4", 3, 0, 0, 0, 0, 1, 1, 0.5f, 0.5f, 0, 0, 0, 0);
    write_skin(&b, joints, weights, unit_text(",'JOINTS_1':%d,'WEIGHTS_1':%d", others, more), "");
    fathom_scene *scene = read_file();
    assert_vec(placed_corner(scene, 0, 0, 0), 10, 0, 0, 1e-6);
    assert_vec(placed_corner(scene, 0, 0, 1), 0.25 * 11 + 0.75 * 9, 3, 0, 1e-6);
    assert_vec(placed_corner(scene, 0, 0, 2), 10, 3, 0, 1e-6);
}

/* ---- what is refused ---- */

UNIT_TEST(wrong_animations_are_refused) {
    fathom_read_options asked = default_read_options();
    asked.choose_time = true, asked.time = 1;
    build good = {.size = 0};
    const int times = PUT_FLOATS(&good, "SCALAR", 2, 1, 3),
              values = PUT_FLOATS(&good, "VEC3", 2, 2, 0, 0, 6, 0, 0),
              falling = PUT_FLOATS(&good, "SCALAR", 2, 3, 1),
              zero = PUT_FLOATS(&good, "VEC4", 2, 0, 0, 0, 0, 0, 0, 0, 1);
    const struct {
        const char *path, *way;
        int input, output;
        const char *text;
    } cases[] = {
        {"translation", "LINEAR", falling, values,
         "samplers[0].input: has 1 s after 3 s, at key 1; expected times that rise"},
        {"translation", "CUBICSPLINE", times, values,
         "has 2 entries; expected 6 for 2 keys of a cubic spline, three for each"},
        {"translation", "BEZIER", times, values, "is \"BEZIER\"; expected LINEAR, STEP or CUBICSPLINE"},
        {"rotation", "LINEAR", times, values, "is accessors[1] of 3 × float; expected 4 × float"},
        {"rotation", "LINEAR", times, zero, "is a rotation of zero at 1 s; expected unit quaternions"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        build b = good;
        write_channel(&b, cases[i].path, cases[i].way, cases[i].input, cases[i].output);
        assert_refused(FATHOM_BAD_INPUT, &asked, cases[i].text);
    }
    build b = good;
    write_channel(&b, "translation", "LINEAR", times, values);
    asked.animations = (const char *const[]){"run", NULL};
    assert_refused(FATHOM_BAD_USAGE, &asked, "there is no animation \"run\"; expected one of 0 \"go\"");
    write_triangle(SHOWN(TRIANGLE_MESH));
    assert_refused(FATHOM_BAD_USAGE, &asked, "has no animations to pose");
}

UNIT_TEST(wrong_skins_are_refused) {
    fathom_read_options asked = default_read_options();
    build b = {.size = 0}, bare = b;
    const int joints = PUT_BYTES(&b, "VEC4", 3, 0, 0, 0, 0, 2, 0, 0, 0, 0, 1, 0, 0),
              weights = PUT_FLOATS(&b, "VEC4", 3, 1, 0, 0, 0, 1, 0, 0, 0, 0.75f, 0.25f, 0, 0);
    write_skin(&b, joints, weights, "", "");
    assert_refused(FATHOM_BAD_INPUT, &asked, "JOINTS_0: entry 1 names joint 2; the skin has 2");
    const int positions = PUT_FLOATS(&bare, "VEC3", 3, TRIANGLE);
    build_write(&bare,
                "'meshes':[{'primitives':[{'attributes':{'POSITION':%d}}]}],'skins':[{'joints':[0]}],'nodes':"
                "[{'mesh':"
                "0,'skin':0}]",
                positions);
    assert_refused(FATHOM_BAD_INPUT, &asked, "lacks JOINTS_0 or WEIGHTS_0; expected both");
}

/* ---- scenes, variants, units ---- */

UNIT_TEST(a_scene_is_chosen_by_name_or_number) {
    fathom_scene *scene;
    fathom_read_options asked = default_read_options();
    write_triangle(WITH_DATA("'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0},"
                             "{'mesh':0,'translation':[2,0,0]}],'scenes':[{'name':'left','nodes':[0]},"
                             "{'name':'right','nodes':[1]}],'scene':1"));
    const char *const names[] = {NULL, "right", "1", "left", "0"};
    for (int i = 0; i < 5; ++i) {
        asked.scene = names[i];
        scene = read_as(&asked);
        assert_int_equal(scene->instances.count, 1);
        assert_vec(placed_corner(scene, 0, 0, 0), i < 3 ? 2 : 0, 0, 0, 0);
        assert_int_equal(warning_count > 0, !names[i]);
    }
    asked.scene = "up";
    assert_refused(FATHOM_BAD_USAGE, &asked,
                   "there is no scene \"up\"; expected one of 0 \"left\", 1 \"right\"");
    write_triangle(
        WITH_DATA("'meshes':[{'primitives':[{'attributes':{'POSITION':0}}]}],'nodes':[{'mesh':0}]"));
    assert_refused(FATHOM_BAD_USAGE, &asked, "has no scenes to choose \"up\" from");
}

UNIT_TEST(variants_replace_materials) {
    fathom_scene *scene;
    fathom_read_options asked = default_read_options();
    write_triangle(
        WITH_DATA("'extensions':{'KHR_materials_variants':{'variants':[{'name':'day'},{'name':'night'}]}},"
                  "'materials':[{'name':'a'},{'name':'b'}],'meshes':[{'primitives':[{'attributes':{"
                  "'POSITION':0},'material':0,'extensions':{'KHR_materials_variants':{'mappings':[{"
                  "'material':1,'variants':[1]}]}}}]}],'nodes':[{'mesh':0}]"));
    const char *const names[] = {NULL, "day", "night", "1"}, *const shown[] = {"a", "a", "b", "b"};
    for (int i = 0; i < 4; ++i) {
        asked.variant = names[i];
        scene = read_as(&asked);
        assert_int_equal(scene->meshes.items[0].material, find_material(scene, shown[i]));
        assert_int_equal(warning_count > 0, !names[i]);
    }
    asked.variant = "dusk";
    assert_refused(FATHOM_BAD_USAGE, &asked,
                   "there is no variant \"dusk\"; expected one of 0 \"day\", 1 \"night\"");
}

UNIT_TEST(units_scale_models_cameras_lamps_and_volumes_alike) {
    fathom_read_options asked = default_read_options();
    asked.unit = 0.01;
    write_triangle(WITH_DATA("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0}]}],"
                             "'materials':[{'extensions':{'KHR_materials_volume':{'thicknessFactor':2,"
                             "'attenuationDistance':3}}}],"
                             "'cameras':[{'type':'perspective','perspective':{'yfov':1}}],"
                             "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},"
                             "'nodes':[{'mesh':0},{'camera':0,'translation':[0,0,5],'extensions':{"
                             "'KHR_lights_punctual':{'light':0}}}]"));
    fathom_scene *scene = read_as(&asked);
    scene_bounds bounds;
    assert_ok(context, scene_world_bounds(scene, &bounds));
    assert_vec(bounds.upper, 0.01, 0.01, 0.005, 1e-15);
    assert_near(scene->camera.origin[2], 0.05, 1e-15);
    assert_near(scene->lights.items[0].position[2], 0.05, 1e-15);
    const fathom_material *volume = &scene->materials.items[scene->meshes.items[0].material].value;
    assert_true(volume->thickness == 0.02f && volume->attenuation_distance == 0.03f);
}

int main(void) { return unit_main(open_folder, remove_folder); }
