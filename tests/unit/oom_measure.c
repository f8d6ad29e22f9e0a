/* Memory that runs out, requests.h says how: while measuring, and over the extreme cases. */
#include "defaults.h"
#include "measure/converge.h"
#include "measure/phases.h"
#include "measure/trace_time.h"
#include "verify/extremes/case.h"
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
    static const char *const specs[] = {"linear:f32", "embree:user"};
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

UNIT_TEST(extremes) {
    for (unsigned g = 0; g < extremes_groups(); ++g) {
        exhaust(ask_extremes, extremes_name(g));
        refused_each = 64; /* groups differ in how they make their scenes, which comes first */
    }
    refused_each = REFUSED_EACH;
}

static fathom_status open_extreme(fathom_context *context, const char *group, outcome *out) {
    judged_scene scene;
    fathom_status status = extremes_open(context, group, 1, &scene);
    if (status == FATHOM_OK) {
        size_t count = scene.world->spheres.count;
        assert_true(scene.search && scene.source);
        add(out, &count, sizeof count);
    }
    judged_close(&scene);
    return status;
}

UNIT_TEST(one_extreme) {
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

UNIT_TEST(extreme_shading) {
    for (size_t i = 0; i < sizeof shading / sizeof *shading; ++i) {
        /* One image or two; the two of the Earth take long, and render as the others do. */
        refused_each = (strcmp(shading[i], "earth") == 0 ? 24ul : 100ul) / (SANITIZED ? 4 : 1);
        exhaust(ask_shading, shading[i]);
    }
    refused_each = REFUSED_EACH;
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

static fathom_status open_stage(fathom_context *context, const char *file, const char *tracer,
                                bench_stage *out) {
    fathom_scene *scene;
    fathom_settings settings;
    *out = (bench_stage){.scene = NULL};
    fathom_status status = fathom_scene_read(context, in_folder(file), &scene);
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &settings);
    settings.width = 16, settings.height = 12, settings.tracer = tracer;
    return stage_open(context, scene, &settings, out);
}

static fathom_status measure_error(fathom_context *context, const char *file, outcome *out) {
    const converge_options options = {.rounds = 1, .max_spp = 4, .half_spp = 4, .ppd = 67};
    converge_result result = {.rounds = 0};
    bench_stage stage;
    fathom_status status = open_stage(context, file, "linear", &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage);
    if (status == FATHOM_OK) status = converge_measure(context, &stage, &options, &result);
    for (size_t i = 0; i < result.runs.count; ++i)
        add(out, result.runs.items[i].errors, sizeof result.runs.items[i].errors);
    converge_free(&result);
    stage_close(&stage);
    return status;
}

static fathom_status measure_trace(fathom_context *context, const char *file, outcome *out) {
    const trace_time_options options = {.repeats = 1, .threads = 2, .seconds = 1e-4};
    trace_sets sets = {{{.count = 0}}};
    static trace_rate rates[1][TRACE_SETS];
    bench_stage stage;
    fathom_status status = open_stage(context, file, "bvh", &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage);
    if (status == FATHOM_OK) status = trace_sets_create(context, stage.world, stage.tracer, 300, &sets);
    for (size_t s = 0; s < TRACE_SETS && status == FATHOM_OK; ++s) {
        const trace_set *set = &sets.items[s];
        add(out, &set->count, sizeof set->count);
        add(out, set->blocks, set->count * sizeof *set->blocks);
    }
    if (status == FATHOM_OK) status = trace_time_measure(context, &stage.tracer, 1, &sets, &options, rates);
    trace_sets_free(&sets);
    stage_close(&stage);
    return status;
}

/* Reading, building, rendering in bands by one thread, and the rays of it asked again. */
static fathom_status measure_phases(fathom_context *context, const char *file, outcome *out) {
    const render_time_options options = {
        .repeats = 1, .seconds = 1, .threads = {1}, .thread_counts = 1, .record_bytes = 1};
    fathom_read_options read = default_read_options();
    quartiles seconds[BENCH_CLOCKS];
    static phases result;
    fathom_settings settings;
    fathom_scene *scene;
    read.width = 20, read.height = 40;
    fathom_status status = phases_read(context, in_folder(file), &read, &options, &scene, seconds);
    if (status == FATHOM_OK) {
        fathom_scene_settings(scene, &settings);
        settings.width = 20, settings.height = 40, settings.spp = 1;
        status = phases_measure(context, scene, &settings, "embree", &options, &result);
    }
    fathom_scene_destroy(scene);
    if (status != FATHOM_OK) return status;
    add(out, &result.time.ratio.closest, sizeof result.time.ratio.closest);
    add(out, &result.time.ratio.any, sizeof result.time.ratio.any);
    return FATHOM_OK;
}

UNIT_TEST(measuring) {
    exhaust(measure_error, "scene.json");
    exhaust(measure_trace, "scene.json");
    exhaust(measure_phases, "scene.json");
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

int main(void) { return unit_main(begin, end); }
