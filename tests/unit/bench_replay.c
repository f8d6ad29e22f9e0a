/* The recording tracer changes no answer and keeps every ray; a replay meets what was met. */
#include "stage.h"

#include "job/job.h"
#include "measure/render_time.h"
#include "measure/replay.h"
#include "told.h"
#include "trace/embree/embree_spheres.h"

/* Balls over a floor of triangles, near and lit: no planes, which Embree does not see, and one sphere more
 * than are tested next to it. */
static void fill(stage *s) {
    add_ball(s, FATHOM_ROOT, 12, 0.05, 0.7, 0, 0);
    add_ball(s, FATHOM_ROOT, 9, 0.1, 0.5, 1.1, 0);
    add_grid(s, 8, -0.9);
    for (int i = 0; i <= FEW_SPHERES_MOST; ++i) add_sphere(s, FATHOM_ROOT, -1, 0.2 + 0.05 * i, 0.3, 0.4, 0);
}

static uint64_t met_closest(const ray_set *set) {
    uint64_t met = 0;
    for (size_t i = 0; i < set->count; ++i) met += set->blocks[i / 16].hits.geometry[i % 16] != FATHOM_NONE;
    return met;
}

#define RAYS 5003 /* no multiple of 16, and more than a piece of the replay */

UNIT_TEST(forwards) {
    stage s = stage_open();
    fill(&s);
    trace_tracer *real = stage_spec(&s, "embree:16");
    record r = {.blocks = 0};
    trace_tracer *recorder = record_tracer(real, &r);
    assert_non_null(recorder);
    ray_set asked = random_rays(RAYS);
    ray_set expected = traced(real, &asked, TRACE_INCOHERENT);
    ray_set got = traced(recorder, &asked, TRACE_INCOHERENT);
    for (size_t i = 0; i < RAYS; ++i) {
        assert_true(same_hit(&expected, &got, i));
        assert_true(hit_t(&expected, i) == hit_t(&got, i));
        const trace_rays *kept = &r.pieces.items[0][i / 16];
        assert_true(kept->dir_x[i % 16] == asked.blocks[i / 16].rays.dir_x[i % 16]);
        assert_true(kept->t_far[i % 16] == asked.blocks[i / 16].rays.t_far[i % 16]);
    }
    assert_int_equal(record_rays(&r, BARE_CLOSEST), RAYS);
    assert_int_equal(record_rays(&r, BARE_ANY), 0);
    trace_destroy(recorder);
    record_free(&r);
}

/* Bare calls answer as the tracer does about hit or miss: the filter changes which of several, never whether.
 */
static void replays(const char *words) {
    stage s = stage_open();
    fill(&s);
    trace_tracer *real = stage_spec(&s, words);
    assert_true(embree_bare_possible(real));
    record r = {.blocks = 0};
    trace_tracer *recorder = record_tracer(real, &r);
    ray_set asked = random_rays(RAYS);
    ray_set got = traced(recorder, &asked, TRACE_COHERENT);
    unsigned char *shaded = occluded(recorder, &asked, TRACE_COHERENT);
    uint64_t closest = met_closest(&got), any = 0;
    for (size_t i = 0; i < RAYS; ++i) any += shaded[i];
    assert_true(closest > RAYS / 10 && closest < RAYS);
    replay_result bare, again;
    assert_true(replay(&r, real, true, &bare));
    assert_true(replay(&r, real, false, &again));
    assert_int_equal(bare.rays[BARE_CLOSEST], RAYS);
    assert_int_equal(bare.rays[BARE_ANY], RAYS);
    assert_int_equal(bare.met[BARE_CLOSEST], closest);
    assert_int_equal(bare.met[BARE_ANY], any);
    assert_int_equal(again.met[BARE_CLOSEST], closest);
    assert_int_equal(again.met[BARE_ANY], any);
    assert_true(bare.cpu_seconds > 0);
    record_clear(&r);
    assert_int_equal(record_rays(&r, BARE_CLOSEST), 0);
    trace_destroy(recorder);
    record_free(&r);
}

UNIT_TEST(replays_packets) {
    replays("embree:16");
    replays("embree:8");
    replays("embree:4");
    replays("embree:1");
    replays("embree:user:16");
}

UNIT_TEST(others_have_no_bare_form) {
    stage s = stage_open();
    fill(&s);
    trace_tracer *bvh = stage_spec(&s, "bvh");
    assert_false(embree_bare_possible(bvh));
}

/* All rays of a render are asked again, however the image is cut into bands. */
UNIT_TEST(measures) {
    stage s = stage_open();
    fill(&s);
    fathom_light light = default_light();
    light.position[2] = 5;
    for (int c = 0; c < 3; ++c) light.intensity[c] = 30;
    assert_ok(s.context, fathom_scene_add_light(s.scene, &light, NULL));
    fathom_camera camera;
    fathom_camera_look_at((double[3]){0, 0, 5}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7, &camera);
    assert_ok(s.context, fathom_scene_set_camera(s.scene, &camera));
    trace_tracer *real = stage_spec(&s, "embree");
    fathom_settings settings = default_settings();
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = 70, settings.height = 100;
    const uint64_t room[] = {UINT64_C(1) << 30, 1};
    const unsigned bands[] = {1, 4};
    for (int k = 0; k < 2; ++k) {
        told far;
        const bench_watch watch = told_watch(&far);
        render_time_options options = {
            .repeats = 2, .threads = {1, 2}, .thread_counts = 2, .record_bytes = room[k], .watch = &watch};
        render_time time;
        assert_ok(s.context, render_time_measure(s.context, s.world, real, &settings, &options, &time));
        assert_int_equal(time.rays.camera, 7000);
        assert_true(time.rays.shadow > 100);
        assert_true(time.has_ratio);
        assert_int_equal(time.ratio.bands, bands[k]);
        told_all(&far, 2 + 2 * bands[k]);
        assert_int_equal(time.ratio.closest, time.rays.camera);
        assert_int_equal(time.ratio.any, time.rays.shadow);
    }
}

int main(void) { return unit_main(NULL, NULL); }
