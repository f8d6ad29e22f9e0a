/* Scene JSON: values that have several forms, or that depend on their neighbours in the list. */
#include "json_group.h"
#include "scene/motion/motion.h"

#define TRIANGLE(more) "{\"type\": \"triangle\", \"vertices\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]]" more "}"

/* Neighbours of one name are one mesh; a neighbour of another name takes nothing from it. */
UNIT_TEST(loose_triangles_keep_their_own_names) {
    fathom_scene *scene = json_scene_good(
        &s, "{\"objects\": [" TRIANGLE(", \"name\": \"a\"") "," TRIANGLE(", \"name\": \"a\"") "," TRIANGLE(
                ", \"name\": \"b\"") "," TRIANGLE("") "," TRIANGLE(", \"name\": \"c\"") "]}");
    const char *const names[] = {"a", "b", NULL, "c"};
    assert_int_equal(scene->objects.count, 4);
    for (size_t i = 0; i < 4; ++i) {
        const char *found = scene->objects.items[i].name;
        if (!names[i] != !found || (found && strcmp(found, names[i]) != 0))
            fail_msg("object %zu is called \"%s\", expected \"%s\"", i, found ? found : "",
                     names[i] ? names[i] : "");
    }
    assert_int_equal(scene->meshes.items[0].triangle_count, 2);
}

/* The radius is focalLength / (2 fStop), and the focus is at the target unless a distance is given. */
UNIT_TEST(lenses_follow_f_stops) {
    static const struct {
        const char *more;
        double distance;
    } cases[] = {{"", 5}, {", \"focusDistance\": 3", 3}};
    for (size_t i = 0; i < 2; ++i) {
        fathom_scene *scene = json_scene_good(
            &s,
            unit_text(
                "{\"camera\": {\"eye\": [0, 0, 5], \"target\": [0, 0, 0], \"focalLength\": 0.5, \"fStop\": 2"
                "%s}, \"objects\": []}",
                cases[i].more));
        assert_true(scene->camera.lens_radius == 0.125);
        assert_true(scene->camera.focus_distance == cases[i].distance);
    }
    json_scene_bad(&s,
                   "{\"camera\": {\"frame\": {\"origin\": [0, 0, 5], \"z\": [0, 0, 1]}, \"focalLength\": 1, "
                   "\"fStop\": 2}, \"objects\": []}",
                   "a lens needs \"focusDistance\", or \"eye\" and \"target\"");
}

/* What is stored is the radiance of a white diffuser: a pi-th of the irradiance. */
UNIT_TEST(units_of_lights_are_pi_times_intensities) {
    fathom_scene *scene = json_scene_good(
        &s, "{\"lights\": [{\"type\": \"point\", \"position\": [0, 0, 1], \"color\": [1, 0.5, 0], "
            "\"radiantIntensity\": 4},"
            "{\"type\": \"spot\", \"position\": [0, 0, 1], \"direction\": [0, 0, -1], "
            "\"radiantIntensity\": 2},"
            "{\"type\": \"directional\", \"direction\": [0, -2, 0], \"irradiance\": 3},"
            "{\"type\": \"sun\", \"direction\": [0, -2, 0], \"irradiance\": 6}], \"objects\": []}");
    const double expected[4][2] = {{4, 2}, {2, 2}, {3, 3}, {6, 6}};
    assert_int_equal(scene->lights.count, 4);
    for (size_t i = 0; i < 4; ++i) {
        /* A quotient and a product in double, rounded to float below 2. */
        for (size_t c = 0; c < 2; ++c)
            assert_near(scene->lights.items[i].intensity[c], expected[i][c] / 3.14159265358979324, 0x1p-24);
    }
}

