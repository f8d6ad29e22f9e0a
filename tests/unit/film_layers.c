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
UNIT_TEST(each_bounce_of_a_furnace_is_where_it_belongs) {
    const double rho = 0.7;
    stage s = open_paths(16, 5);
    fathom_material m = default_material();
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.7f, m.k_e[c] = 1;
    stage_sphere(&s, 0, 0, 0, 1, stage_material(&s, &m));
    stage_camera(&s, (double[3]){0.2, 0.1, 0}, (double[3]){0, 0, -1}, up, 1);
    fathom_film *film = stage_render(&s);
    check_mean(film, "emission", 1, 0);
    check_mean(film, "direct", rho, 1e-5);
    check_mean(film, "indirect", rho * rho * (1 - pow(rho, 4)) / (1 - rho), 1e-5);
}

/* A room with all that light can do: lights with and without size, a background, glass, a mirror, a surface
 * that is there in part, and a shape without a shadow. */
static void furnish_lit(stage *s, bool veil, bool lamp, bool sky, bool ball) {
    fathom_material glass = default_material(), mirror = default_material(), half = default_material();
    for (int c = 0; c < 3; ++c) {
        glass.k_d[c] = 0, glass.k_t[c] = glass.k_r[c] = 1;
        mirror.k_d[c] = 0.1f, mirror.k_r[c] = 0.8f;
    }
    glass.fresnel = true;
    half.model = FATHOM_MODEL_METALLIC_ROUGHNESS, half.opacity = 0.5f, half.emissive[1] = veil ? 0.3f : 0;
    stage_plane(s, (double[3]){0, -1, 0}, up, stage_lambert(s, 0.6f));
    stage_sphere(s, -1.2, 0, 0, 0.7, stage_material(s, &glass));
    stage_sphere(s, 1.2, 0, 0, 0.7, stage_material(s, &mirror));
    stage_sphere(s, 0, 1.5, -1, 0.3, stage_emitter(s, ball ? 8 : 0));
    stage_quad(s, (double[3]){0, 0.2, 1}, (double[3]){0.6, 0, 0}, (double[3]){0, 0.6, 0},
               stage_material(s, &half));
    fathom_sphere ghost = default_sphere();
    ghost.center[1] = 3, ghost.center[2] = 1, ghost.radius = 0.5, ghost.flags = FATHOM_CASTS_NO_SHADOW;
    ghost.material = stage_lambert(s, 0.5f);
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &ghost, NULL));
    if (lamp) stage_point_light(s, 0, 4, 1, 6);
    if (sky) assert_ok(s->context, fathom_scene_set_background(s->scene, (float[3]){0.1f, 0.2f, 0.4f}));
    assert_ok(s->context, fathom_scene_set_ambient(s->scene, (float[3]){0.1f, 0.1f, 0.1f}));
    stage_camera(s, (double[3]){0, 0.5, 5}, (double[3]){0, 0, 0}, up, 0.9);
}

static void furnish(stage *s) { furnish_lit(s, true, true, true, true); }

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

UNIT_TEST(the_parts_add_up_to_the_image) {
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
    }
}

/* A path that passes a surface by its opacity is not scattered there. */
UNIT_TEST(light_through_a_hole_is_not_scattered) {
    stage s = open_paths(16, 4);
    fathom_material veil = default_material();
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
}

/* A lamp in one mirror was scattered once, and in the mirror of a mirror twice; by either integrator. */
UNIT_TEST(mirrors_scatter) {
    stage s = open_paths(4, 2);
    fathom_material mirror = default_material();
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
        stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0.25, -1}, up, 0.01);
        film = stage_render(&s);
        check_mean(film, "direct", 0, 0);
        check_mean(film, "indirect", 0.25, 1e-6);
        stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0.6, -1}, up, 0.01);
    }
}

/* ---- light groups ---- */

static void group(stage *s, fathom_light_source source, fathom_id id, const char *name) {
    assert_ok(s->context, fathom_scene_set_light_group(s->scene, source, id, name));
}

/* The room of above in four groups: what an object is put into goes before its material. */
static void put_into_groups(stage *s) {
    group(s, FATHOM_SOURCE_LIGHT, 0, "key");
    group(s, FATHOM_SOURCE_BACKGROUND, 0, "sky");
    for (fathom_id m = 0; m < 6; ++m) group(s, FATHOM_SOURCE_MATERIAL, m, "wrong");
    for (fathom_id o = 0; o < 6; ++o) group(s, FATHOM_SOURCE_OBJECT, o, o == 3 ? "ball_2" : "rest");
}

UNIT_TEST(groups_add_up_to_the_image) {
    static const char *const names[] = {"light_rest", "light_key", "light_sky", "light_wrong",
                                        "light_ball_2"};
    stage s = open_paths(16, 16);
    furnish(&s);
    put_into_groups(&s);
    for (int k = 0; k < 3; ++k) {
        fathom_settings_set_integrator(&s.settings,
                                       k == 2 ? FATHOM_INTEGRATOR_CLASSIC : FATHOM_INTEGRATOR_PATH);
        s.settings.target_error = k == 1 ? 0.05 : 0;
        s.settings.spp = k == 1 ? 64 : 16;
        s.settings.aovs = FATHOM_AOV_LIGHT_GROUPS;
        fathom_film *film = stage_render(&s);
        const float *whole = fathom_film_channel(film, "G");
        double sums[5] = {0};
        for (int i = 0; i < SIDE * SIDE; ++i) {
            double sum = 0;
            for (int g = 0; g < 5; ++g) {
                const double part = (double)channel(film, names[g], 'G')[i];
                sum += part, sums[g] += part;
            }
            assert_near(sum, (double)whole[i], ROUNDINGS * 0x1p-24 * sum);
        }
        for (int g = 0; g < 5; ++g) assert_true(g == 3 ? sums[g] == 0 : sums[g] > 0);
        s.settings.aovs = 0;
        fathom_film *plain = stage_render(&s);
        assert_same_image(film, plain);
    }
}

