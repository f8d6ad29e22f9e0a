/* Scene JSON into the scene: every value arrives where it belongs. */
#include "json_group.h"
#include "scene/light_groups.h"

#define SPHERE "{\"type\": \"sphere\", \"center\": [1, 2, 3], \"radius\": 4}"

/* The document with these objects. */
static fathom_scene *with_objects(const char *objects) {
    return json_scene_good(&s,
                           unit_text("{\"materials\": {\"m\": {}, \"n\": {}}, \"objects\": [%s]}", objects));
}

static void assert_numbers(const double *found, const double *expected, size_t count) {
    /* Values of a handful of roundings on numbers up to 10. */
    for (size_t i = 0; i < count; ++i) assert_near(found[i], expected[i], 16 * 0x1p-53 * 10);
}

static void assert_floats(const float *found, const double *expected, size_t count) {
    for (size_t i = 0; i < count; ++i) assert_near(found[i], expected[i], fabs(expected[i]) * 0x1p-24);
}

UNIT_TEST(surroundings) {
    fathom_scene *scene =
        json_scene_good(&s, "{\"$schema\": \"./x\", \"name\": \"a \\u00e9\", "
                            "\"background\": [0.25, 0.5, 7], \"ambient\": [1, 2, 3],"
                            "\"image\": {\"width\": 11, \"height\": 12, \"spp\": 5, "
                            "\"pattern\": \"sobol\", \"seed\": 9007199254740991,"
                            "\"crop\": [1, 2, 3, 4], \"maxDepth\": 0, \"minWeight\": 0.5, "
                            "\"epsilon\": 1e-5, \"terminatorFix\": false,"
                            "\"aovs\": [\"id\", \"alpha\"]}, \"lights\": [], \"objects\": []}");
    fathom_settings expected = default_settings();
    expected.width = 11, expected.height = 12, expected.spp = 5, expected.target_error = 0;
    expected.seed = 9007199254740991, expected.max_depth = 0, expected.min_weight = 0.5f;
    expected.epsilon = 1e-5, expected.terminator_fix = false,
    expected.aovs = FATHOM_AOV_ID | FATHOM_AOV_ALPHA;
    memcpy(expected.crop, (uint32_t[4]){1, 2, 3, 4}, sizeof expected.crop);
    const fathom_settings *found = &scene->settings;
    assert_int_equal(found->width, expected.width);
    assert_int_equal(found->height, expected.height);
    assert_int_equal(found->spp, expected.spp);
    assert_int_equal(found->pattern, expected.pattern);
    assert_true(found->seed == expected.seed);
    assert_memory_equal(found->crop, expected.crop, sizeof expected.crop);
    assert_int_equal(found->max_depth, 0);
    assert_true(found->min_weight == 0.5f && found->epsilon == 1e-5 && !found->terminator_fix);
    assert_int_equal(found->aovs, expected.aovs);
    assert_string_equal(scene->name, "a \xc3\xa9");
    assert_floats(scene->background, (double[]){0.25, 0.5, 7}, 3);
    assert_floats(scene->ambient, (double[]){1, 2, 3}, 3);
    assert_true(scene->has_ambient && scene->has_lights && !scene->has_camera);
}

/* Absent is not the same as empty: only then is the scene completed. */
UNIT_TEST(absent_parts) {
    fathom_scene *scene = json_scene_good(&s, "{\"objects\": []}");
    fathom_settings defaults = default_settings();
    assert_false(scene->has_ambient || scene->has_lights || scene->has_camera);
    assert_int_equal(scene->settings.width, defaults.width);
    assert_int_equal(scene->settings.spp, defaults.spp);
}

static fathom_settings settings_of(const char *image) {
    fathom_scene *scene =
        json_scene_good(&s, unit_text("{\"image\": {%s}, \"lights\": [], \"objects\": []}", image));
    const fathom_settings found = scene->settings;
    return found;
}

