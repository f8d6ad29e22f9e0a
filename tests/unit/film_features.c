/* Features for denoisers: normals and albedo of what a sample shows, through mirrors, glass and holes. */
#include "render.h"

#define SIDE 40

static const double up[3] = {0, 1, 0};

static stage open_paths(uint32_t spp, uint32_t depth) {
    stage s = stage_open(SIDE, SIDE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    s.settings.spp = spp, s.settings.target_error = 0, s.settings.max_depth = depth;
    return s;
}

static const float *channel(const fathom_film *film, const char *layer, char c) {
    char name[32];
    snprintf(name, sizeof name, "%s.%c", layer, c);
    const float *pixels = fathom_film_channel(film, name);
    assert_non_null(pixels);
    return pixels;
}

/* A mirror of half of the light shows a wall of albedo 0.6 behind the camera; a glass pane with an index of 1
 * shows the wall behind it. Z and P stay with what is in view. */
UNIT_TEST(normals_and_albedo_follow_smooth_surfaces) {
    stage s = open_paths(4, 4);
    s.settings.aovs = FATHOM_AOV_N | FATHOM_AOV_ALBEDO | FATHOM_AOV_Z;
    fathom_material mirror = default_material(), pane = default_material();
    for (int c = 0; c < 3; ++c) mirror.k_d[c] = pane.k_d[c] = 0, mirror.k_r[c] = 0.5f, pane.k_t[c] = 1;
    pane.ior = 1;
    const fathom_id wall = stage_lambert(&s, 0.6f);
    stage_plane(&s, (double[3]){0, 0, -2}, (double[3]){0, 0, 1}, stage_material(&s, &mirror));
    stage_plane(&s, (double[3]){0, 0, 3}, (double[3]){0, 0, 1}, wall);
    stage_quad(&s, (double[3]){0, 0, -1}, (double[3]){5, 0, 0}, (double[3]){0, 5, 0},
               stage_material(&s, &pane));
    stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, -1}, up, 0.1);
    fathom_film *film = stage_render(&s);
    for (int i = 0; i < SIDE * SIDE; ++i) {
        assert_near((double)channel(film, "albedo", 'R')[i], 0.3, 1e-6);
        assert_near((double)channel(film, "N", 'Z')[i], -1, 1e-6); /* the wall behind, towards the mirror */
        assert_near((double)fathom_film_channel(film, "Z")[i], 1, 1e-5);
    }
    s.settings.max_depth = 0; /* no further than what is in view */
    fathom_film *near = stage_render(&s);
    for (int i = 0; i < SIDE * SIDE; ++i) assert_near((double)channel(near, "N", 'Z')[i], 1, 1e-6);
}

/* Half of a sheet before nothing, and before a wall: the samples that end at the sheet have its albedo, and
 * the others what is behind. Without bounces, too. */
UNIT_TEST(albedo_and_alpha_of_holes_are_those_behind) {
    for (uint32_t i = 0; i < 4; ++i) {
        stage s = open_paths(16, i % 2);
        const bool walled = i > 1;
        s.settings.aovs = FATHOM_AOV_ALBEDO | FATHOM_AOV_ALPHA | FATHOM_AOV_CRYPTO_OBJECT;
        fathom_material half = default_material();
        half.model = FATHOM_MODEL_METALLIC_ROUGHNESS, half.specular_factor = half.metallic = 0;
        half.opacity = 0.5f, half.base_color[0] = 0.9f;
        stage_quad(&s, (double[3]){0, 0, -1}, (double[3]){5, 0, 0}, (double[3]){0, 5, 0},
                   stage_material(&s, &half));
        if (walled) stage_plane(&s, (double[3]){0, 0, -2}, (double[3]){0, 0, 1}, stage_lambert(&s, 0.2f));
        stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, -1}, up, 1);
        fathom_film *film = stage_render(&s);
        /* The sheet's samples are a whole number of 16. */
        double sum = 0;
        for (int k = 0; k < SIDE * SIDE; ++k) {
            const double albedo = (double)channel(film, "albedo", 'R')[k],
                         alpha = (double)fathom_film_channel(film, "A")[k],
                         sheet = walled ? (albedo - 0.2) / 0.7 : albedo / 0.9;
            assert_near(sheet * 16, round(sheet * 16), 1e-4);
            assert_near(alpha, walled ? 1 : sheet, 1e-6);
            if (!walled) assert_near((double)channel(film, "CryptoObject00", 'G')[k], alpha, 1e-6);
            sum += sheet;
        }
        /* 5 standard errors of independent samples; those of a pixel are spread more evenly. */
        assert_near(sum / (SIDE * SIDE), 0.5, 5 * 0.5 / (4 * SIDE));
    }
}

/* A mirror shows half of a sheet, and nothing where a sample passes the sheet: there the mirror itself
 * counts. */
UNIT_TEST(a_mirror_shows_no_features_of_holes) {
    stage s = open_paths(16, 4);
    s.settings.aovs = FATHOM_AOV_N | FATHOM_AOV_ALBEDO;
    fathom_material mirror = default_material(), half = default_material();
    half.model = FATHOM_MODEL_METALLIC_ROUGHNESS, half.specular_factor = half.metallic = 0,
    half.opacity = 0.5f;
    for (int c = 0; c < 3; ++c) mirror.k_d[c] = 0, mirror.k_r[c] = 0.5f, half.base_color[c] = 0.2f;
    stage_plane(&s, (double[3]){0, 0, -2}, (double[3]){0, 0, 1}, stage_material(&s, &mirror));
    stage_plane(&s, (double[3]){0, 0, 3}, (double[3]){0, 0, 1}, stage_material(&s, &half));
    stage_camera(&s, (double[3]){0, 0, 0}, (double[3]){0, 0, -1}, up, 0.1);
    fathom_film *film = stage_render(&s);
    double sum = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const double sheet = (0.5 - (double)channel(film, "albedo", 'R')[i]) / (0.5 - 0.5 * 0.2);
        assert_near(sheet * 16, round(sheet * 16), 1e-4);
        assert_near((double)channel(film, "N", 'Z')[i], 1 - 2 * sheet, 1e-6);
        sum += sheet;
    }
    assert_near(sum / (SIDE * SIDE), 0.5, 5 * 0.5 / (4 * SIDE)); /* as above */
}

int main(void) { return unit_main(NULL, NULL); }
