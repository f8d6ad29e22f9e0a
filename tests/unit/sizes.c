/* Callers that were built against an older header, whose structs end sooner. */
#include "render.h"

#include <fathom/fathom.h>

/* No older caller has more of the struct than this. */
#define UP_TO(type, member) offsetof(type, member)

#define NO_SIZE "its size is 0 bytes; expected the size of the struct"

static const unsigned char beyond = 0xa5;

static bool is_untouched(const void *item, size_t size, size_t whole) {
    for (size_t i = size; i < whole; ++i) {
        if (((const unsigned char *)item)[i] != beyond) return false;
    }
    return true;
}

/* All defaults of a struct up to `cut` bytes are those of the whole, and nothing is written past them. */
#define CHECK_DEFAULT(type, cut, own)                                                                        \
    do {                                                                                                     \
        type whole, part;                                                                                    \
        type##_default(&whole);                                                                              \
        memset(&part, beyond, sizeof part);                                                                  \
        type##_default_sized(&part, cut);                                                                    \
        assert_memory_equal((char *)&part + (own), (char *)&whole + (own), (cut) - (own));                   \
        assert_true(is_untouched(&part, cut, sizeof part));                                                  \
    } while (0)
#define CHECK_OWN_DEFAULT(type, cut)                                                                         \
    do {                                                                                                     \
        CHECK_DEFAULT(type, cut, sizeof(size_t));                                                            \
        type older;                                                                                          \
        type##_default_sized(&older, cut);                                                                   \
        assert_int_equal(older.size, cut);                                                                   \
        type##_default(&older);                                                                              \
        assert_int_equal(older.size, sizeof older);                                                          \
    } while (0)

UNIT_TEST(defaults_end_where_the_struct_of_the_caller_does) {
    CHECK_OWN_DEFAULT(fathom_settings, UP_TO(fathom_settings, tracer));
    CHECK_OWN_DEFAULT(fathom_write_options, UP_TO(fathom_write_options, view));
    CHECK_OWN_DEFAULT(fathom_read_options, UP_TO(fathom_read_options, width));
    CHECK_OWN_DEFAULT(fathom_generate_options, UP_TO(fathom_generate_options, seed));
    CHECK_OWN_DEFAULT(fathom_checkpoint, UP_TO(fathom_checkpoint, wanted));
    CHECK_OWN_DEFAULT(fathom_part, UP_TO(fathom_part, split));
    CHECK_OWN_DEFAULT(fathom_ranks, UP_TO(fathom_ranks, user));
    CHECK_OWN_DEFAULT(fathom_texture, UP_TO(fathom_texture, filter));
    CHECK_OWN_DEFAULT(fathom_session_options, UP_TO(fathom_session_options, outputs));
    CHECK_DEFAULT(fathom_material, UP_TO(fathom_material, shininess), 0);
    CHECK_DEFAULT(fathom_light, UP_TO(fathom_light, intensity), 0);
    CHECK_DEFAULT(fathom_sphere, UP_TO(fathom_sphere, flags), 0);
    CHECK_DEFAULT(fathom_quad, UP_TO(fathom_quad, flags), 0);
    CHECK_DEFAULT(fathom_plane, UP_TO(fathom_plane, flags), 0);
    CHECK_DEFAULT(fathom_mesh, UP_TO(fathom_mesh, origin), 0);
    CHECK_DEFAULT(fathom_instance, UP_TO(fathom_instance, material), 0);
    CHECK_DEFAULT(fathom_camera, UP_TO(fathom_camera, w), 0);
}

static stage small_stage(void) {
    stage s = stage_open(32, 32);
    stage_sphere(&s, 0, 0, -5, 1, 0);
    stage_point_light(&s, 2, 5, 0, 30);
    return s;
}

