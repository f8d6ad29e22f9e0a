/* glTF scenes: where nodes put things, which camera looks, what the lights send. */
#include "gltf_file.h"

#include "math/affine.h"
#include "read/mesh/strokes.h"

static const double pi = 3.14159265358979324;

static vec3_f64 placed(const fathom_scene *scene, size_t instance, vec3_f64 p) {
    affine_f64 map;
    memcpy(map.m, scene->instances.items[instance].transform, sizeof map.m);
    return affine_point(&map, p);
}

/* A quarter turn about y takes x to -z and z to x; quaternion (0, sin 45°, 0, cos 45°). The matrix of the
 * inner node, column by column, doubles x and moves by (1, 2, 3). */
UNIT_TEST(transforms_nest) {
    fathom_scene *scene = read_triangle(WITH_DATA(
        TRIANGLE_MESH
        ",'nodes':[{'translation':[10,0,0],'rotation':[0,0.70710678118654752,0,0.70710678118654752],"
        "'scale':[2,3,4],'children':[1]},"
        "{'mesh':0,'matrix':[2,0,0,0, 0,1,0,0, 0,0,1,0, 1,2,3,1]}],'scenes':[{'nodes':[0]}]"));
    assert_int_equal(scene->instances.count, 1);
    /* (1,1,1) -> (3,3,4) -> scaled (6,9,16) -> turned (16,9,-6) -> moved. Tens of roundings of 2^-53 on
     * numbers below 32. */
    assert_vec(placed(scene, 0, (vec3_f64){1, 1, 1}), 26, 9, -6, 32 * 16 * 0x1p-53);
}

/* 2^30 at the top of the hierarchy and -2^30 below it cancel without a loss that float would have. */
UNIT_TEST(transforms_are_double) {
    fathom_scene *scene =
        read_triangle(WITH_DATA(TRIANGLE_MESH ",'nodes':[{'translation':[1073741824,0,0],'children':[1]},"
                                              "{'translation':[-1073741823.75,0,0],'mesh':0}]"));
    assert_vec(placed(scene, 0, (vec3_f64){0, 0, 0}), 0.25, 0, 0, 0);
}

UNIT_TEST(a_mesh_is_stored_once) {
    fathom_scene *scene =
        read_triangle(WITH_DATA(TRIANGLE_MESH ",'nodes':[{'mesh':0},{'mesh':0,'translation':[1,0,0]},"
                                              "{'children':[3]},{'mesh':0,'translation':[2,0,0]}]"));
    assert_int_equal(scene->meshes.count, 1);
    assert_int_equal(scene->instances.count, 3);
    assert_string_equal(scene->groups.items[scene->instances.items[0].group], "tri");
    for (size_t i = 0; i < 3; ++i) {
        assert_int_equal(scene->instances.items[i].group, scene->instances.items[0].group);
        assert_vec(placed(scene, i, (vec3_f64){0, 0, 0}), (double)i, 0, 0, 0);
    }
}

/* EXT_mesh_gpu_instancing: the positions serve as translations, the normals as scales. Colours are told. */
UNIT_TEST(gpu_instancing_places_every_entry) {
    triangle_data data = triangle;
    for (int i = 0; i < 9; ++i) data.normals[i / 3][i % 3] = (float)(i / 3 + 1);
    write_glb(WITH_DATA("'extensionsRequired':['EXT_mesh_gpu_instancing']," TRIANGLE_MESH
                        ",'nodes':[{'mesh':0,'translation':[0,0,1],'extensions':{'EXT_mesh_gpu_instancing':{"
                        "'attributes':{'TRANSLATION':0,'SCALE':4,'_ID':4,'_COLOR_0':4}}}}]"),
              &data, sizeof data);
    fathom_scene *scene = read_file();
    assert_int_equal(scene->instances.count, 3);
    assert_int_equal(warning_count, 1);
    expect_warning("attributes._COLOR_0: _COLOR_0 of instances is ignored");
    for (int i = 0; i < 3; ++i) {
        const float *t = triangle.positions[i];
        assert_vec(placed(scene, (size_t)i, (vec3_f64){1, 1, 1}), t[0] + (float)(i + 1),
                   t[1] + (float)(i + 1), t[2] + (float)(i + 2), 0);
    }
}

