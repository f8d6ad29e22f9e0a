/* How bright a film is, and the exposure that shows it. */
#include "render.h"

#define SIDE 20u

/* A quad that sends out radiance `e` before a background. It covers half of the image: no camera ray meets
 * its edge. */
static fathom_film *render_emitter(float e, float background, unsigned aovs) {
    static const double eye[3] = {0, 0, 2}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    stage s = stage_open(SIDE, SIDE);
    stage_camera(&s, eye, target, up, 0.8);
    stage_quad(&s, (double[3]){-50, 0, 0}, (double[3]){50, 0, 0}, (double[3]){0, 50, 0},
               stage_emitter(&s, e));
    assert_ok(s.context,
              fathom_scene_set_background(s.scene, (float[3]){background, background, background}));
    s.settings.aovs = aovs;
    fathom_film *film = stage_render(&s);
    return film;
}

static fathom_brightness brightness_of(float e, float background, unsigned aovs, float exposure) {
    fathom_film *film = render_emitter(e, background, aovs);
    fathom_brightness b = {.size = sizeof b};
    fathom_film_brightness(film, exposure, &b);
    return b;
}

UNIT_TEST(background_does_not_count) {
    assert_int_equal(brightness_of(3, 0.5f, 0, 0).pixels, SIDE * SIDE / 2);
    assert_int_equal(brightness_of(3, 0.5f, FATHOM_AOV_ALPHA, 0).pixels, SIDE * SIDE / 2);
    assert_int_equal(brightness_of(0.5f, 0.5f, FATHOM_AOV_ALPHA, 0).pixels, SIDE * SIDE / 2);
}

UNIT_TEST(brighter_than_white_is_clipped) {
    assert_int_equal(brightness_of(3, 0.5f, 0, 0).clipped, SIDE * SIDE / 2);
    assert_int_equal(brightness_of(3, 0.5f, 0, -1).clipped, SIDE * SIDE / 2);
    assert_int_equal(brightness_of(3, 0.5f, 0, -2).clipped, 0);
    assert_int_equal(brightness_of(1, 0.5f, 0, 0).clipped, 0);
}

UNIT_TEST(black_is_counted) {
    fathom_brightness b = brightness_of(0, 0.5f, 0, 0);
    assert_int_equal(b.black, SIDE * SIDE / 2);
    assert_true(b.exposure == 0);
    assert_int_equal(brightness_of(1e-30f, 0.5f, 0, 0).black, 0);
    b = brightness_of(0, 0, 0, 0);
    assert_true(b.black == SIDE * SIDE && b.pixels == SIDE * SIDE && b.exposure == 0);
    assert_int_equal(brightness_of(0, 0, FATHOM_AOV_ALPHA, 0).black, SIDE * SIDE / 2);
    assert_int_equal(brightness_of(1, 0, 0, 0).black, 0);
}

/* The exposure found shows everything, and half a stop more would not: bins are a sixteenth of an octave
 * wide, and steps a tenth of a stop. */
UNIT_TEST(the_exposure_found_just_clips_nothing) {
    for (float e = 1e-20f; e < 1e20f; e *= 7.3f) {
        float exposure = brightness_of(e, 0, 0, 0).exposure;
        assert_int_equal(brightness_of(e, 0, 0, exposure).clipped, 0);
        assert_int_equal(brightness_of(e, 0, 0, exposure + 0.5f).clipped, SIDE * SIDE / 2);
        assert_near(exposure * 10, roundf(exposure * 10), 1e-3); /* float's roundings of 100 and less */
    }
}

int main(void) { return unit_main(NULL, NULL); }