UNIT_TEST(older_settings_render_the_same) {
    stage s = small_stage();
    fathom_film *expected = stage_render(&s), *film;
    fathom_settings older;
    memset(&older, beyond, sizeof older);
    fathom_settings_default_sized(&older, UP_TO(fathom_settings, block_width));
    fathom_settings_set_integrator(&older, FATHOM_INTEGRATOR_CLASSIC);
    older.width = older.height = 32;
    fathom_stats stats;
    memset(&stats, beyond, sizeof stats);
    stats.size = UP_TO(fathom_stats, build_seconds);
    assert_ok(s.context, fathom_render(s.context, s.scene, &older, NULL, NULL, &stats, &film));
    assert_int_equal(stats.size, UP_TO(fathom_stats, build_seconds));
    assert_int_equal(stats.samples, 32 * 32);
    assert_true(is_untouched(&stats, stats.size, sizeof stats));
    assert_memory_equal(fathom_film_channel(film, "R"), fathom_film_channel(expected, "R"), 32 * 32 * 4);
    assert_ok(s.context, fathom_settings_check(s.context, &older));
    assert_ok(s.context, fathom_scene_set_settings(s.scene, &older));
    fathom_settings now;
    fathom_scene_settings(s.scene, &now);
    assert_true(now.width == 32 && now.block_width == 16 && now.size == sizeof now);
    fathom_film_destroy(film);
}

UNIT_TEST(settings_by_name_stay_within_the_struct) {
    stage s = small_stage();
    fathom_settings older;
    memset(&older, beyond, sizeof older);
    fathom_settings_default_sized(&older, UP_TO(fathom_settings, block_width));
    assert_ok(s.context, fathom_settings_set_text(s.context, &older, "spp", "16"));
    assert_ok(s.context, fathom_settings_set_loss(&older, FATHOM_LOSS_8BIT, 0));
    assert_int_equal(older.spp, 16);
    assert_true(older.max_loss > 0);
    assert_true(is_untouched(&older, older.size, sizeof older));
    assert_fails(s.context, fathom_settings_set_text(s.context, &older, "block_width", "8"), FATHOM_BAD_USAGE,
                 "there is no \"block_width\"");
}

UNIT_TEST(results_end_where_the_struct_of_the_caller_does) {
    stage s = small_stage();
    fathom_film *film = stage_render(&s);
    fathom_brightness brightness;
    memset(&brightness, beyond, sizeof brightness);
    brightness.size = UP_TO(fathom_brightness, clipped);
    assert_ok(s.context, fathom_film_brightness(film, 0, &brightness));
    assert_true(brightness.pixels > 0 && is_untouched(&brightness, brightness.size, sizeof brightness));
    fathom_build build;
    memset(&build, beyond, sizeof build);
    build.size = UP_TO(fathom_build, compiler);
    assert_ok(s.context, fathom_build_info(&build));
    assert_string_equal(build.version, fathom_version());
    assert_true(is_untouched(&build, build.size, sizeof build));
}

UNIT_TEST(older_parts_of_a_scene_have_the_defaults_of_later_members) {
    stage s = small_stage();
    fathom_light light, found;
    memset(&light, beyond, sizeof light);
    fathom_light_default_sized(&light, UP_TO(fathom_light, inner_angle));
    light.type = FATHOM_LIGHT_SPOT;
    assert_ok(s.context,
              fathom_scene_add_light_sized(s.scene, &light, UP_TO(fathom_light, inner_angle), NULL));
    assert_ok(s.context, fathom_scene_light(s.scene, fathom_scene_lights(s.scene) - 1, &found));
    assert_true(found.type == FATHOM_LIGHT_SPOT && found.inner_angle == 0 && found.outer_angle > 0.78f);
    memset(&found, beyond, sizeof found);
    assert_ok(s.context, fathom_scene_light_sized(s.scene, 0, &found, UP_TO(fathom_light, inner_angle)));
    assert_true(is_untouched(&found, UP_TO(fathom_light, inner_angle), sizeof found));
    fathom_sphere sphere = default_sphere();
    sphere.material = 99; /* past the end of what is given */
    assert_ok(s.context, fathom_scene_add_sphere_sized(s.scene, FATHOM_ROOT, &sphere,
                                                       UP_TO(fathom_sphere, material), NULL));
}