/* A group is the image with all other lights out: in expectation, here to 5 standard errors. */
UNIT_TEST(a_group_is_the_image_with_its_lights_alone) {
    static const char *const names[] = {"light_rest", "light_key", "light_sky", "light_wrong",
                                        "light_ball_2"};
    for (int g = 0; g < 5; ++g) {
        if (g == 3) continue;
        stage all = open_paths(64, 8), one = open_paths(64, 8);
        furnish(&all);
        put_into_groups(&all);
        all.settings.aovs = FATHOM_AOV_LIGHT_GROUPS, all.settings.seed = 1;
        furnish_lit(&one, g == 0, g == 1, g == 2, g == 4);
        fathom_film *a = stage_render(&all), *b = stage_render(&one);
        const float *x = channel(a, names[g], 'G'), *y = fathom_film_channel(b, "G");
        double sum = 0, squares = 0;
        for (int i = 0; i < SIDE * SIDE; ++i) {
            const double d = (double)x[i] - (double)y[i];
            sum += d, squares += d * d;
        }
        /* Pixels are independent, so their differences have the variance of the mean. */
        assert_near(sum, 0, 5 * sqrt(squares));
        assert_true(squares > 0);
    }
}

/* A sky that is 1 in one channel all around. */
static fathom_id add_sky(stage *s, const char *path, int color) {
    enum { TEXELS = 8 * 4 };
    char file[16 + sizeof(float) * 3 * TEXELS] = "PF\n8 4\n-1.0\n";
    const size_t header = strlen(file);
    float texels[TEXELS][3] = {{0}};
    for (int i = 0; i < TEXELS; ++i) texels[i][color] = 1;
    memcpy(file + header, texels, sizeof texels);
    unit_write_file(path, file, header + sizeof texels);
    fathom_light light = default_light();
    light.type = FATHOM_LIGHT_ENVIRONMENT, light.file = path;
    fathom_id id;
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, &id));
    return id;
}

/* A red, a green and a blue sky over a gray background and a floor: a group holds the colour of its sky
 * alone. */
UNIT_TEST(each_of_many_skies_keeps_its_group) {
    static const char *const names[] = {"light_red", "light_green", "light_blue"};
    char folder[] = "/tmp/fathom-test-XXXXXX", paths[3][64];
    assert_non_null(mkdtemp(folder));
    for (int with_background = 0; with_background < 2; ++with_background) {
        stage s = open_paths(64, 4);
        stage_plane(&s, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.5f));
        stage_camera(&s, (double[3]){0, 1, 5}, (double[3]){0, 1, 0}, up, 1);
        const float gray = with_background ? 0.25f : 0;
        assert_ok(s.context, fathom_scene_set_background(s.scene, (const float[3]){gray, gray, gray}));
        if (with_background) group(&s, FATHOM_SOURCE_BACKGROUND, 0, "gray");
        for (int c = 0; c < 3; ++c) {
            snprintf(paths[c], sizeof paths[c], "%s/%d.pfm", folder, c);
            group(&s, FATHOM_SOURCE_ENVIRONMENT, add_sky(&s, paths[c], c), names[c] + strlen("light_"));
        }
        s.settings.aovs = FATHOM_AOV_LIGHT_GROUPS;
        fathom_film *film = stage_render(&s);
        for (int k = 0; k < 9; ++k) {
            const float *pixels = channel(film, names[k / 3], "RGB"[k % 3]);
            double sum = 0;
            for (int i = 0; i < SIDE * SIDE; ++i) sum += (double)pixels[i];
            /* The sky's half of the image has 1, the floor 0.5. The floor's 51,200 samples deviate by less
             * than 1 each, so half their mean by less than 0.0022: this is 4.5 times as much. */
            if (k / 3 == k % 3) assert_near(sum / (SIDE * SIDE), 0.75, 0.01);
            /* Float rounds the groups' shares. */
            else
                assert_near(sum, 0, SIDE * SIDE * 0x1p-22);
        }
        for (int c = 0; c < 3; ++c) unlink(paths[c]);
    }
    rmdir(folder);
}

UNIT_TEST(groups_with_a_name_that_no_channel_can_have_are_refused) {
    stage s = open_paths(1, 1);
    static const char *const names[] = {"", "a b", "a.b", "12345678901234567890123456789012", "\xc3\xa4"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) {
        assert_fails(s.context, fathom_scene_set_light_group(s.scene, FATHOM_SOURCE_BACKGROUND, 0, names[i]),
                     FATHOM_BAD_INPUT, "expected 1 to 31 letters");
    }
    assert_fails(s.context, fathom_scene_set_light_group(s.scene, FATHOM_SOURCE_LIGHT, 0, "key"),
                 FATHOM_BAD_USAGE, "no source");
    char name[16];
    for (int i = 0; i < 31; ++i) {
        snprintf(name, sizeof name, "g%d", i);
        group(&s, FATHOM_SOURCE_BACKGROUND, 0, name);
    }
    assert_fails(s.context, fathom_scene_set_light_group(s.scene, FATHOM_SOURCE_BACKGROUND, 0, "more"),
                 FATHOM_BAD_INPUT, "\"more\" is one too many");
}

int main(void) { return unit_main(NULL, NULL); }
