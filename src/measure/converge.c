#include "measure/converge.h"

#include "image/compare/flip.h"

#include <math.h>
#include <stdlib.h>

const char *converge_metric_name(converge_metric metric) {
    static const char *const names[CONVERGE_METRICS] = {"rmse", "relmse", "flip"};
    return names[metric];
}

const char *converge_pattern_name(fathom_pattern pattern) {
    static const char *const names[CONVERGE_PATTERNS] = {"grid", "stratified", "sobol"};
    return names[pattern];
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
    double done, now, total; /* samples a pixel: of finished images, of the current one, of all */
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

/* The seeds are far from those of the rounds. */
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
    const ray_counts *rays = &cost.rays;
    run.seconds = cost.seconds, run.rays = rays->camera + rays->shadow + rays->reflection + rays->refraction;
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
    picture pictures[3] = {{.memory = NULL}}; /* two halves, then tests in the first; the reference */
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

/* ---- points ---- */

static double geometric_mean(const double *values, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; ++i) sum += log(values[i]);
    return exp(sum / (double)count);
}

static size_t runs_of(const converge_result *result, fathom_pattern pattern, unsigned step,
                      const converge_run *out[CONVERGE_SEEDS_MAX]) {
    size_t count = 0;
    for (size_t i = 0; i < result->runs.count && count < CONVERGE_SEEDS_MAX; ++i) {
        const converge_run *run = &result->runs.items[i];
        if (run->pattern == pattern && run->step == step) out[count++] = run;
    }
    return count;
}

static converge_point point_of(const converge_result *result, fathom_pattern pattern, unsigned step) {
    const converge_run *runs[CONVERGE_SEEDS_MAX];
    size_t count = runs_of(result, pattern, step, runs);
    double values[CONVERGE_SEEDS_MAX];
    converge_point point = {.spp = 1u << (2 * step)};
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        for (size_t i = 0; i < count; ++i) values[i] = runs[i]->seconds.by[c];
        point.seconds.by[c] = quartiles_of(values, count).median;
    }
    for (int m = 0; m < CONVERGE_METRICS; ++m) {
        for (size_t i = 0; i < count; ++i) values[i] = runs[i]->errors[m];
        point.errors[m] = geometric_mean(values, count);
        point.below[m] = point.errors[m] < result->reference.halves[m];
    }
    return point;
}

/* True if fits and tables count the point. */
static bool counts(const converge_point *point, converge_metric metric) {
    return point->errors[metric] > 0 && isfinite(point->errors[metric]) && !point->below[metric];
}

/* ---- slopes ---- */

/* Logarithms of the points of one round that count. */
static size_t take_round(const converge_result *result, const converge_curve *curve, unsigned round,
                         int metric, int clock, double *x, double *y) {
    size_t count = 0;
    for (unsigned step = 0; step < result->steps; ++step) {
        const converge_run *runs[CONVERGE_SEEDS_MAX];
        if (!counts(&curve->points[step], (converge_metric)metric)) continue;
        size_t there = runs_of(result, curve->pattern, step, runs);
        for (size_t i = 0; i < there; ++i) {
            if (runs[i]->round != round) continue;
            x[count] = log(runs[i]->seconds.by[clock]), y[count] = log(runs[i]->errors[metric]);
            ++count;
        }
    }
    return count;
}

static converge_slope slope_of(const converge_result *result, const converge_curve *curve, int metric,
                               int clock) {
    double x[CONVERGE_STEPS_MAX], y[CONVERGE_STEPS_MAX], slopes[CONVERGE_SEEDS_MAX], intercept = 0;
    size_t points = 0;
    for (unsigned round = 0; round < result->rounds; ++round) {
        points = take_round(result, curve, round, metric, clock, x, y);
        line_fit fit = line_through(x, y, points);
        slopes[round] = fit.slope;
        intercept += fit.intercept / result->rounds;
    }
    return (converge_slope){mean_of(slopes, result->rounds), exp(intercept), (unsigned)points};
}

void converge_summarise(converge_result *result) {
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        converge_curve *curve = &result->curves[p];
        curve->pattern = (fathom_pattern)p;
        for (unsigned step = 0; step < result->steps; ++step)
            curve->points[step] = point_of(result, curve->pattern, step);
        for (int m = 0; m < CONVERGE_METRICS; ++m)
            for (int c = 0; c < BENCH_CLOCKS; ++c) curve->slopes[m][c] = slope_of(result, curve, m, c);
    }
}

/* ---- equal time, equal error ---- */

typedef struct place {
    double seconds, error;
} place;

static size_t places_of(const converge_result *result, const converge_curve *curve, converge_metric metric,
                        place out[CONVERGE_STEPS_MAX]) {
    size_t count = 0;
    for (unsigned step = 0; step < result->steps; ++step) {
        const converge_point *point = &curve->points[step];
        if (counts(point, metric))
            out[count++] = (place){point->seconds.by[BENCH_CPU], point->errors[metric]};
    }
    return count;
}

/* Interpolates along the first line segment that contains x, in logarithms. */
static double interpolate(const place *places, size_t count, bool by_error, double x) {
    for (size_t i = 0; i + 1 < count; ++i) {
        const place *a = &places[i], *b = a + 1;
        double from = by_error ? a->error : a->seconds, to = by_error ? b->error : b->seconds;
        if (x < fmin(from, to) || x > fmax(from, to) || from == to) continue;
        double first = by_error ? a->seconds : a->error, second = by_error ? b->seconds : b->error;
        return first * pow(second / first, log(x / from) / log(to / from));
    }
    return (double)NAN;
}

size_t converge_equal(const converge_result *result, converge_metric metric, bool by_error,
                      converge_row out[CONVERGE_ROWS]) {
    place places[CONVERGE_PATTERNS][CONVERGE_STEPS_MAX];
    size_t counts[CONVERGE_PATTERNS];
    double low = 0, high = INFINITY; /* the range that all patterns cover */
    for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p) {
        counts[p] = places_of(result, &result->curves[p], metric, places[p]);
        double least = INFINITY, most = 0;
        for (size_t i = 0; i < counts[p]; ++i) {
            double x = by_error ? places[p][i].error : places[p][i].seconds;
            least = fmin(least, x), most = fmax(most, x);
        }
        low = fmax(low, least), high = fmin(high, most);
    }
    if (!(low > 0 && low < high)) return 0;
    for (size_t row = 0; row < CONVERGE_ROWS; ++row) {
        double part = ((double)row + 0.5) / CONVERGE_ROWS;
        if (by_error) part = 1 - part; /* the largest error first */
        out[row].at = low * pow(high / low, part);
        for (unsigned p = 0; p < CONVERGE_PATTERNS; ++p)
            out[row].values[p] = interpolate(places[p], counts[p], by_error, out[row].at);
    }
    return CONVERGE_ROWS;
}