/* The default scene, else the first, else all roots, else every mesh. */
UNIT_TEST(the_default_scene_chooses_the_nodes) {
    const struct {
        const char *tail;
        size_t count;
        double x; /* of the first one */
        const char *told;
    } cases[] = {
        {"'nodes':[{'mesh':0,'translation':[1,0,0]},{'mesh':0,'translation':[2,0,0]}],"
         "'scenes':[{'nodes':[0]},{'nodes':[1]}],'scene':1",
         1, 2, "scenes[0]: a scene is left out, because scenes[1] is shown; --scene NAME|N takes one of"},
        {"'nodes':[{'mesh':0,'translation':[1,0,0]},{'mesh':0,'translation':[2,0,0]}],"
         "'scenes':[{'nodes':[0]},{'nodes':[1]},{'nodes':[0,1]}]",
         1, 1, "scenes[1]: a scene is left out, because scenes[0] is shown; --scene NAME|N takes one of"},
        {"'nodes':[{'mesh':0,'translation':[1,0,0]},{'mesh':0,'translation':[2,0,0]}],"
         "'scenes':[{'nodes':[0]},{},{'nodes':[0,1]}],'scene':2",
         2, 1, NULL},
        {"'nodes':[{'mesh':0,'translation':[1,0,0]},{'name':'lost','mesh':0,'children':[3,4]},{'children':[1]"
         "},{'mesh':0},{}],'scenes':[{'nodes':[0]}]",
         1, 1, "nodes[1] (\"lost\"): a node with a mesh is in no scene, and is left out (2 such)"},
        {"'nodes':[{'mesh':0,'translation':[1,0,0]},{'mesh':0,'translation':[2,0,0]}]", 2, 1, NULL},
        {"'nodes':[]", 1, 0, NULL}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene = read_triangle(unit_text(WITH_DATA(TRIANGLE_MESH ",%s"), cases[i].tail));
        assert_int_equal(scene->instances.count, cases[i].count);
        assert_vec(placed(scene, 0, (vec3_f64){0, 0, 0}), cases[i].x, 0, 0, 0);
        assert_int_equal(warning_count, cases[i].told != NULL);
        if (cases[i].told) expect_warning(cases[i].told);
    }
}

UNIT_TEST(each_omission_is_reported_once) {
    const struct {
        const char *tail, *warning;
    } cases[] = {
        {"'nodes':[{'mesh':0},{'mesh':0,'scale':[0,0,0]}]," TRIANGLE_MESH, "scaled to nothing"},
        {"'animations':[{},{}]," TRIANGLE_MESH,
         "animations are not played; --time SECONDS poses them: 0, 1 (2 such)"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':0},{'attributes':{'POSITION':0},'mode'"
         ":0},"
         "{'attributes':{'POSITION':0}}]}]",
         "primitives[0].mode: points have no size, and are shown as small spheres (2 such)"},
        {"'meshes':[{'primitives':[{'attributes':{}},{'attributes':{}},{'attributes':{'POSITION':0}}]}]",
         "without POSITION"},
        {"'meshes':[{'primitives':[{'attributes':{'POSITION':0},'material':0},{'attributes':{'POSITION':0},"
         "'material':1}]}],'textures':[{}],'materials':[{'normalTexture':{'index':0}},{'normalTexture':{'"
         "index':0}"
         "}]",
         "textures[0]: a texture without an image that can be read is left out (2 such)"},
        {"'extensionsUsed':['A_b'],'materials':[{'extensions':{'A_b':{'extensions':{'KHR_texture_transform':{"
         "}}}},"
         "'extras':{'extensions':{'B_c':0}}},{'extensions':{'A_b':1}}]," TRIANGLE_MESH,
         "materials[0]: the extension A_b is ignored (2 such)"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_scene *scene = read_triangle(unit_text(WITH_DATA("%s"), cases[i].tail));
        assert_int_equal(warning_count, 1);
        if (!strstr(warned, cases[i].warning)) fail_msg("\"%s\" lacks \"%s\"", warned, cases[i].warning);
        expect_warning(file_path);
        assert_true(scene->meshes.count > 0 && scene->instances.count == 1);
    }
}

/* Lines, strips and loops of three vertices are as many rods as they have segments; each corner of a rod is
 * its radius from the nearest end. */
UNIT_TEST(lines_are_rods) {
    const uint32_t rods[] = {1, 3, 2};
    for (uint32_t mode = 1; mode <= 3; ++mode) {
        fathom_scene *scene = read_triangle(
            unit_text(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0},'mode':%u}]}]"), mode));
        const fathom_mesh *mesh = &scene->meshes.items[0];
        assert_int_equal(mesh->triangle_count, ROD_TRIANGLES * rods[mode - 1]);
        /* A three hundredth of the diagonal: of (0,0,0) and (1,0,0), or of all. */
        const double radius = (mode == 1 ? 1 : 1.5) / 300;
        for (uint32_t i = 0; i < mesh->vertex_count; ++i) {
            double nearest = INFINITY;
            for (int k = 0; k < 3; ++k) {
                const vec3_f64 p = widen(load_f32(mesh->positions + 3 * i)),
                               end = widen(load_f32(triangle.positions[k]));
                nearest = fmin(nearest, length_f64(sub_f64(p, end)));
            }
            assert_near(nearest, radius, 0x1p-23);
        }
        expect_warning("lines have no width, and are shown as thin rods (1 such)");
    }
}

