/* Light by how often it was scattered: the parts are what they say, add up to the image, and change nothing
 * in it. */
#include "render.h"

#include <string.h>

#define SIDE 40

static const double up[3] = {0, 1, 0};
static const char *const parts[] = {"emission", "direct", "indirect"};
static const unsigned of_parts = FATHOM_AOV_EMISSION | FATHOM_AOV_DIRECT | FATHOM_AOV_INDIRECT;

static stage open_paths(uint32_t spp, uint32_t depth) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = spp, s.settings.target_error = 0, s.settings.max_depth = depth;
    s.settings.aovs = of_parts;
    return s;
}

static const float *channel(const fathom_film *film, const char *part, char c) {
    char name[32];
    snprintf(name, sizeof name, "%s.%c", part, c);
    const float *pixels = fathom_film_channel(film, name);
    assert_non_null(pixels);
    return pixels;
}

/* Beyond 5 standard errors of the mean of all pixels: 6e-7 by chance. */
static void check_mean(const fathom_film *film, const char *part, double value, double slack) {
    const float *pixels = channel(film, part, 'G');
    double sum = 0, squares = 0;
    for (int i = 0; i < SIDE * SIDE; ++i)
        sum += (double)pixels[i], squares += (double)(pixels[i] * pixels[i]);
    const double mean = sum / (SIDE * SIDE), variance = fmax(squares / (SIDE * SIDE) - mean * mean, 0);
    assert_near(mean, value, 5 * sqrt(variance / (SIDE * SIDE)) + slack);
}

/* Inside a sphere of albedo rho that sends out 1, n scatterings leave rho^n. */
static void each_bounce_of_a_furnace_is_where_it_belongs(void **state) {
    (void)state;
    const double rho = 0.7;
    stage s = open_paths(16, 5);
    fathom_material m;
    fathom_material_default(&m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.7f, m.k_e[c] = 1;
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &m));
    stage_camera(&s, (double[3]){0.2, 0.1, 0}, (double[3]){0, 0, -1}, up, 1);
    fathom_film *film = stage_render(&s);
    check_mean(film, "emission", 1, 0);
    check_mean(film, "direct", rho, 1e-5);
    check_mean(film, "indirect", rho * rho * (1 - pow(rho, 4)) / (1 - rho), 1e-5);
    fathom_film_destroy(film);
    stage_close(&s);
}

/* A room with all that light can do: lights with and without size, a background, glass, a mirror, a surface
 * that is there in part, and a shape without a shadow. */
static void furnish(stage *s) {
    fathom_material glass, mirror, half;
    fathom_material_default(&glass);
    fathom_material_default(&mirror);
    fathom_material_default(&half);
    for (int c = 0; c < 3; ++c) {
        glass.k_d[c] = 0, glass.k_t[c] = glass.k_r[c] = 1;
        mirror.k_d[c] = 0.1f, mirror.k_r[c] = 0.8f;
    }
    glass.fresnel = true;
    half.model = FATHOM_MODEL_METALLIC_ROUGHNESS, half.opacity = 0.5f, half.emissive[1] = 0.3f;
    stage_plane(s, (double[3]){0, -1, 0}, up, stage_lambert(s, 0.6f));
    stage_sphere(s, -1.2, 0, 0, 0.7, stage_material(s, &glass));
    stage_sphere(s, 1.2, 0, 0, 0.7, stage_material(s, &mirror));
    stage_sphere(s, 0, 1.5, -1, 0.3, stage_emitter(s, 8));
    stage_quad(s, (double[3]){0, 0.2, 1}, (double[3]){0.6, 0, 0}, (double[3]){0, 0.6, 0},
               stage_material(s, &half));
    fathom_sphere ghost;
    fathom_sphere_default(&ghost);
    ghost.center[1] = 3, ghost.center[2] = 1, ghost.radius = 0.5, ghost.flags = FATHOM_CASTS_NO_SHADOW;
    ghost.material = stage_lambert(s, 0.5f);
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &ghost, NULL));
    stage_point_light(s, 0, 4, 1, 6);
    assert_ok(s->context, fathom_scene_set_background(s->scene, (float[3]){0.1f, 0.2f, 0.4f}));
    assert_ok(s->context, fathom_scene_set_ambient(s->scene, (float[3]){0.1f, 0.1f, 0.1f}));
    stage_camera(s, (double[3]){0, 0.5, 5}, (double[3]){0, 0, 0}, up, 0.9);
}

/* A sample is a sum of at most two terms a vertex, each rounded to float: once in the image, once in its
 * part. */
#define ROUNDINGS (2 * 2 * 17 + 4)

