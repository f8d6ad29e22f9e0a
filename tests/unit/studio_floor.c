/* Models without a camera stand on the floor of the studio, or on a plate in an image of the sky. */
#include "owned.h"
#include "scene/scene.h"
#include "unit_folder.h"

#include <fathom/fathom.h>

static fathom_read_options options;

/* A leaning rod of three triangles, whose lowest point is (0, -2, 0.5). */
static int write_model(void **state) {
    (void)state;
    FILE *file = fopen(in_folder("rod.obj"), "w");
    if (!file) return -1;
    fputs("v 0 -2 0.5\nv 1 3 0\nv -1 3 0\nv 0 3 1\nf 1 2 3\nf 1 3 4\nf 1 4 2\n", file);
    if (fclose(file) != 0 || !(file = fopen(in_folder("sky.pfm"), "wb"))) return -1;
    fputs("PF\n2 1\n-1.0\n", file);
    fwrite((float[6]){1, 1, 1, 1, 1, 1}, sizeof(float), 6, file);
    fathom_read_options_default(&options);
    options.floor = true, options.width = options.height = 16;
    return fclose(file);
}

static fathom_scene *read_model(void) {
    fathom_scene *scene;
    assert_ok(context, fathom_scene_read_with(context, in_folder("rod.obj"), &options, &scene));
    return own_scene(scene);
}

static bool has(const fathom_scene *scene, const char *name) {
    bool found = false;
    for (size_t i = 0; i < scene->objects.count; ++i)
        found |= scene->objects.items[i].name && strcmp(scene->objects.items[i].name, name) == 0;
    return found;
}

static bool has_floor(const fathom_scene *scene) { return has(scene, "studio floor") || has(scene, "plate"); }

/* The floor lies 2^-10 radii below the lowest point. Stored in float, it is off by some 2^-24 of its size,
 * which is below 64 radii. */
UNIT_TEST(the_lowest_point_touches_it) {
    for (int k = 0; k < 4; ++k) {
        const int z = k % 2;
        options.up = z ? FATHOM_UP_Z : FATHOM_UP_Y;
        options.environment = k / 2 ? in_folder("sky.pfm") : NULL;
        fathom_scene *scene = read_model();
        assert_true(has(scene, k / 2 ? "plate" : "studio floor"));
        const fathom_mesh *floor = &scene->meshes.items[scene->meshes.count - 1];
        const double lowest = z ? 0 : -2, radius = sqrt(4 + 25 + 1) / 2;
        double level = INFINITY;
        for (size_t i = 0; i < floor->vertex_count; ++i)
            level = fmin(level, floor->origin[1 + z] + (double)mesh_vertex(floor, i)[1 + z]);
        assert_true(fabs(lowest - level - 0x1p-10 * radius) < 64 * 0x1p-24 * radius);
    }
}

/* Every sample meets the model or the floor, whatever the image's shape. */
UNIT_TEST(the_image_shows_nothing_beyond_it) {
    static const uint32_t shapes[][2] = {{16, 16}, {96, 16}, {16, 96}};
    for (size_t k = 0; k < sizeof shapes / sizeof *shapes; ++k) {
        options.width = shapes[k][0], options.height = shapes[k][1];
        fathom_scene *scene = read_model();
        fathom_settings s;
        fathom_film *film;
        fathom_scene_settings(scene, &s);
        s.width = shapes[k][0], s.height = shapes[k][1], s.spp = 4, s.target_error = 0,
        s.aovs = FATHOM_AOV_ALPHA;
        assert_ok(context, fathom_render(context, scene, &s, NULL, NULL, NULL, &film));
        const float *alpha = fathom_film_channel(film, "A");
        for (uint32_t i = 0; i < s.width * s.height; ++i) assert_true(alpha[i] == 1);
        fathom_film_destroy(film);
    }
}

/* From 1 to 2.2 of the model's radii: whole within, gone without, and the share between falls all the way. */
UNIT_TEST(the_plate_fades) {
    options.environment = in_folder("sky.pfm");
    fathom_scene *scene = read_model();
    const fathom_mesh *plate = &scene->meshes.items[scene->meshes.count - 1];
    const double radius = sqrt(4 + 25 + 1) / 2,
                 middle[2] = {0, 0.5}; /* of the rod's bounds, seen from above */
    uint32_t whole = 0, none = 0, between = 0;
    assert_int_equal(plate->color_channels, 4);
    for (size_t i = 0; i < plate->vertex_count; ++i) {
        const float *at = mesh_vertex(plate, i), opacity = plate->colors[4 * i + 3];
        const double away = hypot((double)at[0] + plate->origin[0] - middle[0],
                                  (double)at[2] + plate->origin[2] - middle[1]) /
                            radius;
        if (away < 0.999) whole += opacity == 1;
        if (away < 0.999) assert_true(opacity == 1);
        if (away > 2.201) none += opacity == 0;
        if (away > 2.201) assert_true(opacity == 0);
        if (away > 1.1 && away < 2.1) between += opacity > 0 && opacity < 1;
        if (away > 1.1 && away < 2.1) assert_true(opacity > 0 && opacity < 1);
    }
    assert_true(whole && none && between);
}

static void assert_floorless(void) {
    fathom_scene *scene = read_model();
    assert_false(has_floor(scene));
}

UNIT_TEST(a_camera_below_sees_none) {
    options.choose_elevation = true, options.elevation = -0.5;
    assert_floorless();
    options.elevation = 1.5;
    assert_true(has_floor(read_model()));
}

UNIT_TEST(only_whoever_asks_gets_one) {
    options.floor = false;
    assert_floorless();
    options.floor = true, options.choose_integrator = true, options.integrator = FATHOM_INTEGRATOR_CLASSIC;
    assert_floorless();
}

/* Scenes that bring a camera, a light or a background are as their authors made them. */
UNIT_TEST(scenes_of_their_own_have_none) {
    static const char *const brought[] = {"\"camera\": { \"eye\": [0, 0, 9], \"target\": [0, 0, 0] }",
                                          "\"background\": [1, 1, 1]", "\"lights\": []",
                                          "\"name\": \"bare\""};
    for (size_t i = 0; i < 4; ++i) {
        fathom_scene *scene;
        FILE *file = fopen(in_folder("scene.json"), "w");
        assert_non_null(file);
        fprintf(file,
                "{ %s, \"objects\": [ { \"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1 } ] }",
                brought[i]);
        assert_int_equal(fclose(file), 0);
        assert_ok(context, fathom_scene_read_with(context, in_folder("scene.json"), &options, &scene));
        assert_true(has_floor(scene) == (i == 3));
        fathom_scene_destroy(scene);
    }
}

int main(void) {
    unit_each(write_model, NULL);
    return unit_main(open_folder, remove_folder);
}
