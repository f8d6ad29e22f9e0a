/* Memory that runs out, requests.h says how: while measuring, and over the extreme cases. */
#include "integrate/plan.h"
#include "measure/build_time.h"
#include "measure/converge.h"
#include "measure/growth.h"
#include "measure/secondary.h"
#include "measure/trace_time.h"
#include "verify/extremes/extremes.h"
#include "verify/light/shading_studio.h"

#include "requests.h" /* last: cmocka defines words such as fail */

/* ---- extreme cases ---- */

static unsigned group_of(const char *name) {
    for (unsigned g = 0; g < extremes_groups(); ++g) {
        if (strcmp(extremes_name(g), name) == 0) return g;
    }
    fail_msg("there is no group %s", name);
    return 0;
}

/* The first case of the group, and the failures that are kept of it. */
static fathom_status ask_extremes(fathom_context *context, const char *group, outcome *out) {
    static const char *const specs[] = {"linear:textbook:f32", "embree:user"};
    extremes_rows rows = {.items = NULL};
    extremes_failures failures = {.items = NULL};
    const extremes_options options = {
        .specs = specs, .spec_count = 2, .rays = 24, .threads = 1, .kept = 1, .failures = &failures};
    fathom_status status = extremes_run(context, group_of(group), 0, &options, &rows);
    for (size_t i = 0; i < rows.count; ++i) {
        const extremes_row *row = &rows.items[i];
        add(out, row->counts, sizeof row->counts);
        add(out, row->any_counts, sizeof row->any_counts);
        add(out, row->words, strlen(row->words));
    }
    add(out, &failures.count, sizeof failures.count);
    array_free(&rows);
    array_free(&failures);
    return status;
}

static void extremes(void **state) {
    (void)state;
    for (unsigned g = 0; g < extremes_groups(); ++g) exhaust(ask_extremes, extremes_name(g));
}

static fathom_status open_extreme(fathom_context *context, const char *group, outcome *out) {
    extremes_scene *scene;
    fathom_status status = extremes_open(context, group, 1, &scene);
    if (status == FATHOM_OK) {
        size_t count = extremes_world(scene)->spheres.count;
        assert_non_null(extremes_search(scene));
        assert_non_null(extremes_source(scene));
        add(out, &count, sizeof count);
    }
    extremes_close(scene);
    return status;
}

static void one_extreme(void **state) {
    (void)state;
    exhaust(open_extreme, "scale-spheres");
    exhaust_to(open_extreme, "no such group", FATHOM_BAD_INPUT);
    /* Its cases are calls, and have no scene. */
    exhaust_to(open_extreme, "refused", FATHOM_BAD_INPUT);
}

/* ---- extreme shading ---- */

static const char *const shading[] = {"mirrors", "guide", "ior", "highlights", "lights", "slants", "earth"};

static fathom_status ask_shading(fathom_context *context, const char *name, outcome *out) {
    const shading_options options = {.spec = "linear"};
    shading_rows rows = {.items = NULL};
    unsigned group = 0;
    while (strcmp(shading[group], name) != 0) ++group;
    fathom_status status = group < SHADING_GROUPS ? shading_group(context, &options, group, &rows)
                                                  : shading_earth(context, &options, &rows);
    for (size_t i = 0; i < rows.count; ++i) {
        add(out, rows.items[i].what, strlen(rows.items[i].what));
        add(out, &rows.items[i].measured, sizeof rows.items[i].measured);
    }
    array_free(&rows);
    return status;
}

static void extreme_shading(void **state) {
    (void)state;
    refused_each = 100; /* one image or two */
    for (size_t i = 0; i < sizeof shading / sizeof *shading; ++i) exhaust(ask_shading, shading[i]);
    refused_each = ULONG_MAX;
}

/* ---- measuring ---- */

/* Rays of every kind, and triangles. */
static const char scene_json[] =
    "{ \"camera\": { \"eye\": [0, 0.5, 5], \"target\": [0, 0, 0], \"fovy\": 40 },\n"
    "  \"materials\": { \"mirror\": { \"kd\": [0.2, 0.2, 0.2], \"kr\": [0.6, 0.6, 0.6] },\n"
    "    \"glass\": { \"kd\": [0, 0, 0], \"kr\": [0.1, 0.1, 0.1], \"kt\": [0.9, 0.9, 0.9], \"ior\": 1.4 } "
    "},\n"
    "  \"lights\": [ { \"type\": \"point\", \"position\": [0, 3, 3], \"intensity\": 9 } ],\n"
    "  \"objects\": [ { \"type\": \"generate\", \"kind\": \"sphere\", \"triangles\": 64, \"material\": "
    "\"mirror\" "
    "},\n"
    "    { \"type\": \"sphere\", \"center\": [1, 0, 2], \"radius\": 0.5, \"material\": \"glass\" } ] }\n";