static void assert_sum(const fathom_film *film) {
    bool any[3] = {false};
    for (const char *c = "RGB"; *c; ++c) {
        const float *whole = fathom_film_channel(film, (char[2]){*c, 0});
        for (int i = 0; i < SIDE * SIDE; ++i) {
            double sum = 0;
            for (int k = 0; k < 3; ++k) {
                const double part = (double)channel(film, parts[k], *c)[i];
                any[k] |= part > 0;
                sum += part;
            }
            assert_near(sum, (double)whole[i], ROUNDINGS * 0x1p-24 * sum);
        }
    }
    assert_true(any[0] && any[1] && any[2]);
}

static void assert_same_image(const fathom_film *a, const fathom_film *b) {
    for (const char *c = "RGB"; *c; ++c) {
        const char name[2] = {*c, 0};
        assert_memory_equal(fathom_film_channel(a, name), fathom_film_channel(b, name),
                            SIDE * SIDE * sizeof(float));
    }
}

static void the_parts_add_up_to_the_image(void **state) {
    (void)state;
    stage s = open_paths(16, 16);
    furnish(&s);
    for (int k = 0; k < 4; ++k) {
        fathom_settings_set_integrator(&s.settings,
                                       k == 2 ? FATHOM_INTEGRATOR_CLASSIC : FATHOM_INTEGRATOR_PATH);
        s.settings.target_error = k == 1 ? 0.05 : 0;
        s.settings.spp = k == 1 ? 64 : 16;
        s.settings.aovs = of_parts | (k == 3 ? FATHOM_AOV_ALPHA : 0);
        fathom_film *film = stage_render(&s);
        assert_sum(film);
        s.settings.aovs &= ~of_parts;
        fathom_film *plain = stage_render(&s);
        assert_same_image(film, plain);
        fathom_film_destroy(film);
        fathom_film_destroy(plain);
    }
    stage_close(&s);
}

/* A path that passes a surface by its opacity is not scattered there. */
static void light_through_a_hole_is_not_scattered(void **state) {
    (void)state;
    stage s = open_paths(16, 4);
    fathom_material veil;
    fathom_material_default(&veil);
    veil.model = FATHOM_MODEL_METALLIC_ROUGHNESS, veil.opacity = 0.25f;
    veil.specular_factor = 0;
    for (int c = 0; c < 3; ++c) veil.base_color[c] = 0;
    stage_plane(&s, (double[3]){0, 0, -1}, (double[3]){0, 0, 1}, stage_material(&s, &veil));
    stage_plane(&s, (double[3]){0, 0, -2}, (double[3]){0, 0, 1}, stage_emitter(&s, 1));
    stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, -1}, up, 0.5);
    fathom_film *film = stage_render(&s);
    check_mean(film, "emission", 0.75, 1e-6);
    for (int i = 0; i < SIDE * SIDE; ++i)
        assert_true(channel(film, "direct", 'R')[i] == 0 && channel(film, "indirect", 'R')[i] == 0);
    fathom_film_destroy(film);
    stage_close(&s);
}

/* A lamp in one mirror was scattered once, and in the mirror of a mirror twice; by either integrator. */
static void mirrors_scatter(void **state) {
    (void)state;
    stage s = open_paths(4, 2);
    fathom_material mirror;
    fathom_material_default(&mirror);
    for (int c = 0; c < 3; ++c) mirror.k_d[c] = 0, mirror.k_r[c] = 0.5f;
    stage_plane(&s, (double[3]){0, 0, -1}, (double[3]){0, 0, 1}, stage_material(&s, &mirror));
    stage_plane(&s, (double[3]){0, 0, 1}, (double[3]){0, 0, 1}, stage_material(&s, &mirror));
    stage_plane(&s, (double[3]){0, 1, 0}, up, stage_emitter(&s, 1));
    stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0.6, -1}, up, 0.01);
    for (int k = 0; k < 2; ++k) {
        s.settings.integrator = k ? FATHOM_INTEGRATOR_PATH : FATHOM_INTEGRATOR_CLASSIC;
        fathom_film *film = stage_render(&s);
        check_mean(film, "emission", 0, 0);
        check_mean(film, "direct", 0.5, 1e-6);
        fathom_film_destroy(film);
        stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0.25, -1}, up, 0.01);
        film = stage_render(&s);
        check_mean(film, "direct", 0, 0);
        check_mean(film, "indirect", 0.25, 1e-6);
        fathom_film_destroy(film);
        stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0.6, -1}, up, 0.01);
    }
    stage_close(&s);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(each_bounce_of_a_furnace_is_where_it_belongs),
        cmocka_unit_test(the_parts_add_up_to_the_image),
        cmocka_unit_test(light_through_a_hole_is_not_scattered),
        cmocka_unit_test(mirrors_scatter),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