UNIT_TEST(a_forgotten_size_is_named) {
    stage s = small_stage();
    fathom_context *c = s.context;
    fathom_film *film = stage_render(&s), *none;
    fathom_session *session;
    fathom_scene *scene;
    fathom_settings settings = s.settings;
    fathom_stats stats = {.size = 0};
    fathom_light light = default_light();
    settings.size = 0;
    const fathom_session_options options = {.size = 0};
    const fathom_read_options read = {.size = 0};
    const fathom_generate_options generate = {.size = 0};
    const fathom_write_options write = {.size = 0};
    const fathom_checkpoint saving = {.path = "a"};
    assert_fails(c, fathom_render(c, s.scene, &settings, NULL, NULL, NULL, &none), FATHOM_BAD_USAGE,
                 "settings: " NO_SIZE);
    assert_fails(c, fathom_render(c, s.scene, &s.settings, NULL, NULL, &stats, &none), FATHOM_BAD_USAGE,
                 "stats: " NO_SIZE);
    assert_fails(c, fathom_session_start(c, s.scene, &s.settings, &options, &session), FATHOM_BAD_USAGE,
                 "options: " NO_SIZE);
    assert_fails(c, fathom_checkpoint_check(c, &saving), FATHOM_BAD_USAGE, "checkpoint: " NO_SIZE);
    assert_fails(c, fathom_settings_check(c, &settings), FATHOM_BAD_USAGE, "settings: " NO_SIZE);
    assert_fails(c, fathom_settings_set_text(c, &settings, "spp", "1"), FATHOM_BAD_USAGE, NO_SIZE);
    assert_fails(c, fathom_scene_set_settings(s.scene, &settings), FATHOM_BAD_USAGE, NO_SIZE);
    assert_fails(c, fathom_scene_read_with(c, "a.ply", &read, &scene), FATHOM_BAD_USAGE, NO_SIZE);
    const fathom_framing framing = {.size = 0};
    fathom_read_options framed = default_read_options();
    framed.framing = &framing;
    assert_fails(c, fathom_scene_read_with(c, "a.ply", &framed, &scene), FATHOM_BAD_USAGE, "framing: ");
    assert_fails(c, fathom_scene_generate(s.scene, FATHOM_ROOT, &generate), FATHOM_BAD_USAGE, NO_SIZE);
    assert_fails(c, fathom_film_write(c, film, "a.png", &write), FATHOM_BAD_USAGE, NO_SIZE);
    assert_fails(c, fathom_write_check(c, "a.png", &write), FATHOM_BAD_USAGE, NO_SIZE);
    assert_fails(c, fathom_scene_add_light_sized(s.scene, &light, 0, NULL), FATHOM_BAD_USAGE,
                 "light: " NO_SIZE);
    assert_int_equal(fathom_settings_set_loss(&settings, FATHOM_LOSS_HALF, 0), FATHOM_BAD_USAGE);
    assert_int_equal(fathom_film_brightness(film, 0, &(fathom_brightness){.size = 0}), FATHOM_BAD_USAGE);
    assert_int_equal(fathom_build_info(&(fathom_build){.size = 0}), FATHOM_BAD_USAGE);
    assert_int_equal(fathom_scene_framing(s.scene, &(fathom_framing){.size = 0}), FATHOM_BAD_USAGE);
}

/* The caller's header is newer than the library: members that it sets would be lost. */
UNIT_TEST(a_size_beyond_this_version_is_refused) {
    stage s = small_stage();
    fathom_settings settings = s.settings;
    fathom_film *none;
    ++settings.size;
    assert_fails(s.context, fathom_render(s.context, s.scene, &settings, NULL, NULL, NULL, &none),
                 FATHOM_BAD_USAGE, "at most the");
    struct {
        fathom_light light;
        char more[8];
    } later = {.more = {1}};
    fathom_light_default(&later.light);
    assert_fails(s.context, fathom_scene_add_light_sized(s.scene, &later.light, sizeof later, NULL),
                 FATHOM_BAD_USAGE, "at most the");
}

int main(void) { return unit_main(NULL, NULL); }
