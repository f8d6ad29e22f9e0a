/* The studio, which lights models that bring no light. */
#include "light/studio.h"
#include "light/environment.h"
#include "random.h"
#include "unit_folder.h"

#include <fathom/fathom.h>

static environment *open_studio(vec3_f64 z, vec3_f64 up) {
    environment *e;
    assert_ok(context, environment_studio(context, z, up, &e));
    return e;
}

static vec3_f64 direction(random_state *r) {
    const vec3_f64 d = {2 * random_unit(r) - 1, 2 * random_unit(r) - 1, 2 * random_unit(r) - 1};
    return normalize_f64(d);
}

/* A texel's corner is at most 0.25 degrees off its centre. The edge of a panel rises by its radiance over 6
 * degrees, at most 1.5 times as fast as evenly: 1/16 of the radiance. */
static void texels_hold_the_rule(void **state) {
    (void)state;
    environment *e = open_studio(vec_f64(0, 0, 1), vec_f64(0, 1, 0));
    random_state r = {1};
    studio made;
    studio_open(&made);
    for (int i = 0; i < 20000; ++i) {
        const vec3_f64 d = direction(&r);
        float rule[3], texel[3];
        studio_radiance(&made, d, rule);
        environment_at(e, d, texel);
        for (int c = 0; c < 3; ++c) {
            assert_true(rule[c] > 0.01f);
            assert_true(fabsf(rule[c] - texel[c]) < 4.2f / 16);
        }
    }
    environment_destroy(e);
}

/* What stands in it looks the same whichever axis is up, and from wherever the viewer looks. */
static void it_turns_with_the_viewer(void **state) {
    (void)state;
    environment *y = open_studio(vec_f64(0, 0, 1), vec_f64(0, 1, 0)),
                *z = open_studio(vec_f64(0, -1, 0), vec_f64(0, 0, 1)),
                *below = open_studio(vec_f64(0, -4, 1), vec_f64(0, 1, 0)),
                *side = open_studio(vec_f64(1, 0, 0), vec_f64(0, 1, 0));
    random_state r = {2};
    for (int i = 0; i < 1000; ++i) {
        const vec3_f64 d = direction(&r);
        float a[3], b[3];
        environment_at(y, d, a);
        environment_at(z, vec_f64(d.x, -d.z, d.y), b);
        assert_memory_equal(a, b, sizeof a);
        environment_at(below, d, b);
        assert_memory_equal(a, b, sizeof a);
        environment_at(side, vec_f64(d.z, d.y, -d.x), b);
        assert_memory_equal(a, b, sizeof a);
    }
    environment_destroy(y), environment_destroy(z), environment_destroy(below), environment_destroy(side);
}

static fathom_scene *open_ball(void) {
    fathom_scene *scene;
    fathom_sphere ball;
    fathom_sphere_default(&ball);
    assert_ok(context, fathom_scene_create(context, &scene));
    assert_ok(context, fathom_scene_add_sphere(scene, 0, &ball, NULL));
    return scene;
}

/* *corner: the pixel at the upper left, next to the ball. NULL: not asked for. */
static float look(fathom_scene *scene, float *corner) {
    fathom_settings s;
    fathom_film *film;
    float sum = 0;
    fathom_settings_default(&s);
    fathom_settings_set_integrator(&s, FATHOM_INTEGRATOR_PATH);
    s.width = s.height = 32, s.spp = 4, s.target_error = 0;
    assert_ok(context, fathom_render(context, scene, &s, NULL, NULL, NULL, &film));
    const float *green = fathom_film_channel(film, "G");
    for (int i = 0; i < 32 * 32; ++i) sum += green[i] / (32 * 32);
    if (corner) *corner = green[0];
    fathom_film_destroy(film);
    return sum;
}

static float mean_of(fathom_scene *scene) { return look(scene, NULL); }

