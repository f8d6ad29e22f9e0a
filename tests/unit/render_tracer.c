/* Rendering with tracers by name, through the public interface. */
#include "stage.h"

static void fill(stage *s) {
    *s = stage_open();
    add_ball(s, FATHOM_ROOT, 10, 0.05, 1, 0, 0);
    add_sphere(s, FATHOM_ROOT, 1, 1, 0, 0.4, 0);
    assert_ok(s->context, fathom_scene_complete(s->scene));
}

static fathom_film *rendered(stage *s, const char *spec, fathom_stats *stats) {
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = 48, settings.height = 32, settings.tracer = spec;
    fathom_film *film;
    assert_ok(s->context, fathom_render(s->context, s->scene, &settings, NULL, NULL, stats, &film));
    return own_film(film);
}

UNIT_TEST(words_choose_the_tracer) {
    stage s;
    fill(&s);
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *linear = rendered(&s, "linear", &stats);
    assert_string_equal(stats.tracer, "reference");
    fathom_film *bvh = rendered(&s, "bvh", &stats);
    assert_string_equal(stats.tracer, "reference BVH, f32");
    assert_true(stats.bvh_bytes > 0);
    const size_t bytes = 48 * 32 * sizeof(float);
    const char *const channels[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        assert_memory_equal(fathom_film_channel(linear, channels[c]), fathom_film_channel(bvh, channels[c]),
                            bytes);
    }
    rendered(&s, NULL, &stats);
    assert_int_equal(strncmp(stats.tracer, "Embree", 6), 0);
}

UNIT_TEST(wrong_words_are_refused) {
    stage s;
    fill(&s);
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.tracer = "cuda";
    fathom_film *film;
    assert_fails(s.context, fathom_render(s.context, s.scene, &settings, NULL, NULL, NULL, &film),
                 FATHOM_BAD_USAGE, "called \"cuda\"");
    assert_null(film);
}

/* The scene keeps a copy, also when it is given its own text again. */
UNIT_TEST(the_scene_copies_the_words) {
    stage s = stage_open();
    char words[] = "bvh:f64";
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    assert_null(settings.tracer);
    settings.tracer = words;
    assert_ok(s.context, fathom_scene_set_settings(s.scene, &settings));
    memset(words, 'x', sizeof words - 1);
    fathom_scene_settings(s.scene, &settings);
    assert_string_equal(settings.tracer, "bvh:f64");
    assert_ok(s.context, fathom_scene_set_settings(s.scene, &settings));
    fathom_scene_settings(s.scene, &settings);
    assert_string_equal(settings.tracer, "bvh:f64");
    settings.tracer = NULL;
    assert_ok(s.context, fathom_scene_set_settings(s.scene, &settings));
    fathom_scene_settings(s.scene, &settings);
    assert_null(settings.tracer);
}

int main(void) { return unit_main(NULL, NULL); }