/* One key is a place: at any time, and for the camera as well. */
UNIT_TEST(motion_of_one_key_is_a_place) {
    fathom_scene *scene = json_scene_good(
        &s, "{\"camera\": {\"shutter\": [0, 1], \"motion\": [{\"time\": 7, \"eye\": [1, 2, 5], \"target\": "
            "[1, 2, "
            "0]}]}, \"objects\": [{\"type\": \"sphere\", \"center\": [1, 0, 0], \"radius\": 1, \"motion\": "
            "[{\"time\": 7, \"translation\": [1, 2, 3], \"scale\": [2, 2, 2]}]}]}");
    const fathom_instance *it = &scene->instances.items[0];
    assert_int_equal(it->key_count, 1);
    for (int t = 6; t < 9; ++t) {
        const affine_f64 map = motion_place(it, t);
        const vec3_f64 center = affine_point(&map, (vec3_f64){1, 0, 0});
        assert_true(center.x == 3 && center.y == 2 && center.z == 3);
        const fathom_camera camera = motion_camera(&scene->camera, t);
        assert_true(camera.origin[0] == 1 && camera.origin[1] == 2 && camera.origin[2] == 5);
        assert_true(camera.z[2] == 1 && camera.y[1] == 1);
    }
    assert_false(motion_is_moving(it, (double[2]){0, 10}));
    assert_false(motion_camera_moves(&scene->camera));
}

/* Colours, opacities, both uvs and tangents, each from its own list, with the key that moves them. */
UNIT_TEST(arrays_of_moving_meshes_stay_apart) {
    fathom_scene *scene = json_scene_good(
        &s,
        "{\"objects\": [{\"type\": \"mesh\", \"positions\": [[0, 0, 0], [1, 0, 0], [0, 1, 0]], \"indices\": "
        "[[0, 1, 2]], \"normals\": [[0, 0, 1], [0, 0, 1], [0, 0, 1]], \"colors\": [[0.25, 0.5, 0.75], [0.25, "
        "0.5, 0.75], [0.25, 0.5, 0.75]], \"opacities\": [[0], [0.5], [1]], \"uvs\": [[1, 2], [1, 2], [1, 2]],"
        "\"uvs1\": [[3, 4], [3, 4], [3, 4]], \"tangents\": [[1, 0, 0, -1], [1, 0, 0, -1], [1, 0, 0, -1]], "
        "\"vertexKeys\": [{\"time\": 0, \"positions\": [[0, 0, 0], [0, 1, 0], [1, 0, 0]], \"normals\": [[0, "
        "0, -1], [0, 0, -1], [0, 0, -1]]}]}]}");
    const fathom_mesh *m = &scene->meshes.items[0];
    assert_int_equal(m->color_channels, 4);
    assert_int_equal(m->key_count, 1);
    for (size_t i = 0; i < 3; ++i) {
        const float *color = m->colors + 4 * i, *tangent = m->tangents + 4 * i;
        assert_true(color[0] == 0.25f && color[1] == 0.5f && color[2] == 0.75f && color[3] == (float)i / 2);
        assert_true(tangent[0] == 1 && tangent[3] == -1);
        assert_true(m->uvs[2 * i] == 1 && m->uvs_1[2 * i + 1] == 4);
        assert_true(m->normals[3 * i + 2] == 1 && m->key_normals[3 * i + 2] == -1);
        assert_true(m->key_positions[3 * i] == (i == 2) && m->key_positions[3 * i + 1] == (i == 1));
    }
}

/* A file that is right by itself is right for another integrator: what it says of samples stays, and what it
 * does not say gives way. */