UNIT_TEST(the_integrator_decides_what_is_not_given) {
    fathom_settings found = settings_of("");
    assert_true(found.integrator == FATHOM_INTEGRATOR_PATH && found.pattern == FATHOM_PATTERN_SOBOL);
    assert_true(found.spp == 1024 && found.target_error == 0.02 && found.max_depth == 16);
    found = settings_of("\"integrator\": \"classic\"");
    assert_true(found.integrator == FATHOM_INTEGRATOR_CLASSIC && found.pattern == FATHOM_PATTERN_GRID);
    assert_true(found.spp == 1 && !(found.target_error > 0) && found.max_depth == 8);
    /* So many samples everywhere. */
    found = settings_of("\"spp\": 9");
    assert_true(found.spp == 9 && !(found.target_error > 0));
    found = settings_of("\"pattern\": \"grid\"");
    assert_true(found.pattern == FATHOM_PATTERN_GRID && !(found.target_error > 0));
    found = settings_of("\"spp\": 64, \"targetError\": 0.1");
    assert_true(found.spp == 64 && found.target_error == 0.1);
}

static fathom_camera camera_of(const char *camera) {
    fathom_scene *scene = json_scene_good(&s, unit_text("{\"camera\": %s, \"objects\": []}", camera));
    assert_true(scene->has_camera);
    fathom_camera out = scene->camera;
    return out;
}

UNIT_TEST(cameras) {
    fathom_camera c = camera_of("{\"eye\": [1, 2, 5], \"target\": [1, 2, 0], \"fovy\": 90}");
    assert_numbers(c.origin, (double[]){1, 2, 5}, 3);
    assert_numbers(c.x, (double[]){1, 0, 0}, 3);
    assert_numbers(c.y, (double[]){0, 1, 0}, 3);
    assert_numbers(c.z, (double[]){0, 0, 1}, 3);
    /* tan 45° = 1 */
    assert_numbers((double[]){c.d, c.h, c.w}, (double[]){1, 2, 0}, 3);
    c = camera_of(
        "{\"eye\": [1, 2, 5], \"target\": [1, 2, 0], \"up\": [1, 0, 0], \"d\": 3, \"w\": 4, \"h\": 5}");
    assert_numbers(c.y, (double[]){1, 0, 0}, 3);
    assert_numbers((double[]){c.d, c.h, c.w}, (double[]){3, 5, 4}, 3);
    c = camera_of("{\"frame\": {\"origin\": [7, 8, 9], \"z\": [0, 2, 0], \"y\": [0, 1, -3]}}");
    assert_numbers(c.origin, (double[]){7, 8, 9}, 3);
    assert_numbers(c.z, (double[]){0, 1, 0}, 3);
    assert_numbers(c.y, (double[]){0, 0, -1}, 3);
    assert_numbers(c.x, (double[]){1, 0, 0}, 3);
    /* 45 degrees */
    assert_numbers((double[]){c.d, c.h}, (double[]){1, 2 * (sqrt(2) - 1)}, 2);
}

UNIT_TEST(materials) {
    fathom_scene *scene = json_scene_good(
        &s, "{\"materials\": {\"plain\": {}, \"all\": {\"kd\": [0.1, 0.2, 0.3], \"ks\": [1, 2, 3], \"kr\": "
            "[0.4, 0.5, 0.6],"
            "\"kt\": [0.7, 0.8, 0.9], \"ka\": [0, 0.5, 1], \"ke\": [4, 5, 6], \"shininess\": 7, \"ior\": 8,"
            "\"specular\": \"phong\", \"fresnel\": true, \"litFromBehind\": true}}, \"objects\": []}");
    assert_int_equal(scene->materials.count, 3);
    assert_string_equal(scene->materials.items[1].name, "plain");
    fathom_material defaults, *m = &scene->materials.items[1].value;
    fathom_material_default(&defaults);
    assert_memory_equal(m, &defaults, offsetof(fathom_material, fresnel));
    assert_true(m->fresnel == defaults.fresnel && m->lit_from_behind == defaults.lit_from_behind);
    m = &scene->materials.items[2].value;
    assert_floats(m->k_d, (double[]){0.1, 0.2, 0.3}, 3);
    assert_floats(m->k_s, (double[]){1, 2, 3}, 3);
    assert_floats(m->k_r, (double[]){0.4, 0.5, 0.6}, 3);
    assert_floats(m->k_t, (double[]){0.7, 0.8, 0.9}, 3);
    assert_floats(m->k_a, (double[]){0, 0.5, 1}, 3);
    assert_floats(m->k_e, (double[]){4, 5, 6}, 3);
    assert_true(m->shininess == 7 && m->ior == 8 && m->specular == FATHOM_SPECULAR_PHONG);
    assert_true(m->fresnel && m->lit_from_behind);
}

