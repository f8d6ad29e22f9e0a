/* Checks every tracer over every scene: builds both, records a render, and checks all rays. */
#include "cli/validate/validate.h"

#include "base/clock.h"
#include "cli/interrupt.h"
#include "cli/render/progress.h"
#include "verify/builtin.h"

#include <math.h>
#include <string.h>

#define FAILURES_KEPT 20000 /* of each family, for a file */
#define FAILURES_FIRST 1000 /* of each family, for the page, which shows the first wrong ones */

typedef struct work {
    const validate_settings *settings;
    const fathom_scene *scene; /* NULL: a built-in one */
    double next_look;          /* when to check its files again */
    validate_results *results;
    unsigned scenes;
    uint64_t before, total; /* rays */
    bool sampled; /* the exact search in this scene is already checked; it does not depend on the tracer */
} work;

static bool on_progress(void *user, uint64_t rays) {
    work *k = user;
    uint64_t done = k->before + rays;
    progress_work(k->results->start, (double)done / (double)k->total, done);
    if (k->scene && scene_watch_files(k->scene, &k->next_look) != FATHOM_OK) return false;
    return !interrupt_asked();
}

static validate_run *add_run(validate_runs *runs, const char *scene, const char *spec) {
    if (!array_room(runs, 1)) return NULL;
    validate_run *run = &runs->items[runs->count++];
    memset(run, 0, sizeof *run);
    run->scene = strdup(scene), run->spec = strdup(spec);
    return run->scene && run->spec ? run : NULL;
}

/* A tracer over the same world with other arithmetic and another structure than the subject. */
static fathom_status second_tracer(fathom_context *context, const judged_scene *stage, const trace_spec *spec,
                                   trace_tracer **out) {
    const trace_options options = {.words = spec->kind == TRACE_BVH ? "embree:user" : "bvh", .width = LANES};
    return trace_create(context, stage->world, &options, out);
}

#define LARGE 100000 /* primitives; rays cost more above, and mostly repeat the work of small scenes */

/* Number of rays of each family: fewer in large scenes, and far fewer if every primitive is tested. */
static uint64_t rays_of(const work *k, const judged_scene *stage, const trace_tracer *tracer) {
    uint64_t count = 0;
    for (size_t g = 0; g < stage->world->geometries.count; ++g)
        count += stage->world->geometries.items[g].count;
    uint64_t rays = k->settings->rays, part = trace_piece(tracer) <= LANES ? 64 : 4;
    return k->settings->scene || count < LARGE ? rays
           : rays / part > 16                  ? rays / part
           : rays < 16                         ? rays
                                               : 16;
}

/* The default power; at most SCREENED_A_RAY screened rays per checked ray, so that both take similar work. */
#define USUAL_POWER 3e-6
#define SCREENED_A_RAY 100

static uint64_t screened_of(const work *k) {
    const double power = k->settings->power, most = SCREENED_A_RAY * (double)k->settings->rays;
    if (power < 0) return (uint64_t)fmin(ceil(3 / (-power * USUAL_POWER) / k->scenes), most);
    return power > 0 ? (uint64_t)fmin(ceil(3 / power / k->scenes), 1e15) : 0;
}

#define RENDER_WIDTH 48
#define RENDER_WIDTH_SLOW 16

/* Renders, then checks the rays of the render and of all families. */
static fathom_status compare_all(fathom_context *context, work *k, const judged_scene *stage,
                                 const compare_subject *subject, validate_run *run) {
    const validate_settings *settings = k->settings;
    const bool slow = trace_piece(subject->tracer) <= LANES;
    recorded rendered;
    memset(&rendered, 0, sizeof rendered);
    trace_tracer *second = NULL;
    fathom_status status = FATHOM_OK;
    /* An extreme case has no view of its own. */
    const bool renders = !*stage->words && settings->families >> RAYS_RENDERED & 1;
    if (renders)
        status = recorded_render(context, stage->world, subject->tracer,
                                 slow ? RENDER_WIDTH_SLOW : RENDER_WIDTH, interrupt_go_on, &rendered);
    if (status == FATHOM_OK && settings->power != 0 && !slow)
        status = second_tracer(context, stage, &run->kind, &second);
    compare_options options = {.families = settings->families,
                               .rays = rays_of(k, stage, subject->tracer),
                               .seed = settings->seed,
                               .sample = k->sampled ? 0 : settings->sample,
                               .threads = settings->threads,
                               .failures = settings->failures ? FAILURES_KEPT : FAILURES_FIRST,
                               .rendered = renders ? &rendered : NULL,
                               .second = second,
                               .screened = screened_of(k),
                               .progress = on_progress,
                               .user = k,
                               .stopped = interrupt_asked};
    double start = clock_seconds();
    if (status == FATHOM_OK) status = compare_run(context, subject, &options, &run->result);
    run->seconds = clock_seconds() - start;
    k->sampled = true;
    trace_destroy(second);
    recorded_free(&rendered);
    bool judged = status == FATHOM_OK && statistics_run(&run->kind, run->result.families, &run->findings);
    return status == FATHOM_OK && !judged ? fail_memory(context, sizeof run->findings) : status;
}