/* Those that complete() made for the classic integrator would light the ball from two sides. */
static void a_background_alone_lights_a_model_without_lights(void **state) {
    (void)state;
    const float sky[3] = {0.3f, 0.3f, 0.3f};
    float before, after;
    fathom_scene *scene = open_ball();
    assert_ok(context, fathom_scene_set_background(scene, sky));
    assert_ok(context, fathom_scene_complete(scene));
    before = mean_of(scene);
    fathom_scene_destroy(scene);
    scene = open_ball();
    assert_ok(context, fathom_scene_complete(scene));
    assert_ok(context, fathom_scene_set_background(scene, sky));
    after = mean_of(scene);
    fathom_scene_destroy(scene);
    assert_float_equal(after, before, 0);
}

/* A light, a background or ambient light of the caller's own leaves no studio. */
static void only_models_without_light_stand_in_it(void **state) {
    (void)state;
    fathom_scene *scene = open_ball();
    assert_ok(context, fathom_scene_complete(scene));
    const float lit = mean_of(scene);
    assert_true(lit > 0.1f && lit < 1);
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0, 0, 0}));
    assert_true(mean_of(scene) < lit / 2);
    fathom_scene_destroy(scene);

    scene = open_ball();
    assert_ok(context, fathom_scene_set_background(scene, (float[3]){0, 0, 0}));
    assert_ok(context, fathom_scene_complete(scene));
    assert_true(mean_of(scene) < lit / 2);
    fathom_scene_destroy(scene);
}

/* Behind a ball with an emission of 1, which an image may scale by 0. */
static float wall_behind_emissive(bool image) {
    static const char black[] = "P6\n1 1\n255\n\0\0\0";
    const fathom_texture texture = {.size = sizeof texture, .bytes = black, .byte_count = sizeof black - 1};
    fathom_scene *scene;
    fathom_sphere ball;
    fathom_material m;
    fathom_sphere_default(&ball);
    fathom_material_default(&m);
    assert_ok(context, fathom_scene_create(context, &scene));
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.emissive[0] = m.emissive[1] = m.emissive[2] = 1;
    if (image)
        assert_ok(context, fathom_scene_add_texture(scene, &texture, &m.maps[FATHOM_MAP_EMISSIVE].texture));
    assert_ok(context, fathom_scene_add_material(scene, "m", &m, &ball.material));
    assert_ok(context, fathom_scene_add_sphere(scene, 0, &ball, NULL));
    assert_ok(context, fathom_scene_complete(scene));
    float corner;
    look(scene, &corner);
    fathom_scene_destroy(scene);
    return corner;
}

static void an_image_of_emission_is_no_lamp(void **state) {
    (void)state;
    assert_true(wall_behind_emissive(true) > 0.01f);
    assert_true(wall_behind_emissive(false) == 0);
}

/* Black pixels say what the studio could add unseen: its brightest panel is above 4. */
static void errors_know_how_bright_it_is(void **state) {
    (void)state;
    fathom_scene *scene = open_ball();
    assert_ok(context, fathom_scene_complete(scene));
    fathom_settings settings;
    fathom_film *film;
    fathom_settings_default(&settings);
    settings.width = settings.height = 16, settings.spp = 16, settings.target_error = 0;
    settings.max_depth = 0, settings.aovs = FATHOM_AOV_ERROR;
    assert_ok(context, fathom_render(context, scene, &settings, NULL, NULL, NULL, &film));
    /* The ball itself is black without a bounce. By the rule of three for 16 samples. */
    const size_t middle = 8 * 16 + 8;
    const double share = 1 - pow(0.05, 1 / 16.0);
    assert_true(fathom_film_channel(film, "G")[middle] == 0);
    assert_true(fathom_film_channel(film, "error.doubt")[middle] == 1);
    assert_true((double)fathom_film_channel(film, "error.G")[middle] > share * 4 / 2.1);
    assert_true((double)fathom_film_channel(film, "error.G")[middle] < share * 6 / 2.0);
    fathom_film_destroy(film);
    fathom_scene_destroy(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texels_hold_the_rule),
        cmocka_unit_test(it_turns_with_the_viewer),
        cmocka_unit_test(a_background_alone_lights_a_model_without_lights),
        cmocka_unit_test(only_models_without_light_stand_in_it),
        cmocka_unit_test(an_image_of_emission_is_no_lamp),
        cmocka_unit_test(errors_know_how_bright_it_is),
    };
    return cmocka_run_group_tests(tests, open_folder, remove_folder);
}