UNIT_TEST(lights) {
    fathom_scene *scene = json_scene_good(
        &s, "{\"lights\": [{\"type\": \"point\", \"position\": [1, 2, 3], \"color\": [1, 0.5, 0], "
            "\"intensity\": 4},"
            "{\"type\": \"directional\", \"direction\": [0, -2, 0]},"
            "{\"type\": \"spot\", \"position\": [1, 2, 3], \"target\": [1, 0, 3], \"innerAngle\": 30, "
            "\"outerAngle\": 60},"
            "{\"type\": \"spot\", \"position\": [1, 2, 3], \"direction\": [1, 0, 0]}], \"objects\": []}");
    const fathom_light *l = scene->lights.items;
    const double degree = 0.017453292519943295;
    assert_int_equal(scene->lights.count, 4);
    assert_int_equal(l[0].type, FATHOM_LIGHT_POINT);
    assert_numbers(l[0].position, (double[]){1, 2, 3}, 3);
    assert_floats(l[0].intensity, (double[]){4, 2, 0}, 3);
    assert_int_equal(l[1].type, FATHOM_LIGHT_DIRECTIONAL);
    assert_numbers(l[1].direction, (double[]){0, -2, 0}, 3);
    assert_floats(l[1].intensity, (double[]){1, 1, 1}, 3);
    assert_int_equal(l[2].type, FATHOM_LIGHT_SPOT);
    assert_numbers(l[2].direction, (double[]){0, -2, 0}, 3);
    assert_floats((float[]){l[2].inner_angle, l[2].outer_angle}, (double[]){30 * degree, 60 * degree}, 2);
    assert_numbers(l[3].direction, (double[]){1, 0, 0}, 3);
    assert_floats((float[]){l[3].inner_angle, l[3].outer_angle}, (double[]){0, 45 * degree}, 2);
}

