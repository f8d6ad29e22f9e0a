/* Renders that are stopped: what the film holds then. */
#include "render.h"

#define SIDE 100u
#define ENDLESS_SPP 65536u /* minutes on any machine */

/* As soon as rays are counted: those of the preview are not. */
static bool goes_on(void *user, const fathom_progress *now) {
    (void)user;
    return now->phase != FATHOM_PHASE_RENDER || now->rays == 0;
}

static stage two_balls(void) {
    static const double eye[3] = {0, 1, 5}, target[3] = {0, 0, 0}, up[3] = {0, 1, 0};
    stage s = stage_open(SIDE, SIDE);
    fathom_material mirror = default_material();
    for (int c = 0; c < 3; ++c) mirror.k_r[c] = 0.6f;
    stage_camera(&s, eye, target, up, 0.8);
    stage_sphere(&s, -0.8, 0, 0, 1, stage_material(&s, &mirror));
    stage_sphere(&s, 1.1, -0.2, 0.5, 0.8, stage_lambert(&s, 0.7f));
    stage_plane(&s, (double[3]){0, -1, 0}, (double[3]){0, 1, 0}, stage_lambert(&s, 0.5f));
    stage_point_light(&s, 2, 4, 3, 20);
    s.settings.pattern = FATHOM_PATTERN_SOBOL;
    s.settings.aovs = FATHOM_AOVS & ~(unsigned)FATHOM_AOV_ERROR;
    return s;
}

/* Stopped on its way. */
static fathom_film *render_and_stop(stage *s, uint32_t spp) {
    fathom_film *film;
    s->settings.spp = spp;
    assert_int_equal(fathom_render(s->context, s->scene, &s->settings, goes_on, NULL, NULL, &film),
                     FATHOM_INTERRUPTED);
    return own_film(film);
}

/* Pixels that meet the same object as the middle of the pixel does. */
static size_t alike(const fathom_film *a, const fathom_film *b, size_t pixels) {
    const uint32_t *x = fathom_film_channel_id(a, "id.object"), *y = fathom_film_channel_id(b, "id.object");
    size_t count = 0;
    for (size_t i = 0; i < pixels; ++i) count += x[i] == y[i];
    return count;
}

static void assert_whole_frame(stage *s, const uint32_t crop[4], size_t block) {
    memcpy(s->settings.crop, crop, sizeof s->settings.crop);
    fathom_film *stopped = render_and_stop(s, ENDLESS_SPP);
    const double target = s->settings.target_error;
    s->settings.spp = 1, s->settings.target_error = 0;
    fathom_film *one = stage_render(s);
    s->settings.target_error = target;
    uint32_t width, height;
    fathom_film_size(one, &width, &height);
    const size_t pixels = (size_t)width * height;
    const uint32_t *samples = fathom_film_channel_id(stopped, "samples");
    size_t shown = 0;
    for (size_t i = 0; i < pixels; ++i) {
        assert_true(samples[i] == 0 || samples[i] == ENDLESS_SPP || s->settings.target_error > 0);
        shown += samples[i] == 0 && fathom_film_channel(stopped, "A")[i] > 0;
    }
    /* Only outlines can differ, a few times the width of the image in length, by at most a block's width. */
    assert_true(shown > 0);
    assert_true(pixels - alike(stopped, one, pixels) < 3 * block * (size_t)(width + height));
}

UNIT_TEST(a_stopped_render_shows_the_whole_frame) {
    stage s = two_balls();
    for (unsigned threads = 1; threads <= 3; threads += 2) {
        fathom_context_set_threads(s.context, threads);
        assert_whole_frame(&s, (uint32_t[4]){0, 0, 0, 0}, 2);
        assert_whole_frame(&s, (uint32_t[4]){7, 5, 93, 71}, 2);
    }
}

/* No wave reaches this error. */
UNIT_TEST(a_render_to_an_error_that_is_stopped_shows_the_whole_frame) {
    stage s = two_balls();
    s.settings.target_error = 1e-7;
    fathom_context_set_threads(s.context, 2);
    assert_whole_frame(&s, (uint32_t[4]){0, 0, 0, 0}, 8);
}

/* The reference has no preview: what it has not sampled is empty. */
UNIT_TEST(a_stopped_reference_shows_its_own_samples_alone) {
    static const uint32_t middle[4] = {40, 40, 60, 60};
    stage s = two_balls();
    fathom_settings_set_integrator(&s.settings, FATHOM_INTEGRATOR_REFERENCE);
    s.settings.target_error = 0, s.settings.aovs = FATHOM_AOV_SAMPLES;
    memcpy(s.settings.crop, middle, sizeof middle);
    fathom_film *film = render_and_stop(&s, ENDLESS_SPP);
    for (size_t i = 0; i < 400; ++i) {
        assert_int_equal(fathom_film_channel_id(film, "samples")[i], 0);
        assert_true(fathom_film_channel(film, "G")[i] == 0);
    }
}

/* The preview is seen in no image that is finished, and counts in no figure. */
UNIT_TEST(a_finished_render_holds_samples_alone) {
    stage s = two_balls();
    fathom_film *film;
    fathom_stats stats = {.size = sizeof stats};
    s.settings.spp = 5;
    assert_ok(s.context, fathom_render(s.context, s.scene, &s.settings, NULL, NULL, &stats, &film));
    assert_int_equal(stats.camera_rays, (uint64_t)SIDE * SIDE * 5);
    assert_int_equal(stats.samples, (uint64_t)SIDE * SIDE * 5);
    for (size_t i = 0; i < (size_t)SIDE * SIDE; ++i)
        assert_int_equal(fathom_film_channel_id(film, "samples")[i], 5);
    fathom_film_destroy(film);
}

int main(void) { return unit_main(NULL, NULL); }
