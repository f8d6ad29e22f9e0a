#include "measure/build_time.h"

#include "integrate/plan.h"

#include <math.h>
#include <stdio.h>

typedef struct samples {
    double build[BENCH_CLOCKS][BUILD_REPEATS_MAX], sample[BENCH_CLOCKS][BUILD_REPEATS_MAX];
} samples;

static const char *const names[BUILD_QUALITIES] = {"low", "medium", "high"};

static fathom_status measure_one(fathom_context *context, bench_stage *stage, const char *tracer,
                                 uint32_t spp, unsigned repeat, quality_time *quality, samples *out) {
    char words[TRACE_SPEC_LENGTH];
    snprintf(words, sizeof words, "%s:%s", tracer, quality->name);
    const stage_shot shot = {FATHOM_PATTERN_SOBOL, spp, 0};
    stage_cost cost;
    fathom_status status = stage_build(context, stage, words, 0);
    if (status == FATHOM_OK) status = stage_render(context, stage, &shot, NULL, NULL, NULL, &cost);
    if (status != FATHOM_OK) return status;
    quality->rays = (cost.rays + spp / 2) / spp;
    quality->bvh_bytes = trace_bvh_bytes(stage->tracer);
    quality->peak_bytes = trace_peak_bytes(stage->tracer);
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        out->build[c][repeat] = stage->build.by[c];
        out->sample[c][repeat] = cost.seconds.by[c] / spp;
    }
    return FATHOM_OK;
}

fathom_status build_time_measure(fathom_context *context, bench_stage *stage, const char *words,
                                 unsigned repeats, uint32_t spp, const bench_watch *watch, build_time *out) {
    samples taken[BUILD_QUALITIES];
    fathom_status status = FATHOM_OK;
    for (unsigned q = 0; q < BUILD_QUALITIES; ++q) out->qualities[q] = (quality_time){.name = names[q]};
    bench_watch_tell(watch, 0, repeats);
    for (unsigned repeat = 0; repeat < repeats; ++repeat) {
        for (unsigned q = 0; q < BUILD_QUALITIES && status == FATHOM_OK; ++q)
            status = measure_one(context, stage, words, spp, repeat, &out->qualities[q], &taken[q]);
        bench_watch_tell(watch, repeat + 1, repeats);
    }
    if (status != FATHOM_OK) return status;
    for (unsigned q = 0; q < BUILD_QUALITIES; ++q) {
        for (int c = 0; c < BENCH_CLOCKS; ++c) {
            out->qualities[q].build[c] = quartiles_of(taken[q].build[c], repeats);
            out->qualities[q].sample[c] = quartiles_of(taken[q].sample[c], repeats);
        }
    }
    build_time_summarise(stage, out);
    return FATHOM_OK;
}

/* Two lines b + n t cross at n = (b' - b) / (t - t'): from there on the one of the smaller t is lower. Of
 * equal slopes the one that begins lower is so everywhere, and of equal lines both are. */
static void find_range(build_time *result, unsigned q, int clock) {
    quality_time *self = &result->qualities[q];
    self->from[clock] = 0, self->to[clock] = INFINITY;
    for (unsigned k = 0; k < BUILD_QUALITIES; ++k) {
        const quality_time *other = &result->qualities[k];
        double begins = self->build[clock].median - other->build[clock].median;
        double gains = other->sample[clock].median - self->sample[clock].median;
        if (gains > 0)
            self->from[clock] = fmax(self->from[clock], begins / gains);
        else if (gains < 0)
            self->to[clock] = fmin(self->to[clock], begins / gains);
        else if (begins > 0)
            self->to[clock] = 0;
    }
}

static void find_best(build_total *total) {
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        total->best[c] = 0;
        for (unsigned q = 1; q < BUILD_QUALITIES; ++q) {
            if (total->seconds[q][c] < total->seconds[total->best[c]][c]) total->best[c] = q;
        }
        total->behind[c] = total->seconds[total->automatic][c] / total->seconds[total->best[c]][c] - 1;
    }
}

static build_total total_of(const bench_stage *stage, const build_time *result, uint32_t spp) {
    fathom_settings settings = stage->settings;
    settings.spp = spp;
    trace_quality automatic = trace_quality_auto(plan_expected_rays(stage->scene, &settings), stage->world);
    build_total total = {.spp = spp, .automatic = (unsigned)automatic - TRACE_QUALITY_LOW};
    for (unsigned q = 0; q < BUILD_QUALITIES; ++q) {
        const quality_time *quality = &result->qualities[q];
        for (int c = 0; c < BENCH_CLOCKS; ++c)
            total.seconds[q][c] = quality->build[c].median + spp * quality->sample[c].median;
    }
    find_best(&total);
    return total;
}

void build_time_summarise(const bench_stage *stage, build_time *result) {
    for (unsigned q = 0; q < BUILD_QUALITIES; ++q) {
        for (int c = 0; c < BENCH_CLOCKS; ++c) find_range(result, q, c);
    }
    for (unsigned i = 0; i < BUILD_TOTALS; ++i) result->totals[i] = total_of(stage, result, 1u << (2 * i));
}