UNIT_TEST(shapes) {
    fathom_scene *scene = with_objects(
        SPHERE ", {\"type\": \"quad\", \"center\": [0, 0, 1], \"u\": [2, 0, 0], \"v\": [0, 3, 0], "
               "\"material\": \"n\"},"
               "{\"type\": \"quad\", \"corners\": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]},"
               "{\"type\": \"plane\", \"point\": [1, 2, 3], \"normal\": [0, 5, 0], \"castsShadow\": false}");
    assert_int_equal(scene->objects.count, 4);
    const fathom_sphere *sphere = scene->spheres.items;
    assert_numbers(sphere->center, (double[]){1, 2, 3}, 3);
    assert_true(sphere->radius == 4 && sphere->material == 0 && sphere->flags == 0);
    const fathom_quad *quad = scene->quads.items;
    assert_numbers(&quad[0].corners[0][0], (double[]){-2, -3, 1, 2, -3, 1, 2, 3, 1, -2, 3, 1}, 12);
    assert_int_equal(quad[0].material, 2);
    assert_numbers(&quad[1].corners[0][0], (double[]){0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, 12);
    const fathom_plane *plane = scene->planes.items;
    assert_numbers(plane->point, (double[]){1, 2, 3}, 3);
    assert_numbers(plane->normal, (double[]){0, 5, 0}, 3);
    assert_int_equal(plane->flags, FATHOM_CASTS_NO_SHADOW);
}

#define TRIANGLE "{\"type\": \"triangle\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]"

/* Triangles that follow each other become one mesh, as long as nothing about them differs. */
UNIT_TEST(loose_triangles) {
    fathom_scene *scene =
        with_objects(TRIANGLE "}, " TRIANGLE "}, " TRIANGLE ", \"material\": \"m\"}, " TRIANGLE
                              ", \"material\": \"m\", \"castsShadow\": false}," SPHERE "," TRIANGLE
                              "}, " TRIANGLE ", \"uvs\": [[0, 0], [1, 0], [0, 1]]}, " TRIANGLE
                              ", \"normals\": [[0, 0, 1], [0, 1, 0], [1, 0, 0]]}");
    const uint32_t triangles[] = {2, 1, 1, 1, 1, 1};
    assert_int_equal(scene->meshes.count, 6);
    for (size_t i = 0; i < 6; ++i) assert_int_equal(scene->meshes.items[i].triangle_count, triangles[i]);
    const fathom_mesh *m = scene->meshes.items;
    assert_int_equal(m[1].material, 1);
    assert_int_equal(m[2].flags, FATHOM_CASTS_NO_SHADOW);
    assert_null(m[3].uvs);
    assert_floats(m[4].uvs, (double[]){0, 0, 1, 0, 0, 1}, 6);
    assert_floats(m[5].normals, (double[]){0, 0, 1, 0, 1, 0, 1, 0, 0}, 9);
    /* In the order of the document. */
    assert_int_equal(scene->objects.items[3].kind, SCENE_SPHERE);
}

#define ARRAYS                                                                                               \
    "\"positions\": [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]], \"indices\": [[0, 1, 2], [0, 2, 3]]"
#define NORMALS "\"normals\": [[1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]]"

UNIT_TEST(meshes) {
    fathom_scene *scene =
        with_objects("{\"type\": \"mesh\", " ARRAYS "}, {\"type\": \"mesh\", " ARRAYS ", " NORMALS "},"
                     "{\"type\": \"mesh\", \"shading\": \"flat\", " ARRAYS ", " NORMALS "},"
                     "{\"type\": \"mesh\", \"shading\": \"smooth\", " ARRAYS "},"
                     "{\"type\": \"mesh\", \"shading\": \"smooth\", " ARRAYS ", " NORMALS "},"
                     "{\"type\": \"mesh\", \"file\": \"triangle.obj\", \"material\": \"n\"}");
    const fathom_mesh *m = scene->meshes.items;
    assert_int_equal(scene->meshes.count, 6);
    assert_floats(m[0].positions, (double[]){0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0}, 12);
    assert_memory_equal(m[0].indices, ((uint32_t[]){0, 1, 2, 0, 2, 3}), 6 * sizeof(uint32_t));
    assert_true(!m[0].normals && m[1].normals && !m[2].normals && m[3].normals && m[4].normals);
    assert_floats(m[1].normals, (double[]){1, 0, 0}, 3);
    assert_floats(m[3].normals, (double[]){0, 0, 1}, 3);
    assert_floats(m[4].normals, (double[]){1, 0, 0}, 3);
    assert_int_equal(m[5].triangle_count, 1);
    assert_int_equal(m[5].material, 2);
}

/* Smooth shading makes the normals of each vertex key from its positions, unless the key has some. */
UNIT_TEST(vertex_keys) {
    static const double flat[12] = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0};
    static const double upright[12] = {0, 0, 0, 2, 0, 0, 2, 0, 2, 0, 0, 2};
#define UPRIGHT "\"positions\": [[0, 0, 0], [2, 0, 0], [2, 0, 2], [0, 0, 2]]"
#define FLAT "\"positions\": [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]"
    fathom_scene *scene =
        with_objects("{\"type\": \"mesh\", \"shading\": \"smooth\", " ARRAYS
                     ", \"vertexKeys\": [{\"time\": 1, " FLAT "}, {\"time\": 3, " UPRIGHT "}]},"
                     "{\"type\": \"mesh\", " ARRAYS ", " NORMALS ", \"vertexKeys\": [{\"time\": 1, " FLAT
                     ", " NORMALS "}, {\"time\": 3, " UPRIGHT ", " NORMALS "}]},"
                     "{\"type\": \"mesh\", " ARRAYS ", \"vertexKeys\": [{\"time\": 1, " FLAT
                     "}, {\"time\": 3, " UPRIGHT "}]}");
    const fathom_mesh *m = scene->meshes.items;
    assert_int_equal(scene->meshes.count, 3);
    for (int i = 0; i < 3; ++i) {
        assert_int_equal(m[i].key_count, 2);
        assert_numbers(m[i].key_times, (double[]){1, 3}, 2);
        assert_floats(m[i].key_positions, flat, 12);
        assert_floats(m[i].key_positions + 12, upright, 12);
        for (size_t k = 0; k < 8 && i < 2; ++k) {
            const double turned = k < 4 ? 0 : -1, up = k < 4 ? 1 : 0;
            assert_floats(m[i].key_normals + 3 * k, i == 0 ? (double[]){0, turned, up} : (double[]){1, 0, 0},
                          3);
        }
    }
    assert_null(m[2].key_normals);
}

