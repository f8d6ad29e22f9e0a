/* A scene of calls and the scene JSON that it becomes are one scene. */
#include "scene/scene.h"

#include "render.h"
#include "wearing.h"

/* Calls take numbers that authors of a file give only by mistake. */
UNIT_TEST(numbers_out_of_range_become_the_nearest_with_a_warning) {
    static const float colors[16] = {0, 1e31f, 0.5f, 2, 0, 0, 0, 1, 0, 0, 0, 1};
    static const char *const words[] = {
        "\"seed\" in [0, 9.00719925e+15]",  "\"kd\" in [0, 1]",
        "\"radius\" in [0, 1e+18]",         "\"background\" in [0, 1e+30]",
        "\"colors\" in [0, 1e+30]",         "\"opacities\" in [0, 1]",
        "\"positions\" in [-1e+30, 1e+30]", "\"pointRadius\" in [1e-30, 1e+30]"};
    const float far[3] = {2e30f, 0, -1e30f}, bright[3] = {1e31f, 0.1f, 0};
    fathom_material m = default_material();
    fathom_mesh mesh = triangle(0), point;
    fathom_light light = default_light();
    fathom_settings settings = default_settings();
    m.k_d[0] = 1.5f, m.k_e[0] = 1e30f;
    fathom_scene *scene = wearing(&m, NULL);
    fathom_mesh_default(&point), point.positions = far, point.vertex_count = 1, point.point_radius = 1e-31f;
    light.radius = 1e20f;
    settings.seed = UINT64_MAX;
    mesh.colors = colors, mesh.color_channels = 4;
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &mesh, NULL));
    assert_ok(context, fathom_scene_add_mesh(scene, FATHOM_ROOT, &point, NULL));
    assert_ok(context, fathom_scene_add_light(scene, &light, NULL));
    assert_ok(context, fathom_scene_set_background(scene, bright));
    assert_ok(context, fathom_scene_set_settings(scene, &settings));
    forget_warnings();
    fathom_scene *back = through(scene, JSON);
    for (size_t i = 0; i < sizeof words / sizeof *words; ++i) expect_warning(words[i]);
    fathom_scene_settings(back, &settings);
    assert_true(settings.seed == (UINT64_C(1) << 53) - 1);
    assert_true(worn(back)->k_d[0] == 1 && worn(back)->k_e[0] > 0.9999999e30f);
    assert_true(back->lights.items[0].radius == 1e18f && back->background[1] == 0.1f);
    const float *c = back->meshes.items[1].colors;
    assert_true(c[0] == 0 && c[1] > 0.9999999e30f && c[2] == 0.5f && c[3] == 1);
}

static fathom_id add_image(fathom_scene *scene, fathom_color_space space) {
    static const char pixels[] = "P6\n2 2\n255\n\x10\x40\x80\xc0\x30\x60\x90\xf0\x20\x50\x70\xb0";
    const fathom_texture texture = {
        .size = sizeof texture, .bytes = pixels, .byte_count = sizeof pixels - 1, .color_space = space};
    return new_texture(scene, &texture);
}

/* One image for a colour and for numbers, as callers that do not think of color spaces give it. */
UNIT_TEST(images_of_numbers_are_linear_unless_their_space_is_given) {
    static const fathom_map_kind kinds[] = {FATHOM_MAP_ROUGHNESS, FATHOM_MAP_NORMAL, FATHOM_MAP_BUMP,
                                            FATHOM_MAP_ANISOTROPY};
    fathom_material m = default_material();
    fathom_scene *scene = wearing(&m, NULL);
    const fathom_id found = add_image(scene, FATHOM_COLOR_AUTO), srgb = add_image(scene, FATHOM_COLOR_SRGB);
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS, m.maps[FATHOM_MAP_COLOR].texture = found;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i) m.maps[kinds[i]].texture = found;
    m.maps[FATHOM_MAP_METALLIC].texture = srgb;
    m.maps[FATHOM_MAP_OPACITY].texture = found, m.maps[FATHOM_MAP_OPACITY].channel = 3;
    const fathom_id id = new_material(scene, "mapped", &m);
    const fathom_map *maps = scene->materials.items[id].value.maps;
    assert_int_equal(maps[FATHOM_MAP_COLOR].texture, found);
    assert_int_equal(maps[FATHOM_MAP_METALLIC].texture, srgb);
    assert_int_equal(maps[FATHOM_MAP_OPACITY].texture, found); /* alpha is linear in any space */
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; ++i)
        assert_int_equal(scene->textures.items[maps[kinds[i]].texture].color_space, FATHOM_COLOR_LINEAR);
}

/* The red of a sphere's middle, for a classic material that also has numbers of the other model. */
static float render_with(float opacity, float cutoff) {
    stage s = stage_open(3, 3);
    fathom_material m = default_material();
    m.opacity = opacity, m.opacity_cutoff = cutoff;
    assert_ok(s.context, fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH));
    s.settings.spp = 4, s.settings.target_error = 0;
    stage_camera(&s, (double[3]){0, 0, 4}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.2);
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &m));
    stage_point_light(&s, 1, 2, 4, 30);
    fathom_film *film = stage_render(&s);
    const float red = fathom_film_channel(film, "R")[4];
    return red;
}

/* Scene JSON and the other integrators know no opacity of classic materials but that of an image. */
UNIT_TEST(classic_materials_have_no_opacity) {
    const float red = render_with(1, 0);
    assert_true(red > 0.1f);
    assert_true(render_with(0.25f, 0) == red && render_with(0.25f, 0.5f) == red);
    assert_true(render_with(NAN, 0) == red);
}

int main(void) { return unit_main(open_folder, remove_folder); }