static fathom_status judge(fathom_context *context, work *k, const judged_scene *stage, const char *scene,
                           const char *spec, validate_decoys *decoys) {
    compare_subject subject;
    trace_tracer *tracer;
    fathom_status status = validate_subject(context, stage, spec, &subject, &tracer);
    if (status != FATHOM_OK) return status;
    validate_run *run = add_run(&k->results->runs, scene, spec);
    status = run ? validate_decoys_add(context, decoys) : fail_memory(context, sizeof *run);
    if (status == FATHOM_OK) status = trace_spec_parse(context, run->spec, &run->kind);
    if (status == FATHOM_OK) {
        snprintf(run->tracer, sizeof run->tracer, "%s", trace_name(tracer));
        run->unit = trace_unit(tracer);
        k->scene = stage->b.scene;
        status = compare_all(context, k, stage, &subject, run);
    }
    trace_destroy(tracer);
    if (status != FATHOM_OUT_OF_RESOURCES) {
        fathom_status changed = fathom_scene_check_files(stage->b.scene);
        if (changed != FATHOM_OK) return changed;
    }
    if (run && run->result.differ)
        return fail_file(context, FATHOM_INTERNAL, scene,
                         "the search for exact hits and testing every primitive differ in %llu of %llu rays",
                         (unsigned long long)run->result.differ, (unsigned long long)run->result.sampled);
    return status;
}

static fathom_status skip(fathom_context *context, work *k, const char *scene, const char *spec) {
    validate_skip skipped;
    snprintf(skipped.spec, sizeof skipped.spec, "%s", spec);
    snprintf(skipped.scene, sizeof skipped.scene, "%s", scene);
    return array_push(&k->results->skips, skipped) ? FATHOM_OK : fail_memory(context, sizeof skipped);
}

static fathom_status run_tracer(fathom_context *context, work *k, const judged_scene *stage,
                                const char *scene, const char *words) {
    trace_spec spec;
    validate_decoys *decoys = NULL;
    fathom_status status = trace_spec_parse(context, words, &spec);
    if (status != FATHOM_OK) return status;
    if (!k->settings->scene && !judged_suits(stage, &spec)) return skip(context, k, scene, words);
    status = validate_decoys_begin(context, words, &decoys);
    if (status == FATHOM_OK) status = judge(context, k, stage, scene, words, decoys);
    validate_decoys_end(decoys);
    return status;
}

static fathom_status run_scene(fathom_context *context, work *k, const char *scene) {
    const args_list *tracers = &k->settings->tracers;
    judged_scene stage;
    fathom_status status = validate_stage_open(context, scene, &stage);
    k->sampled = false;
    for (size_t i = 0; i < tracers->count && status == FATHOM_OK; ++i) {
        status = run_tracer(context, k, &stage, scene, tracers->items[i]);
        k->before += k->settings->rays * (unsigned)__builtin_popcount(k->settings->families);
    }
    judged_close(&stage);
    return status;
}

fathom_status validate_run_all(fathom_context *context, const validate_settings *settings,
                               validate_results *results) {
    unsigned scenes = 0;
    while (builtin_name(scenes)) ++scenes;
    if (settings->scene) scenes = 1;
    work k = {.settings = settings, .results = results, .scenes = scenes};
    k.total =
        scenes * settings->tracers.count * (unsigned)__builtin_popcount(settings->families) * settings->rays;
    results->start = clock_seconds();
    fathom_status status = FATHOM_OK;
    for (unsigned i = 0; i < scenes && status == FATHOM_OK; ++i)
        status = run_scene(context, &k, settings->scene ? settings->scene : builtin_name(i));
    progress_clear_line();
    return status;
}
