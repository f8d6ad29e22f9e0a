#include "verify/recorded.h"

#include "job/job.h"
#include "trace/tracer.h"

#include <stdlib.h>
#include <string.h>

/* ---- a tracer that forwards its calls and records them ---- */

typedef struct recorder {
    trace_tracer base;
    const trace_tracer *real;
    recorded *to;
} recorder;

static const recorder *of(const trace_tracer *tracer) { return (const recorder *)tracer; }

static oracle_ray ray_of(const trace_rays *rays, unsigned lane) {
    return (oracle_ray){trace_org(rays, lane), trace_dir(rays, lane), rays->t_near[lane], rays->t_far[lane]};
}

/* Bytes from one block's rays to the next one's. */
static size_t stride_of(bool any) { return any ? sizeof(trace_rays) : sizeof(trace_block); }

/* Returns the first of the call's blocks in the record, or SIZE_MAX. */
static size_t keep_rays(recorded *r, bool any, const void *rays, size_t count, trace_coherence coherence) {
    const size_t first = r->rays.count / LANES, blocks = (count + LANES - 1) / LANES;
    const recorded_call call = {first, count, coherence, any, rays};
    bool room = array_room(&r->rays, blocks * LANES) && array_room(&r->answers, blocks * LANES);
    r->failed = r->failed || !room || !array_push(&r->calls, call);
    if (r->failed) return SIZE_MAX;
    memset(&r->rays.items[first * LANES], 0, blocks * LANES * sizeof *r->rays.items);
    memset(&r->answers.items[first * LANES], 0, blocks * LANES * sizeof *r->answers.items);
    r->rays.count = r->answers.count = (first + blocks) * LANES;
    for (size_t i = 0; i < count; ++i) {
        const void *from = (const char *)rays + i / LANES * stride_of(any);
        r->rays.items[first * LANES + i] = ray_of(from, i % LANES);
    }
    return first;
}

static void closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence) {
    recorded *r = of(tracer)->to;
    (void)fine; /* renders do not use it */
    size_t first = keep_rays(r, false, blocks, count, coherence);
    trace_closest(of(tracer)->real, blocks, count, coherence);
    for (size_t i = 0; first != SIZE_MAX && i < count; ++i)
        r->answers.items[first * LANES + i] = ask_closest_of(&blocks[i / LANES], NULL, i % LANES);
}

static void any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    recorded *r = of(tracer)->to;
    size_t first = keep_rays(r, true, blocks, count, coherence);
    trace_any(of(tracer)->real, blocks, count, coherence);
    for (size_t i = 0; first != SIZE_MAX && i < count; ++i)
        r->answers.items[first * LANES + i].met = blocks[i / LANES].t_far[i % LANES] == -INFINITY;
}

static void destroy(trace_tracer *tracer) { (void)tracer; }

/* ---- its repair of leaks ---- */

/* Index in the record of the last ray that the render traced in this lane of its own block, or SIZE_MAX. */
static size_t place_of(const recorded *r, bool any, const void *block, unsigned lane) {
    const uintptr_t at = (uintptr_t)block;
    for (size_t k = r->calls.count; k-- > 0;) {
        const recorded_call *call = &r->calls.items[k];
        const uintptr_t from = (uintptr_t)call->from;
        const size_t ray = (at - from) / stride_of(any) * LANES + lane;
        if (call->any == any && at >= from && ray < call->count) return call->first * LANES + ray;
    }
    return SIZE_MAX;
}

/* A later round replaces an earlier one. Rounds of a block follow each other. */
static void keep_repaired(recorded *r, bool any, size_t ray, const ask_answer *answer) {
    const ask_other other = {ray, ASK_REPAIRED, any, *answer};
    if (ray == SIZE_MAX) return;
    for (size_t k = r->repaired.count; k-- > 0 && r->repaired.items[k].ray / LANES == ray / LANES;) {
        if (r->repaired.items[k].ray != ray) continue;
        r->repaired.items[k] = other;
        return;
    }
    r->failed = !array_push(&r->repaired, other) || r->failed;
}

static bool retry_closest(const trace_tracer *tracer, trace_block *block, unsigned lane, unsigned round) {
    const trace_tracer *real = of(tracer)->real;
    if (!real->retry->closest(real->self, block, lane, round)) return false;
    const ask_answer answer = ask_closest_of(block, NULL, lane);
    keep_repaired(of(tracer)->to, false, place_of(of(tracer)->to, false, block, lane), &answer);
    return true;
}

static bool retry_any(const trace_tracer *tracer, trace_rays *rays, unsigned lane, unsigned round) {
    const trace_tracer *real = of(tracer)->real;
    const ask_answer answer = {.hit = {.geometry = FATHOM_NONE}, .met = true};
    if (!real->retry->any(real->self, rays, lane, round)) return false;
    keep_repaired(of(tracer)->to, true, place_of(of(tracer)->to, true, rays, lane), &answer);
    return true;
}

static bool crossings(const trace_tracer *tracer, uint32_t group, vec3_f32 org, vec3_f32 dir,
                      trace_crossings *out) {
    const trace_tracer *real = of(tracer)->real;
    return real->retry->crossings(real->self, group, org, dir, out);
}

static void bounds(const trace_tracer *tracer, uint32_t group, vec3_f32 *lower, vec3_f32 *upper) {
    const trace_tracer *real = of(tracer)->real;
    real->retry->bounds(real->self, group, lower, upper);
}

/* ops.planes is true, because the recorded calls already include planes. */
static void recorder_begin(const trace_tracer *real, recorded *to, recorder *out) {
    static const trace_ops ops = {destroy, closest, any, false, true};
    static const trace_retry retry = {retry_closest, retry_any, crossings, bounds};
    *out = (recorder){.base = *real, .real = real, .to = to};
    out->base.ops = &ops, out->base.self = &out->base;
    if (real->retry) out->base.retry = &retry;
}

/* ---- the render ---- */

static fathom_status render(fathom_context *context, const world *w, const trace_tracer *tracer,
                            const fathom_settings *settings, fathom_progress_fn progress) {
    fathom_film *film;
    render_plan *plan = NULL;
    fathom_status status = film_create(context, w->scene, settings, &film);
    if (status != FATHOM_OK) return status;
    status = plan_create(context, w, tracer, settings, NULL, NULL, &plan);
    job_result result = {.samples = 0};
    const job_options options = {.progress = progress};
    if (status == FATHOM_OK) status = job_run(context, plan, &options, film, &result);
    plan_destroy(plan);
    fathom_film_destroy(film);
    return status;
}

fathom_status recorded_render(fathom_context *context, const world *w, const trace_tracer *tracer,
                              uint32_t width, fathom_progress_fn progress, recorded *out) {
    memset(out, 0, sizeof *out);
    recorder recording;
    recorder_begin(tracer, out, &recording);
    fathom_settings settings;
    fathom_settings_default(&settings);
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    settings.width = width, settings.height = width * 3 / 4, settings.spp = 1;
    unsigned threads = fathom_context_threads(context);
    fathom_context_set_threads(context, 1);
    fathom_status status = render(context, w, &recording.base, &settings, progress);
    fathom_context_set_threads(context, threads);
    if (status == FATHOM_OK && out->failed) status = fail_memory(context, sizeof *out->rays.items);
    return status;
}

void recorded_free(recorded *r) {
    array_free(&r->calls);
    array_free(&r->rays);
    array_free(&r->answers);
    array_free(&r->repaired);
    memset(r, 0, sizeof *r);
}