/* Far out the float vertices are counted from nearby, so that a millimetre at 1e7 metres is still there. */
UNIT_TEST(far_mesh) {
    fathom_scene *scene = with_objects("{\"type\": \"mesh\", \"positions\": [[1e7, 0, 0], [10000001, 0, 0], "
                                       "[1e7, 0.001, 0]], \"indices\": [[0, 1, 2]]}");
    const fathom_mesh *m = scene->meshes.items;
    for (int i = 0; i < 3; ++i) {
        const double expected[3][3] = {{1e7, 0, 0}, {1e7 + 1, 0, 0}, {1e7, 0.001, 0}};
        for (int k = 0; k < 3; ++k) {
            /* Half a float's last place at the mesh's size of 1, and one of double at 1e7. */
            assert_near(m->origin[k] + (double)m->positions[3 * i + k], expected[i][k],
                        0x1p-25 + 1e7 * 0x1p-53);
        }
    }
}

UNIT_TEST(generated) {
    fathom_scene *scene =
        with_objects("{\"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": 500, \"material\": "
                     "\"m\", \"castsShadow\": false}");
    assert_true(scene->meshes.count == 1 && scene->meshes.items[0].triangle_count > 100);
    assert_int_equal(scene->meshes.items[0].material, 1);
    assert_int_equal(scene->meshes.items[0].flags, FATHOM_CASTS_NO_SHADOW);
}

/* ---- placement ---- */

/* Where a point of the placed sphere's own space lands. */
static vec3_f64 landed(const char *placement, vec3_f64 p) {
    fathom_scene *scene = with_objects(
        unit_text("{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1, %s}", placement));
    assert_int_equal(scene->instances.count, 1);
    assert_int_equal(scene->objects.items[0].group, scene->instances.items[0].group);
    assert_int_not_equal(scene->objects.items[0].group, FATHOM_ROOT);
    affine_f64 map;
    affine_load(&map, scene->instances.items[0].transform);
    return affine_point(&map, p);
}

static void assert_lands(const char *placement, double x, double y, double z) {
    vec3_f64 p = landed(placement, (vec3_f64){1, 2, 3});
    assert_numbers((double[]){p.x, p.y, p.z}, (double[]){x, y, z}, 3);
}

