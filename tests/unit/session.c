/* Rendering in the background. */
#include "render.h"

#include <fathom/session.h>

#define SIDE (SANITIZED ? 96 : 192)

static void fill(stage *s) {
    fathom_light light = default_light();
    light.position[0] = 2, light.position[1] = 5;
    for (int c = 0; c < 3; ++c) light.intensity[c] = 30;
    stage_sphere(s, 0, 0, -6, 1.5, stage_lambert(s, 0.8f));
    stage_plane(s, (double[3]){0, -1.5, 0}, (double[3]){0, 1, 0}, stage_lambert(s, 0.7f));
    assert_ok(s->context, fathom_scene_add_light(s->scene, &light, NULL));
    s->settings.spp = 16, s->settings.aovs = FATHOM_AOV_SAMPLES;
}

static void assert_same_pixels(const fathom_film *a, const fathom_film *b) {
    static const char *const channels[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c)
        assert_memory_equal(fathom_film_channel(a, channels[c]), fathom_film_channel(b, channels[c]),
                            sizeof(float) * SIDE * SIDE);
}

UNIT_TEST(a_session_renders_what_a_call_renders) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s);
    fathom_film *expected = stage_render(&s), *found;
    fathom_session *session;
    fathom_stats stats = {.size = sizeof stats};
    fathom_progress progress;
    assert_ok(s.context, fathom_session_start(s.context, s.scene, &s.settings, NULL, &session));
    assert_true(fathom_session_wait(session, -1));
    fathom_session_progress(session, &progress);
    assert_int_equal(progress.phase, FATHOM_PHASE_RENDER);
    assert_true(progress.fraction == 1);
    assert_ok(s.context, fathom_session_finish(session, &stats, &found));
    assert_true(stats.samples == 16 * SIDE * SIDE);
    assert_same_pixels(found, expected);
    fathom_film_destroy(found);
}

/* A pixel of the snapshot has all its samples, and is the film's, or it has none. */
static size_t check_snapshot(const fathom_film *snapshot, const fathom_film *film) {
    const uint32_t *samples = fathom_film_channel_id(snapshot, "samples");
    const float *now = fathom_film_channel(snapshot, "G"), *then = fathom_film_channel(film, "G");
    size_t finished = 0;
    for (size_t i = 0; i < SIDE * SIDE; ++i) {
        assert_true(samples[i] == 0 || samples[i] == 16);
        if (samples[i]) assert_true(now[i] == then[i]);
        finished += samples[i] > 0;
    }
    return finished;
}

static size_t count_samples(const fathom_film *snapshot, const fathom_film *film) {
    (void)film;
    const uint32_t *samples = fathom_film_channel_id(snapshot, "samples");
    size_t sum = 0;
    for (size_t i = 0; i < SIDE * SIDE; ++i) sum += samples[i];
    return sum;
}

/* Renders with a snapshot each `seconds`, whose counts never fall. Returns the last. */
static size_t watch(stage *s, double seconds, size_t (*count)(const fathom_film *, const fathom_film *),
                    const fathom_film *expected) {
    fathom_context *mine;
    fathom_session *session;
    fathom_film *snapshot, *film;
    size_t before = 0;
    assert_int_equal(fathom_context_create(&mine), FATHOM_OK);
    assert_ok(s->context, fathom_session_start(s->context, s->scene, &s->settings, NULL, &session));
    for (bool ended = false; !ended;) {
        ended = fathom_session_wait(session, seconds);
        assert_ok(mine, fathom_session_snapshot(mine, session, &snapshot));
        if (!snapshot) continue;
        const size_t now = count(snapshot, expected);
        assert_true(now >= before);
        before = now;
        fathom_film_destroy(snapshot);
    }
    assert_ok(s->context, fathom_session_finish(session, NULL, &film));
    fathom_film_destroy(film);
    fathom_context_destroy(mine);
    return before;
}

UNIT_TEST(finished_pixels_of_a_snapshot_are_those_of_the_film) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s);
    s.settings.tracer = "linear:f64";
    fathom_film *expected = stage_render(&s);
    assert_int_equal(watch(&s, 0.005, check_snapshot, expected), SIDE * SIDE);
}

UNIT_TEST(snapshots_of_adaptive_renders_gain_samples) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s);
    s.settings.pattern = FATHOM_PATTERN_SOBOL;
    s.settings.spp = SANITIZED ? 256 : 1024, s.settings.target_error = 0.001;
    assert_true(watch(&s, 0.01, count_samples, NULL) > 0);
}

UNIT_TEST(a_stopped_session_is_interrupted) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s);
    s.settings.pattern = FATHOM_PATTERN_SOBOL;
    s.settings.spp = 65536;
    fathom_film *film;
    fathom_session *session;
    fathom_stats stats = {.size = sizeof stats};
    assert_ok(s.context, fathom_session_start(s.context, s.scene, &s.settings, NULL, &session));
    assert_false(fathom_session_wait(session, 0));
    fathom_session_stop(session);
    assert_int_equal(fathom_session_finish(session, &stats, &film), FATHOM_INTERRUPTED);
    assert_true(stats.finished < 1);
    fathom_film_destroy(film);
}

/* The times are added to the clock's, and no sum may overflow. */
UNIT_TEST(waits_without_limit_end_with_the_session) {
    static const double seconds[] = {-1, 1e8, 1e10, 1e300, INFINITY, NAN};
    stage s = stage_open(SIDE, SIDE);
    fill(&s);
    s.settings.spp = 4;
    for (size_t i = 0; i < sizeof seconds / sizeof *seconds; ++i) {
        fathom_film *film;
        fathom_session *session;
        assert_ok(s.context, fathom_session_start(s.context, s.scene, &s.settings, NULL, &session));
        assert_true(fathom_session_wait(session, seconds[i]));
        assert_ok(s.context, fathom_session_finish(session, NULL, &film));
        fathom_film_destroy(film);
    }
}

UNIT_TEST(what_is_wrong_is_said_at_the_end) {
    stage s = stage_open(SIDE, SIDE);
    fill(&s);
    fathom_session *session;
    fathom_film *film;
    s.settings.width = 0;
    assert_ok(s.context, fathom_session_start(s.context, s.scene, &s.settings, NULL, &session));
    assert_fails(s.context, fathom_session_finish(session, NULL, &film), FATHOM_BAD_INPUT, "width");
    assert_null(film);
    assert_fails(s.context, fathom_session_start(s.context, NULL, &s.settings, NULL, &session),
                 FATHOM_BAD_USAGE, "scene");
    assert_fails(s.context, fathom_session_snapshot(s.context, NULL, &film), FATHOM_BAD_USAGE, "session");
}

int main(void) { return unit_main(NULL, NULL); }