UNIT_TEST(files_suit_the_integrator_asked_for) {
    static const struct {
        const char *image;
        uint32_t spp;
        double target_error;
        fathom_pattern pattern;
        bool own_spp;
    } cases[] = {
        {"", 1, 0, FATHOM_PATTERN_GRID, false},
        {"\"targetError\": 0.125", 1024, 0.125, FATHOM_PATTERN_SOBOL, false},
        {"\"targetError\": 0.125", 1, 0, FATHOM_PATTERN_GRID, true},
        {"\"targetError\": 0.125, \"spp\": 64", 64, 0.125, FATHOM_PATTERN_SOBOL, false},
        {"\"targetError\": 0.125, \"pattern\": \"sobol\"", 1024, 0.125, FATHOM_PATTERN_SOBOL, false},
        {"\"spp\": 8", 8, 0, FATHOM_PATTERN_SOBOL, false},
        {"\"spp\": 9", 9, 0, FATHOM_PATTERN_GRID, false},
        {"\"spp\": 9, \"pattern\": \"sobol\"", 9, 0, FATHOM_PATTERN_SOBOL, false},
        {"\"spp\": 8", 1, 0, FATHOM_PATTERN_GRID, true},
        {"\"pattern\": \"sobol\"", 1, 0, FATHOM_PATTERN_SOBOL, false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fathom_read_options asked = default_read_options();
        fathom_scene *scene;
        asked.choose_integrator = true, asked.integrator = FATHOM_INTEGRATOR_CLASSIC;
        asked.own_spp = cases[i].own_spp;
        const char *text = unit_text("{\"image\": {%s}, \"objects\": [" TRIANGLE("") "]}", cases[i].image);
        unit_write_file(s.file, text, strlen(text));
        assert_ok(s.context, fathom_scene_read_with(s.context, s.file, &asked, &scene));
        own_scene(scene);
        const fathom_settings *found = &scene->settings;
        if (found->spp != cases[i].spp || found->target_error != cases[i].target_error ||
            found->pattern != cases[i].pattern)
            fail_msg("{%s}: spp %u, error %g, pattern %d", cases[i].image, found->spp, found->target_error,
                     (int)found->pattern);
    }
}

/* A mesh of keys has a number of positions, but shows none of them: camera, origin and lights do not depend
 * on where they are. Its square of 2 x 2 lies at 2^26 + x, where float has steps of 8. */
UNIT_TEST(positions_beside_keys_show_nowhere) {
#define SQUARE "[[67108864, 0, 0], [67108866, 0, 0], [67108866, 2, 0], [67108864, 2, 0]]"
    static const char *const positions[] = {SQUARE, "[[0, 0, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]]",
                                            "[[-900, 0, 0], [0, 900, 0], [0, 0, 900], [5, 5, 5]]"};
    fathom_scene *scenes[3];
    for (size_t i = 0; i < 3; ++i) {
        const char *text = unit_text(
            "{\"materials\": {\"lamp\": {\"ke\": [9, 9, 9]}, \"grey\": {}}, \"objects\": [{\"type\": "
            "\"mesh\", \"material\": \"lamp\", \"positions\": %s, \"indices\": [[0, 2, 1], [0, 3, 2]], "
            "\"vertexKeys\": [{\"time\": 0, \"positions\": " SQUARE "}]}, {\"type\": \"quad\", "
            "\"material\": \"grey\", \"center\": [67108865, 0, -1], \"u\": [1, 0, 0], \"v\": [0, 1, 0]}]}",
            positions[i]);
        scenes[i] = json_scene_good(&s, text);
        assert_ok(s.context, fathom_scene_complete(scenes[i]));
        const fathom_mesh *m = &scenes[i]->meshes.items[0];
        for (uint32_t k = 0; k < 4; ++k) {
            assert_true(m->origin[0] + (double)m->key_positions[3 * k] == 67108864 + 2 * (k % 3 > 0));
            assert_true(m->key_positions[3 * k + 1] + (float)m->origin[1] == (k < 2 ? 0 : 2));
        }
        assert_memory_equal(scenes[i]->camera.origin, scenes[0]->camera.origin, 3 * sizeof(double));
        assert_memory_equal(m->origin, scenes[0]->meshes.items[0].origin, sizeof m->origin);
        assert_int_equal(scenes[i]->in_studio, scenes[0]->in_studio);
        assert_int_equal(scenes[i]->lights.count, scenes[0]->lights.count);
    }
    assert_false(scenes[0]->in_studio);
}

int main(void) { return unit_main(setup, teardown); }