static fathom_status open_stage(fathom_context *context, const char *file, bench_stage *out) {
    fathom_scene *scene;
    fathom_settings settings;
    *out = (bench_stage){.scene = NULL};
    fathom_status status = fathom_scene_read(context, in_folder(file), &scene);
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &settings);
    settings.width = 16, settings.height = 12;
    return stage_open(context, scene, &settings, out);
}

static fathom_status measure_build(fathom_context *context, const char *file, outcome *out) {
    bench_stage stage;
    build_time time;
    fathom_status status = open_stage(context, file, &stage);
    if (status == FATHOM_OK) status = build_time_measure(context, &stage, "embree", 2, 1, NULL, &time);
    for (int q = 0; q < BUILD_QUALITIES && status == FATHOM_OK; ++q)
        add(out, &time.qualities[q].rays, sizeof time.qualities[q].rays);
    stage_close(&stage);
    return status;
}

static fathom_status measure_error(fathom_context *context, const char *file, outcome *out) {
    const converge_options options = {.rounds = 1, .max_spp = 4, .half_spp = 4, .ppd = 67};
    converge_result result = {.rounds = 0};
    bench_stage stage;
    fathom_status status = open_stage(context, file, &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage, "linear", 0);
    if (status == FATHOM_OK) status = converge_measure(context, &stage, &options, &result);
    for (size_t i = 0; i < result.runs.count; ++i)
        add(out, result.runs.items[i].errors, sizeof result.runs.items[i].errors);
    converge_free(&result);
    stage_close(&stage);
    return status;
}

static fathom_status measure_rays(fathom_context *context, const bench_stage *stage, const render_plan *plan,
                                  outcome *out) {
    static secondary_rays rays;
    static secondary_time time;
    fathom_status status = secondary_record(context, plan, UINT64_MAX, &rays);
    if (status != FATHOM_OK) return status;
    status = secondary_measure(context, stage->tracer, &rays, 1, NULL, &time);
    for (size_t i = 0; i < time.count && status == FATHOM_OK; ++i)
        add(out, &time.rows[i].met, sizeof time.rows[i].met);
    secondary_free(&rays);
    return status;
}

static fathom_status measure_secondary(fathom_context *context, const char *file, outcome *out) {
    bench_stage stage;
    render_plan *plan = NULL;
    fathom_status status = open_stage(context, file, &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage, "embree", 0);
    if (status == FATHOM_OK) status = plan_create(context, stage.world, stage.tracer, &stage.settings, &plan);
    if (status == FATHOM_OK) status = measure_rays(context, &stage, plan, out);
    plan_destroy(plan);
    stage_close(&stage);
    return status;
}

static fathom_status measure_trace(fathom_context *context, const char *file, outcome *out) {
    const trace_time_options options = {.repeats = 1, .threads = 2, .seconds = 1e-4};
    trace_set sets[TRACE_SETS] = {{.blocks = NULL}};
    trace_rate rates[1][TRACE_SETS];
    bench_stage stage;
    fathom_status status = open_stage(context, file, &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage, "bvh", 0);
    if (status == FATHOM_OK) status = trace_sets_create(context, stage.world, stage.tracer, 300, sets);
    for (int s = 0; s < TRACE_SETS && status == FATHOM_OK; ++s) {
        add(out, &sets[s].count, sizeof sets[s].count);
        add(out, sets[s].blocks, sets[s].count * sizeof *sets[s].blocks);
    }
    const trace_tracer *const tracers[1] = {stage.tracer};
    if (status == FATHOM_OK) status = trace_time_measure(context, tracers, 1, sets, &options, rates);
    trace_sets_free(sets);
    stage_close(&stage);
    return status;
}

/* Reading, building, rendering in bands by one thread and by two, and the rays of it asked again. */
static fathom_status measure_growth(fathom_context *context, const char *file, outcome *out) {
    const growth_options options = {.repeats = 1, .seconds = 1, .width = 20, .height = 40, .record_bytes = 1};
    static growth_point point;
    fathom_status status = growth_measure(context, in_folder(file), &options, &point);
    if (status != FATHOM_OK) return status;
    add(out, &point.triangles, sizeof point.triangles);
    add(out, &point.time.ratio.closest, sizeof point.time.ratio.closest);
    add(out, &point.time.ratio.any, sizeof point.time.ratio.any);
    return FATHOM_OK;
}

static void measuring(void **state) {
    (void)state;
    exhaust(measure_build, "scene.json");
    exhaust(measure_error, "scene.json");
    exhaust(measure_secondary, "scene.json");
    exhaust(measure_trace, "scene.json");
    exhaust(measure_growth, "scene.json");
}

static int begin(void **state) {
    (void)state;
    requests_begin();
    put("scene.json", scene_json);
    return 0;
}

static int end(void **state) {
    (void)state;
    unlink(in_folder("scene.json"));
    return rmdir(folder);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measuring),
        cmocka_unit_test(extremes),
        cmocka_unit_test(one_extreme),
        cmocka_unit_test(extreme_shading),
    };
    return cmocka_run_group_tests(tests, begin, end);
}
