/* The rays that `fathom bench secondary` asks about are those of the render, each of its kind and depth. */
#include "measure/replay.h"
#include "measure/secondary.h"

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

static uint64_t total(const secondary_rays *rays, secondary_kind kind) {
    uint64_t sum = 0;
    for (int d = 0; d < SECONDARY_DEPTHS; ++d) {
        const record *r = &rays->of[d][kind];
        bare_query query = kind == SECONDARY_SHADOW ? BARE_ANY : BARE_CLOSEST;
        assert_int_equal(record_rays(r, query == BARE_ANY ? BARE_CLOSEST : BARE_ANY), 0);
        sum += record_rays(r, query);
    }
    return sum;
}

static void all_of_a_render(void **state) {
    (void)state;
    studio t;
    studio_open(&t);
    secondary_rays rays;
    assert_ok(t.s.context, secondary_record(t.s.context, t.plan, UINT64_MAX, &rays));
    fathom_stats stats;
    fathom_film *film;
    assert_ok(t.s.context, fathom_render(t.s.context, t.s.scene, &t.s.settings, NULL, NULL, &stats, &film));
    fathom_film_destroy(film);
    assert_true(stats.reflection_rays > 1000 && stats.refraction_rays > 1000);
    assert_int_equal(total(&rays, SECONDARY_CAMERA), stats.camera_rays);
    assert_int_equal(total(&rays, SECONDARY_MIRRORED), stats.reflection_rays);
    assert_int_equal(total(&rays, SECONDARY_REFRACTED), stats.refraction_rays);
    assert_int_equal(total(&rays, SECONDARY_SHADOW), stats.shadow_rays);
    assert_int_equal(record_rays(&rays.of[0][SECONDARY_CAMERA], BARE_CLOSEST), 7000);
    assert_int_equal(record_rays(&rays.of[0][SECONDARY_MIRRORED], BARE_CLOSEST), 0);
    assert_true(record_rays(&rays.of[3][SECONDARY_REFRACTED], BARE_CLOSEST) > 0);
    secondary_free(&rays);
    studio_close(&t);
}

static void enough(void **state) {
    (void)state;
    studio t;
    studio_open(&t);
    secondary_rays rays;
    assert_ok(t.s.context, secondary_record(t.s.context, t.plan, 1500, &rays));
    /* The wave that makes it enough is recorded to its end: 1024 more at most from the camera. */
    assert_in_range(total(&rays, SECONDARY_CAMERA), 1500, 1500 + 1024);
    secondary_free(&rays);
    studio_close(&t);
}

/* Sorting loses no ray and puts octants in order. */
static void sorts(void **state) {
    (void)state;
    studio t;
    studio_open(&t);
    secondary_rays rays;
    assert_ok(t.s.context, secondary_record(t.s.context, t.plan, UINT64_MAX, &rays));
    const record *from = &rays.of[2][SECONDARY_REFRACTED];
    record sorted;
    assert_true(secondary_sorted(from, &sorted));
    assert_int_equal(sorted.calls.count, from->calls.count);
    double before = 0, after = 0;
    for (size_t c = 0; c < from->calls.count; ++c) {
        const record_call *call = &from->calls.items[c], *ordered = &sorted.calls.items[c];
        unsigned last = 0;
        assert_int_equal(call->rays, ordered->rays);
        for (size_t i = 0; i < call->rays; ++i) {
            const trace_rays *a = record_block(from, call->first + i / 16);
            const trace_rays *b = record_block(&sorted, ordered->first + i / 16);
            size_t k = i % 16;
            unsigned octant = (b->dir_x[k] < 0) + 2u * (b->dir_y[k] < 0) + 4u * (b->dir_z[k] < 0);
            assert_true(octant >= last);
            last = octant;
            /* Sums of multiples of 2^-20, exact in double, so in any order. */
            before += floor((double)a->org_x[k] * 0x1p20) + floor((double)a->dir_y[k] * 0x1p20);
            after += floor((double)b->org_x[k] * 0x1p20) + floor((double)b->dir_y[k] * 0x1p20);
        }
    }
    assert_true(before == after);
    record_free(&sorted);
    secondary_free(&rays);
    studio_close(&t);
}

/* Whichever way rays are asked, the same number of them meets something. */
static void meets(void **state) {
    (void)state;
    studio t;
    studio_open(&t);
    secondary_rays rays;
    secondary_time *time = malloc(sizeof *time);
    assert_non_null(time);
    assert_ok(t.s.context, secondary_record(t.s.context, t.plan, 3000, &rays));
    told far;
    const bench_watch watch = told_watch(&far);
    assert_ok(t.s.context, secondary_measure(t.s.context, t.tracer, &rays, 2, &watch, time));
    told_all(&far, 1 + 2 * (unsigned)time->count);
    assert_true(time->count >= 8);
    for (size_t i = 0; i < time->count; ++i) {
        const secondary_row *row = &time->rows[i];
        const record *r = &rays.of[row->depth][row->kind];
        bare_query query = row->kind == SECONDARY_SHADOW ? BARE_ANY : BARE_CLOSEST;
        replay_result traced;
        assert_true(replay_traced(r, t.tracer, &traced));
        assert_int_equal(row->rays, record_rays(r, query));
        assert_int_equal(traced.met[query], row->met);
        for (unsigned width = 4; width <= 16; width *= 2) {
            for (int coherent = 0; coherent < 2; ++coherent) {
                replay_result bare;
                assert_true(replay_bare_as(r, t.tracer, width, coherent, &bare));
                assert_int_equal(bare.rays[query], row->rays);
                assert_int_equal(bare.met[query], row->met);
            }
        }
        for (int way = 0; way < SECONDARY_WAYS; ++way) assert_true(row->ns[way].median > 0);
    }
    free(time);
    secondary_free(&rays);
    studio_close(&t);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_of_a_render),
        cmocka_unit_test(enough),
        cmocka_unit_test(sorts),
        cmocka_unit_test(meets),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
