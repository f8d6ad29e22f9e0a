#include "measure/converge.h"

#include "image/compare/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *converge_metric_name(converge_metric metric) {
    static const char *const names[CONVERGE_METRICS] = {"rmse", "relmse", "flip"};
    return names[metric];
}

const char *converge_pattern_name(fathom_pattern pattern) {
    switch (pattern) {
    case FATHOM_PATTERN_GRID: return "grid";
    case FATHOM_PATTERN_STRATIFIED: return "stratified";
    case FATHOM_PATTERN_SOBOL: return "sobol";
    }
    return "";
}

/* ---- images and their errors ---- */

typedef struct picture {
    float *memory;
    metric_image image;
    flip_view *view;
} picture;

static fathom_status picture_create(fathom_context *context, const bench_stage *stage, picture *out) {
    size_t pixels = (size_t)stage->settings.width * stage->settings.height;
    *out = (picture){.memory = malloc(3 * pixels * sizeof *out->memory)};
    if (!out->memory) return fail_memory(context, 3 * pixels * sizeof *out->memory);
    out->image = (metric_image){{out->memory, out->memory + pixels, out->memory + 2 * pixels},
                                stage->settings.width,
                                stage->settings.height};
    return FATHOM_OK;
}

static fathom_status picture_see(fathom_context *context, picture *p, double ppd) {
    flip_view_destroy(p->view);
    p->view = flip_view_create(&p->image, ppd);
    if (p->view) return FATHOM_OK;
    return fail_memory(context, (size_t)p->image.width * p->image.height * 8 * sizeof(double));
}

static void picture_free(picture *p) {
    free(p->memory);
    flip_view_destroy(p->view);
}

static void measure_errors(const picture *reference, const picture *test, double errors[CONVERGE_METRICS]) {
    errors[CONVERGE_RMSE] = metric_rmse(&reference->image, &test->image);
    errors[CONVERGE_RELMSE] = metric_relmse(&reference->image, &test->image);
    errors[CONVERGE_FLIP] = flip_mean(reference->view, test->view, NULL);
}

/* ---- the work ---- */

typedef struct work {
    fathom_context *context;
    const bench_stage *stage;
    const converge_options *options;
    converge_result *result;
    double done, now, total; /* samples a pixel: of images that are there, of this one, of all */
} work;

static bool on_progress(void *user, const fathom_progress *progress) {
    const work *k = user;
    return k->options->progress(k->options->user, (k->done + progress->fraction * k->now) / k->total);
}

static fathom_status take(work *k, const stage_shot *shot, picture *p, stage_cost *cost) {
    k->now = shot->spp;
    fathom_status status = stage_render(k->context, k->stage, shot, k->options->progress ? on_progress : NULL,
                                        k, p->memory, cost);
    k->done += k->now;
    if (status == FATHOM_OK) status = picture_see(k->context, p, k->options->ppd);
    return status;
}

/* Seeds far from those of the rounds. */
static fathom_status take_half(work *k, unsigned half, picture *p) {
    const stage_shot shot = {FATHOM_PATTERN_SOBOL, k->options->half_spp,
                             k->options->seed + ((uint64_t)(half + 1) << 62)};
    stage_cost cost;
    fathom_status status = take(k, &shot, p, &cost);
    for (int c = 0; c < BENCH_CLOCKS && status == FATHOM_OK; ++c)
        k->result->reference.seconds.by[c] += cost.seconds.by[c];
    return status;
}

static fathom_status make_reference(work *k, picture halves[2], picture *reference) {
    converge_reference *r = &k->result->reference;
    r->spp = k->options->half_spp;
    fathom_status status = take_half(k, 0, &halves[0]);
    if (status == FATHOM_OK) status = take_half(k, 1, &halves[1]);
    if (status != FATHOM_OK) return status;
    measure_errors(&halves[0], &halves[1], r->halves);
    r->nonfinite = metric_nonfinite(&halves[0].image, &halves[1].image);
    static const double parts[CONVERGE_METRICS] = {0.5, 0.25, 1};
    for (int m = 0; m < CONVERGE_METRICS; ++m) r->own[m] = parts[m] * r->halves[m];
    size_t values = 3 * (size_t)reference->image.width * reference->image.height;
    for (size_t i = 0; i < values; ++i)
        reference->memory[i] = (float)(0.5 * ((double)halves[0].memory[i] + (double)halves[1].memory[i]));
    return picture_see(k->context, reference, k->options->ppd);
}

static fathom_status run_one(work *k, const picture *reference, picture *test, converge_run run) {
    const stage_shot shot = {run.pattern, 1u << (2 * run.step), k->options->seed + run.round};
    stage_cost cost;
    fathom_status status = take(k, &shot, test, &cost);
    if (status != FATHOM_OK) return status;
    run.seconds = cost.seconds, run.rays = cost.rays;
    run.nonfinite = metric_nonfinite(&test->image, &test->image);
    measure_errors(reference, test, run.errors);
    return array_push(&k->result->runs, run) ? FATHOM_OK : fail_memory(k->context, sizeof run);
}

static fathom_status run_all(work *k, const picture *reference, picture *test) {
    fathom_status status = FATHOM_OK;
    for (unsigned round = 0; round < k->result->rounds; ++round) {
        for (unsigned step = 0; step < k->result->steps; ++step) {
            for (unsigned p = 0; p < CONVERGE_PATTERNS && status == FATHOM_OK; ++p) {
                const converge_run run = {.round = round, .step = step, .pattern = (fathom_pattern)p};
                status = run_one(k, reference, test, run);
            }
        }
    }
    return status;
}

static fathom_status measure(work *k) {
    picture pictures[3] = {{.memory = NULL}}; /* halves, of which one then is the test; the reference */
    fathom_status status = FATHOM_OK;
    for (int i = 0; i < 3 && status == FATHOM_OK; ++i)
        status = picture_create(k->context, k->stage, &pictures[i]);
    if (status == FATHOM_OK) status = make_reference(k, pictures, &pictures[2]);
    if (status == FATHOM_OK) status = run_all(k, &pictures[2], &pictures[0]);
    for (int i = 0; i < 3; ++i) picture_free(&pictures[i]);
    return status;
}

static void keep_whole(converge_result *r) {
    unsigned images = (unsigned)r->runs.count;
    r->rounds = images / (r->steps * CONVERGE_PATTERNS);
    if (!r->rounds) r->rounds = 1, r->steps = images / CONVERGE_PATTERNS;
    r->runs.count = (size_t)r->rounds * r->steps * CONVERGE_PATTERNS;
}

fathom_status converge_measure(fathom_context *context, const bench_stage *stage,
                               const converge_options *options, converge_result *out) {
    *out = (converge_result){.rounds = options->rounds, .steps = 1};
    while (out->steps < CONVERGE_STEPS_MAX && 1u << (2 * out->steps) <= options->max_spp) ++out->steps;
    work k = {.context = context, .stage = stage, .options = options, .result = out};
    k.total = 2 * (double)options->half_spp;
    for (unsigned step = 0; step < out->steps; ++step)
        k.total += (double)out->rounds * CONVERGE_PATTERNS * (1u << (2 * step));
    fathom_status status = measure(&k);
    if (status == FATHOM_INTERRUPTED) keep_whole(out);
    if (out->runs.count) converge_summarise(out);
    return status;
}

void converge_free(converge_result *result) { array_free(&result->runs); }