UNIT_TEST(what_points_and_lines_cannot_show_is_named) {
    static const char *const keys[] = {"NORMAL", "TEXCOORD_0"};
    for (size_t i = 0; i < 2; ++i) {
        const char *json =
            unit_text(SHOWN("'meshes':[{'primitives':[{'attributes':{'POSITION':0,'%s':0},'mode':3},"
                            "{'attributes':{'POSITION':0,'%s':0},'mode':3},{'attributes':{'POSITION':0}}]}]"),
                      keys[i], keys[i]);
        const char *expected = unit_text("%s of points and lines is left out (2 such)", keys[i]);
        read_triangle(json);
        expect_warning(expected);
    }
}

/* KHR_node_visibility hides what is below as well, and lights, but not cameras. */
UNIT_TEST(hidden_nodes_only_keep_their_camera) {
    fathom_scene *scene = read_triangle(WITH_DATA(
        TRIANGLE_MESH
        ",'extensionsRequired':['KHR_node_visibility'],'nodes':[{'mesh':0},{'mesh':0,'children':[2,3],"
        "'extensions':{'KHR_node_visibility':{'visible':false}}},{'mesh':0,'camera':0,'extensions':{"
        "'KHR_node_visibility':{'visible':true}}},{'extensions':{'KHR_lights_punctual':{'light':0}}},"
        "{'mesh':0,'extensions':{'KHR_node_visibility':{}}}],"
        "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point'}]}},"
        "'cameras':[{'type':'perspective','perspective':{'yfov':1,'znear':0.1}}]"));
    assert_int_equal(scene->instances.count, 2);
    assert_int_equal(scene->lights.count, 0);
    assert_true(scene->has_camera);
    assert_int_equal(warning_count, 1);
    expect_warning("nodes[1]: KHR_node_visibility hides it");
}

#define CAMERAS                                                                                              \
    "'cameras':[{'type':'orthographic','orthographic':{'xmag':1,'ymag':1,'zfar':9,'znear':1}},"              \
    "{'type':'perspective','perspective':{'yfov':1,'aspectRatio':2,'znear':0.1}},"                           \
    "{'type':'perspective','perspective':{'yfov':0.5,'znear':0.1}}]"

/* The first perspective camera of the hierarchy, in the order of the file; its frame is its node's. */
UNIT_TEST(the_camera_follows_its_node) {
    fathom_scene *scene = read_triangle(
        WITH_DATA(TRIANGLE_MESH "," CAMERAS ",'nodes':[{'children':[1,2]},{'camera':0},"
                                "{'camera':1,'translation':[1,2,3],'scale':[2,2,2],"
                                "'rotation':[0,0.70710678118654752,0,0.70710678118654752]},{'camera':2}]"));
    const fathom_camera *c = &scene->camera;
    assert_true(scene->has_camera);
    assert_int_equal(warning_count, 1);
    expect_warning("holds 3 cameras");
    const double tolerance = 16 * 0x1p-53;
    assert_vec(load_f64(c->origin), 1, 2, 3, 0);
    assert_vec(load_f64(c->x), 0, 0, -1, tolerance);
    assert_vec(load_f64(c->y), 0, 1, 0, tolerance);
    assert_vec(load_f64(c->z), 1, 0, 0, tolerance);
    assert_near(c->h / c->d, 2 * tan(0.5), tolerance);
    assert_near(c->w, 0, 0); /* pixels are square */
    assert_near(scene->camera_aspect, 2, 0);
    scene = read_triangle(WITH_DATA(TRIANGLE_MESH "," CAMERAS ",'nodes':[{'camera':2},{'camera':1}]"));
    assert_near(scene->camera.h, 2 * tan(0.25), tolerance);
    assert_near(scene->camera_aspect, 0, 0);
}

#define LIGHTS                                                                                               \
    "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','color':[1,0.5,0.25],'intensity':8},"    \
    "{'type':'directional','intensity':3},{'type':'spot','spot':{'innerConeAngle':0.25,"                     \
    "'outerConeAngle':0.5}},{'type':'spot'}]}}"
#define LIGHT(i) "'extensions':{'KHR_lights_punctual':{'light':" #i "}}"

/* A surface of base colour b lit head on by I candela from d metres has the luminance b / pi · I / d^2: the
 * model's k_d k_l / d^2 must be that. */
