/* The rays that `fathom bench trace --of-render` asks about are those of the render, by kind and depth. */
#include "measure/trace_time.h"

#include "render.h"
#include "told.h"
#include "trace/embree/embree_spheres.h"

typedef struct studio {
    stage s;
    world *world;
    trace_tracer *tracer;
    render_plan *plan;
} studio;

/* A ball of glass of triangles before a ball of mirrors, over a floor that takes their shadows. */
static void studio_open(studio *t) {
    t->s = stage_open(100, 70);
    fathom_material m;
    fathom_material_default(&m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0, m.k_r[c] = 0.2f, m.k_t[c] = 0.8f;
    fathom_id glass = stage_material(&t->s, &m);
    for (int c = 0; c < 3; ++c) m.k_d[c] = 0.3f, m.k_r[c] = 0.7f, m.k_t[c] = 0;
    fathom_id mirror = stage_material(&t->s, &m);
    stage_mesh_sphere(&t->s, FATHOM_ROOT, 24, 48, glass);
    stage_sphere(&t->s, 0.6, 0.3, -2.4, 1, mirror);
    /* More spheres than are tested next to Embree: bare calls meet them too. */
    for (int i = 0; i < FEW_SPHERES_MOST; ++i) stage_sphere(&t->s, 0, -9 - 3 * i, 0, 1, mirror);
    stage_quad(&t->s, (double[3]){0, -1.1, 0}, (double[3]){5, 0, 0}, (double[3]){0, 0, -5},
               stage_lambert(&t->s, 0.5f));
    stage_point_light(&t->s, 2, 5, 4, 40);
    stage_point_light(&t->s, -3, 4, 1, 20);
    stage_camera(&t->s, (double[3]){0, 1, 5}, (double[3]){0, 0, 0}, (double[3]){0, 1, 0}, 0.7);
    trace_options options = {.words = "embree", .width = 16, .threads = 2};
    assert_ok(t->s.context, world_create(t->s.scene, &t->world));
    assert_ok(t->s.context, trace_create(t->s.context, t->world, &options, &t->tracer));
    assert_ok(t->s.context, plan_create(t->s.context, t->world, t->tracer, &t->s.settings, &t->plan));
}

static void studio_close(studio *t) {
    plan_destroy(t->plan);
    trace_destroy(t->tracer);
    world_destroy(t->world);
    stage_close(&t->s);
}

static bool is_kind(const trace_set *set, const char *kind) { return strstr(set->name, kind) != NULL; }

static uint64_t total(const trace_sets *sets, const char *kind) {
    uint64_t sum = 0;
    for (size_t i = 0; i < sets->count; ++i)
        sum += is_kind(&sets->items[i], kind) ? sets->items[i].count * 16 : 0;
    return sum;
}

/* Each of nine depths may leave out fewer than 16 rays. */
static void assert_total(const trace_sets *sets, const char *kind, uint64_t rays) {
    assert_in_range(total(sets, kind), rays - 9 * 15, rays);
}

static void recorded_rays_are_those_of_the_render(void **state) {
    (void)state;
    studio t;
    studio_open(&t);
    trace_sets sets;
    assert_ok(t.s.context, trace_sets_record(t.s.context, t.plan, 100000, &sets));
    fathom_stats stats = {.size = sizeof stats};
    fathom_film *film;
    assert_ok(t.s.context, fathom_render(t.s.context, t.s.scene, &t.s.settings, NULL, NULL, &stats, &film));
    fathom_film_destroy(film);
    assert_true(stats.reflection_rays > 1000 && stats.refraction_rays > 1000);
    assert_total(&sets, "camera", stats.camera_rays);
    assert_total(&sets, "mirrored", stats.reflection_rays);
    assert_total(&sets, "refracted", stats.refraction_rays);
    assert_total(&sets, "shadow", stats.shadow_rays);
    assert_string_equal(sets.items[0].name, "0 camera");
    for (size_t i = 0; i < sets.count; ++i) {
        assert_int_equal(sets.items[i].query, is_kind(&sets.items[i], "shadow") ? BARE_ANY : BARE_CLOSEST);
        assert_false(is_kind(&sets.items[i], "0 mirrored") || is_kind(&sets.items[i], "0 refracted"));
    }
    trace_sets_free(&sets);
    studio_close(&t);
}

static void no_set_has_more_rays_than_asked_for(void **state) {
    (void)state;
    studio t;
    studio_open(&t);
    trace_sets sets;
    assert_ok(t.s.context, trace_sets_record(t.s.context, t.plan, 1500, &sets));
    assert_int_equal(total(&sets, "camera"), 1504);
    for (size_t i = 0; i < sets.count; ++i) assert_in_range(sets.items[i].count, 1, 1504 / 16);
    trace_sets_free(&sets);
    studio_close(&t);
}

static void bare_calls_meet_as_many_rays_as_the_tracer(void **state) {
    (void)state;
    static const char *const words[] = {"embree:1", "embree:4", "embree:8", "embree:16"};
    studio t;
    studio_open(&t);
    trace_sets sets;
    trace_tracer *made[4];
    replay_way ways[5] = {{t.tracer, false}};
    for (int i = 0; i < 4; ++i) {
        trace_options options = {.words = words[i], .width = 16, .threads = 2};
        assert_ok(t.s.context, trace_create(t.s.context, t.world, &options, &made[i]));
        ways[i + 1] = (replay_way){made[i], true};
    }
    assert_ok(t.s.context, trace_sets_record(t.s.context, t.plan, 3000, &sets));
    assert_true(sets.count >= 8);
    told far;
    const bench_watch watch = told_watch(&far);
    const trace_time_options options = {.repeats = 2, .threads = 1, .seconds = 1e6, .watch = &watch};
    static trace_rate rates[5][TRACE_SETS_MAX];
    assert_ok(t.s.context, trace_time_measure(t.s.context, ways, 5, &sets, &options, rates));
    told_all(&far, 1 + 2 * (unsigned)sets.count);
    for (size_t k = 0; k < sets.count; ++k) {
        for (int i = 0; i < 5; ++i) {
            assert_int_equal(rates[i][k].rays, sets.items[k].count * 16);
            assert_int_equal(rates[i][k].met, rates[0][k].met);
            assert_true(rates[i][k].per_cpu_second.median > 0);
        }
    }
    trace_sets_free(&sets);
    for (int i = 0; i < 4; ++i) trace_destroy(made[i]);
    studio_close(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recorded_rays_are_those_of_the_render),
        cmocka_unit_test(no_set_has_more_rays_than_asked_for),
        cmocka_unit_test(bare_calls_meet_as_many_rays_as_the_tracer),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