/* The point (1, 2, 3), by hand. */
UNIT_TEST(placements) {
    assert_lands("\"translation\": [10, 20, 30]", 11, 22, 33);
    assert_lands("\"scale\": [2, 3, -1]", 2, 6, -3);
    assert_lands("\"rotate\": {\"axis\": [0, 0, 5], \"angle\": 90}", -2, 1, 3);
    assert_lands("\"rotation\": [0, 0, 0.5, 0.5]", -2, 1, 3);
    assert_lands(
        "\"scale\": [2, 1, 1], \"rotate\": {\"axis\": [0, 0, 1], \"angle\": 90}, \"translation\": [10, 0, 0]",
        8, 2, 3);
    assert_lands("\"frame\": {\"origin\": [10, 0, 0], \"z\": [1, 0, 0], \"y\": [0, 1, 0]}", 13, 2, -1);
    assert_lands("\"frame\": {\"origin\": [10, 0, 0], \"z\": [1, 0, 0]}, \"scale\": [1, 1, 2]", 16, 2, -1);
    assert_lands("\"matrix\": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1]", 8, 21, 33);
}

UNIT_TEST(groups) {
    fathom_scene *scene = json_scene_good(&s, "{\"materials\": {\"m\": {}}, \"groups\": {\"a\": [{\"type\": "
                                              "\"instance\", \"of\": \"b\"}], \"b\": [" SPHERE "]},"
                                              "\"objects\": [{\"type\": \"instance\", \"of\": \"a\", "
                                              "\"material\": \"m\"}, {\"type\": \"group\", \"name\": \"g\","
                                              "\"translation\": [1, 0, 0], \"children\": [" SPHERE
                                              ", {\"type\": \"group\", \"children\": [" SPHERE "]}]}]}");
    /* Groups: world, a, b, g and the unnamed one in it. */
    assert_int_equal(scene->groups.count, 5);
    assert_string_equal(scene->groups.items[3], "g");
    assert_null(scene->groups.items[4]);
    const struct {
        fathom_id group, parent, material;
    } expected[] = {{2, 1, FATHOM_NONE}, {1, 0, 1}, {3, 0, FATHOM_NONE}, {4, 3, FATHOM_NONE}};
    assert_int_equal(scene->instances.count, 4);
    for (size_t i = 0; i < 4; ++i) {
        const fathom_instance *instance = &scene->instances.items[i];
        assert_int_equal(instance->group, expected[i].group);
        assert_int_equal(instance->parent, expected[i].parent);
        assert_int_equal(instance->material, expected[i].material);
    }
    const fathom_id homes[] = {2, 3, 4};
    for (size_t i = 0; i < 3; ++i) assert_int_equal(scene->objects.items[i].group, homes[i]);
}

/* The published example is read, complete, and passes the scene's own checks. */
UNIT_TEST(example) {
    fathom_scene *scene = scene_of_file(s.context, SOURCE_DIR "/scenes/example.json");
    assert_true(scene->has_camera && scene->has_lights && scene->meshes.count >= 4);
}

/* Any file will do: what is in it is looked at before rendering. */
#define IMAGE "\"file\": \"triangle.obj\""

