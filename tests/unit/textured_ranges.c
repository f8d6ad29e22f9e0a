/* Numbers that an image takes from one end of their range to the other: what the renderer prepares must allow
 * for all that some point of the surface does. Of an image of zeros it knows no more than of any other; yet
 * each number then is the same everywhere, and the image that of a scene without images. */
#include "render.h"

#include <stddef.h>

enum { SIZE = 16 };

/* A ball over a floor, under a lamp. */
static void render_ball(stage *s, const fathom_material *m, unsigned flags, float rgb[3][SIZE * SIZE]) {
    fathom_sphere ball = default_sphere();
    s->settings.target_error = 0, s->settings.spp = 4;
    ball.radius = 0.8, ball.flags = flags, ball.material = stage_material(s, m);
    assert_ok(s->context, fathom_scene_add_sphere(s->scene, FATHOM_ROOT, &ball, NULL));
    stage_quad(s, (double[]){0, -1, 0}, (double[]){3, 0, 0}, (double[]){0, 0, -3}, stage_lambert(s, 0.5f));
    stage_quad(s, (double[]){-2, 2, 0}, (double[]){0.3, 0, 0}, (double[]){0, 0, 0.3}, stage_emitter(s, 4));
    assert_ok(s->context, fathom_scene_set_background(s->scene, (float[]){0.2f, 0.3f, 0.5f}));
    stage_camera(s, (double[]){0, 1.5, 4}, (double[]){0, 0, 0}, (double[]){0, 1, 0}, 0.6);
    fathom_film *film = stage_render(s);
    for (int c = 0; c < 3; ++c)
        memcpy(rgb[c], fathom_film_channel(film, (const char[]){"RGB"[c], 0}), sizeof rgb[c]);
}

/* The number is at one end of its range; times 0, or raised to 1, it is at the other. */
typedef struct range {
    const char *name;
    int map;
    size_t number;
    bool inverted, classic;
    float metallic, roughness, transmission, thickness, distance, dispersion;
    bool bumpy, matt;
} range;

static const range ranges[] = {
    {"a metal by default holds a volume", FATHOM_MAP_METALLIC, offsetof(fathom_material, metallic),
     .inverted = false, .metallic = 1, .roughness = 0.3f, .transmission = 1, .thickness = 1, .distance = 1},
    {"a wall is clear", FATHOM_MAP_TRANSMISSION, offsetof(fathom_material, transmission), .inverted = true},
    {"a ball absorbs", FATHOM_MAP_TRANSMISSION, offsetof(fathom_material, transmission), .inverted = true,
     .roughness = 0.3f, .thickness = 1, .distance = 1},
    {"a ball disperses", FATHOM_MAP_TRANSMISSION, offsetof(fathom_material, transmission), .inverted = true,
     .thickness = 1, .dispersion = 5},
    {"wax absorbs", FATHOM_MAP_DIFFUSE_TRANSMISSION, offsetof(fathom_material, diffuse_transmission),
     .inverted = true, .roughness = 0.5f, .thickness = 1, .distance = 1},
    {"a coat has its own normal", FATHOM_MAP_CLEARCOAT, offsetof(fathom_material, clearcoat),
     .inverted = true, .roughness = 0.5f, .bumpy = true},
    {"a metal mirrors", FATHOM_MAP_ROUGHNESS, offsetof(fathom_material, roughness), .inverted = false,
     .classic = true, .metallic = 1, .roughness = 1},
    {"a ball refracts", FATHOM_MAP_TRANSMISSION, offsetof(fathom_material, transmission), .inverted = true,
     .classic = true, .roughness = 1, .thickness = 1},
    {"a base is lit", FATHOM_MAP_TRANSMISSION, offsetof(fathom_material, transmission), .inverted = false,
     .classic = true, .roughness = 1, .transmission = 1, .matt = true},
};

static fathom_material material_of(const range *r) {
    fathom_material m = default_material();
    m.model = FATHOM_MODEL_METALLIC_ROUGHNESS;
    m.metallic = r->metallic, m.roughness = r->roughness, m.transmission = r->transmission;
    m.thickness = r->thickness, m.attenuation_distance = r->distance, m.dispersion = r->dispersion;
    if (r->matt) m.specular_factor = 0;
    m.attenuation_color[1] = 0.5f, m.attenuation_color[2] = 0.2f;
    return m;
}

static void render_range(const range *r, bool mapped, float rgb[3][SIZE * SIZE]) {
    static const float black[3] = {0, 0, 0}, tilted[3] = {0.6f, 0.4f, 0.9f};
    stage s = stage_open(SIZE, SIZE);
    fathom_material m = material_of(r);
    float *number = (float *)(void *)((char *)&m + r->number);
    if (!r->classic) fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    stage_point_light(&s, 2, 3, 2, 8);
    if (r->bumpy) m.maps[FATHOM_MAP_NORMAL].texture = stage_texel(&s, tilted);
    if (mapped)
        m.maps[r->map].texture = stage_texel(&s, black), m.maps[r->map].inverted = r->inverted;
    else
        *number = r->inverted ? 1 : 0;
    render_ball(&s, &m, 0, rgb);
}

UNIT_TEST(an_image_of_zeros_is_a_number_at_the_end_of_its_range) {
    for (size_t k = 0; k < sizeof ranges / sizeof *ranges; ++k) {
        static float with[3][SIZE * SIZE], without[3][SIZE * SIZE];
        render_range(&ranges[k], true, with);
        render_range(&ranges[k], false, without);
        if (memcmp(with, without, sizeof with) != 0) fail_msg("%s", ranges[k].name);
    }
}

/* ---- shapes that seem to be absent ---- */

/* No light but the lamp's and the background's, for which such shapes are as others. */
static void render_without_shadow(const fathom_material *m, unsigned flags, float rgb[3][SIZE * SIZE]) {
    stage s = stage_open(SIZE, SIZE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    render_ball(&s, m, flags, rgb);
}

UNIT_TEST(a_volume_of_index_1_is_seen_without_its_shadow) {
    static float with[3][SIZE * SIZE], without[3][SIZE * SIZE];
    const range fog = {.roughness = 1, .transmission = 1, .thickness = 1, .distance = 1};
    fathom_material m = material_of(&fog);
    m.ior = 1;
    render_without_shadow(&m, 0, with);
    render_without_shadow(&m, FATHOM_CASTS_NO_SHADOW, without);
    assert_memory_equal(with, without, sizeof with);
    /* Straight through its middle: what is left of a length of 1.6 or less, where 0.2 are left of 1. */
    assert_true(without[2][SIZE * (SIZE / 2) + SIZE / 2] < 0.3f * without[0][SIZE * (SIZE / 2) + SIZE / 2]);
}

UNIT_TEST(an_inverted_image_covers_a_surface_of_opacity_0) {
    static const float black[3] = {0, 0, 0};
    static float with[3][SIZE * SIZE], without[3][SIZE * SIZE];
    const range matt = {.roughness = 1};
    fathom_material m = material_of(&matt);
    render_without_shadow(&m, FATHOM_CASTS_NO_SHADOW, without);
    stage s = stage_open(SIZE, SIZE);
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_PATH);
    m.opacity = 0, m.maps[FATHOM_MAP_OPACITY].texture = stage_texel(&s, black);
    m.maps[FATHOM_MAP_OPACITY].inverted = true;
    render_ball(&s, &m, FATHOM_CASTS_NO_SHADOW, with);
    assert_memory_equal(with, without, sizeof with);
}

int main(void) { return unit_main(NULL, NULL); }