/* 683 lm a watt, which Blender has multiplied by; pi: see gltf_light.c. */
UNIT_TEST(lamps_of_blender_are_in_watts) {
    static const char *const generators[] = {
        "Khronos glTF Blender I/O v3.4.50", "Khronos glTF Blender I/O v4.0.1",
        "Khronos glTF Blender I/O v3.3.27", "Khronos glTF Blender I/O v1.5.17", "Khronos glTF blender"};
    for (int i = 0; i < 5; ++i) {
        write_gltf(unit_text(
            "{'asset':{'version':'2.0','generator':'%s'},'extensions':{'KHR_lights_punctual':{'lights':[{"
            "'type':'point','intensity':1366}]}},'nodes':[{'extensions':{'KHR_lights_punctual':{"
            "'light':0}}}]}",
            generators[i]));
        fathom_scene *scene = read_file();
        assert_near((double)scene->lights.items[0].intensity[0], (i < 2 ? 2 : 1366) / 3.14159265358979324,
                    1e-4);
        assert_int_equal(warning_count, i < 2);
        forget_warnings();
    }
}

/* Glass of Cycles always refracts; without KHR_materials_volume it does not in glTF. */
UNIT_TEST(thin_glass_of_blender_is_told) {
    static const char *const generators[] = {"Khronos glTF Blender I/O v3.4.50", "another"},
                             *const volumes[] = {"", ",'KHR_materials_volume':{'thicknessFactor':1}"};
    for (int i = 0; i < 4; ++i) {
        const char *text = unit_text(
            "{'asset':{'version':'2.0','generator':'%s'}," DATA ",'meshes':[{'primitives':[{'attributes':{"
            "'POSITION':0},'material':0}]}],'nodes':[{'mesh':0}],'materials':[{'doubleSided':true,'"
            "extensions':{"
            "'KHR_materials_transmission':{'transmissionFactor':1}%s}}]}",
            generators[i % 2], volumes[i / 2]);
        read_triangle(text);
        assert_int_equal(warning_count, i == 0);
        forget_warnings();
    }
}

UNIT_TEST(lights_follow_their_node) {
    fathom_scene *scene = read_triangle(
        WITH_DATA(TRIANGLE_MESH "," LIGHTS ",'nodes':[{'children':[1],'rotation':[1,0,0,0],'scale':[5,5,5]},"
                                "{'translation':[0,0,1]," LIGHT(0) "},{'rotation':[1,0,0,0]," LIGHT(
                                    1) "},"
                                       "{'translation':[1,2,3]," LIGHT(2) "},{" LIGHT(3) "}]"));
    assert_int_equal(scene->lights.count, 4);
    const fathom_light *l = scene->lights.items;
    assert_int_equal(l[0].type, FATHOM_LIGHT_POINT);
    assert_vec(load_f64(l[0].position), 0, 0, -5, 16 * 0x1p-53);
    const double b = 0.5, d = 2, lux[3] = {8 / (d * d), 4 / (d * d), 2 / (d * d)};
    for (int c = 0; c < 3; ++c) {
        double model = b * (double)l[0].intensity[c] / (d * d);
        assert_near(model, b / pi * lux[c], 0x1p-24); /* one rounding to float below 1 */
    }
    assert_int_equal(l[1].type, FATHOM_LIGHT_DIRECTIONAL);
    /* A half turn about x turns -z to z. */
    assert_vec(load_f64(l[1].direction), 0, 0, 1, 16 * 0x1p-53);
    assert_near(l[1].intensity[2], 3 / pi, 0x1p-24);
    assert_int_equal(l[2].type, FATHOM_LIGHT_SPOT);
    assert_vec(load_f64(l[2].position), 1, 2, 3, 0);
    assert_vec(load_f64(l[2].direction), 0, 0, -1, 0);
    assert_near(l[2].inner_angle, 0.25, 0);
    assert_near(l[2].outer_angle, 0.5, 0);
    assert_near(l[2].intensity[0], 1 / pi, 0x1p-24);
    assert_near(l[3].inner_angle, 0, 0);
    assert_near(l[3].outer_angle, pi / 4, 0x1p-24);
}

UNIT_TEST(surroundings_only_when_asked_for) {
    write_triangle(
        WITH_DATA(TRIANGLE_MESH "," LIGHTS "," CAMERAS ",'nodes':[{'mesh':0,'camera':1," LIGHT(0) "}]"));
    const read_mesh_options options = {.material = FATHOM_NONE};
    fathom_scene *scene = read_with(&options);
    assert_false(scene->has_camera);
    assert_int_equal(scene->lights.count, 0);
    assert_int_equal(scene->instances.count, 1);
}

/* Into a group other than the root: the instances lie in it. */
UNIT_TEST(models_can_be_read_into_a_group) {
    write_triangle(SHOWN(TRIANGLE_MESH));
    const read_mesh_options options = {.material = FATHOM_NONE};
    fathom_scene *scene = new_scene(context);
    const fathom_id group = new_group(scene, "here");
    assert_ok(context, read_gltf(scene, group, file_path, &options));
    assert_int_equal(scene->instances.items[0].parent, group);
}

int main(void) { return unit_main(open_folder, remove_folder); }