UNIT_TEST(textures) {
    fathom_scene *scene = json_scene_good(
        &s,
        "{\"materials\": {\"m\": {\"model\": \"metallicRoughness\", \"baseColorTexture\": {" IMAGE
        ", \"scale\": [2, 3], \"rotation\": 90, \"offset\": [0.25, 0.5], \"uvSet\": 1, \"wrapU\": \"clamp\","
        " \"wrapV\": \"mirror\", \"filter\": \"nearest\"}, \"metallicRoughnessTexture\": {" IMAGE
        "}, \"opacityTexture\": {" IMAGE ", \"channel\": \"a\"}, \"normalScale\": 0.5},"
        "\"n\": {\"kdTexture\": {" IMAGE ", \"colorSpace\": \"linear\"}, \"keTexture\": {" IMAGE
        ", \"colorSpace\": \"ACEScg\"}}}, \"objects\": [" SPHERE "]}");
    const fathom_map *m = scene->materials.items[1].value.maps, *n = scene->materials.items[2].value.maps;
    const fathom_texture *t = scene->textures.items;
    assert_floats(m[FATHOM_MAP_COLOR].transform + 1, (double[]){3, 0.25, -2}, 3);
    assert_near(m[FATHOM_MAP_COLOR].transform[0], 0, 1e-6);
    assert_near(m[FATHOM_MAP_COLOR].transform[5], 0.5, 0);
    assert_int_equal(m[FATHOM_MAP_COLOR].uv_set, 1);
    assert_int_equal(t[m[FATHOM_MAP_COLOR].texture].color_space, FATHOM_COLOR_AUTO);
    assert_int_equal(t[m[FATHOM_MAP_COLOR].texture].wrap_u, FATHOM_WRAP_CLAMP);
    assert_int_equal(t[m[FATHOM_MAP_COLOR].texture].wrap_v, FATHOM_WRAP_MIRROR);
    assert_int_equal(t[m[FATHOM_MAP_COLOR].texture].filter, FATHOM_TEXTURE_NEAREST);
    assert_true(m[FATHOM_MAP_METALLIC].channel == 2 && m[FATHOM_MAP_ROUGHNESS].channel == 1);
    assert_int_equal(m[FATHOM_MAP_METALLIC].texture, m[FATHOM_MAP_ROUGHNESS].texture);
    assert_int_equal(t[m[FATHOM_MAP_METALLIC].texture].color_space, FATHOM_COLOR_LINEAR);
    assert_int_equal(m[FATHOM_MAP_OPACITY].channel, 3);
    assert_true(scene->materials.items[1].value.normal_scale == 0.5f);
    assert_int_equal(t[n[FATHOM_MAP_COLOR].texture].color_space, FATHOM_COLOR_LINEAR);
    assert_int_equal(t[n[FATHOM_MAP_EMISSIVE].texture].color_space, FATHOM_COLOR_NAMED);
    assert_string_equal(t[n[FATHOM_MAP_EMISSIVE].texture].color_space_name, "ACEScg");
    json_scene_bad(&s, "{\"materials\": {\"m\": {\"kdTexture\": {\"file\": \"no.png\"}}}, \"objects\": []}",
                   "materials.m.kdTexture.file");
}

/* Triangles that follow each other become a mesh, but only those of one group. */
UNIT_TEST(light_groups_of_every_source) {
    fathom_scene *scene = json_scene_good(
        &s, "{\"background\": [1, 1, 1], \"backgroundGroup\": \"sky\","
            "\"materials\": {\"lamp\": {\"ke\": [1, 1, 1], \"group\": \"key\"}},"
            "\"lights\": [{\"type\": \"sun\", \"direction\": [0, -1, 0], \"group\": \"sun\"},"
            " {\"type\": \"point\", \"position\": [0, 0, 0]}],"
            "\"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1, \"group\": \"key\"},"
            "{\"type\": \"triangle\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], \"group\": \"a\"},"
            "{\"type\": \"triangle\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], \"group\": \"b\"}]}");
    light_groups groups;
    assert_ok(scene->context, light_groups_create(scene, &groups));
    assert_int_equal(groups.count, 6); /* the rest, key, sun, sky, a, b in some order */
    static const char *const expected[] = {"sky", "key", "sun", "key", "a", "b"};
    const uint8_t found[] = {groups.of[FATHOM_SOURCE_BACKGROUND][0], groups.of[FATHOM_SOURCE_MATERIAL][1],
                             groups.of[FATHOM_SOURCE_LIGHT][0],      groups.of[FATHOM_SOURCE_OBJECT][0],
                             groups.of[FATHOM_SOURCE_OBJECT][1],     groups.of[FATHOM_SOURCE_OBJECT][2]};
    for (int i = 0; i < 6; ++i) assert_string_equal(scene->light_groups.names[found[i]], expected[i]);
    assert_int_equal(groups.of[FATHOM_SOURCE_LIGHT][1], 0);
    light_groups_destroy(&groups);
}

int main(void) { return unit_main(setup, teardown); }
