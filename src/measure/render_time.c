#include "measure/render_time.h"

#include "base/clock.h"
#include "job/job.h"
#include "measure/replay.h"
#include "measure/stage.h"

#include <stdlib.h>

typedef struct bench {
    fathom_context *context;
    const world *world;
    const trace_tracer *tracer;
    const fathom_settings *settings;
    const render_time_options *options;
    render_time *out;
    bench_watch speeds, ratio; /* parts of options->watch */
} bench;

/* One render phase, with its own plan and film, as in a normal render. */
static fathom_status render_once(const bench *b, const trace_tracer *tracer, const fathom_settings *settings,
                                 unsigned threads, record *recorded, stage_cost *out) {
    fathom_film *film = NULL;
    fathom_context_set_threads(b->context, threads);
    fathom_status status = film_create(b->context, b->world->scene, settings, &film);
    const job_options options = {.deadline = clock_seconds() + settings->max_time};
    if (status == FATHOM_OK)
        status = stage_film(b->context, b->world, tracer, settings, &options, film, recorded, out);
    fathom_film_destroy(film);
    return status;
}

/* ---- against the bare calls ---- */

typedef struct sums {
    double render[RENDER_TIME_REPEATS_MAX], traced[RENDER_TIME_REPEATS_MAX], bare[RENDER_TIME_REPEATS_MAX];
} sums;

/* Alternates the order of the render and the bare replay, so that slow changes of the machine affect both
 * equally. */
static fathom_status time_band(bench *b, const record *r, const fathom_settings *settings,
                               const bench_watch *watch, sums *s) {
    for (unsigned k = 0; k < b->options->repeats; ++k) {
        stage_cost render;
        replay_result bare, traced;
        bool first = k % 2, ok = true;
        if (first) ok = replay(r, b->tracer, true, &bare);
        fathom_status status = render_once(b, b->tracer, settings, 1, NULL, &render);
        if (status != FATHOM_OK) return status;
        if (!first) ok = replay(r, b->tracer, true, &bare);
        if (!ok || !replay(r, b->tracer, false, &traced)) return fail_memory(b->context, sizeof *r);
        s->render[k] += render.seconds.by[BENCH_CPU], s->bare[k] += bare.cpu_seconds,
            s->traced[k] += traced.cpu_seconds;
        bench_watch_tell(watch, k + 1, b->options->repeats);
    }
    return FATHOM_OK;
}

static fathom_status record_band(const bench *b, const fathom_settings *settings, record *r) {
    trace_tracer *recorder = record_tracer(b->tracer, r);
    if (!recorder) return fail_memory(b->context, sizeof *r);
    stage_cost render;
    fathom_status status = render_once(b, recorder, settings, 1, r, &render);
    trace_destroy(recorder);
    if (status != FATHOM_OK || !r->out_of_memory) return status;
    return fail(b->context, FATHOM_OUT_OF_RESOURCES,
                "out of memory for the rays of a render; expected fewer samples or a smaller image");
}

/* Rows of the image whose rays need at most record_bytes: whole tiles, at least one. */
static uint32_t band_rows(const bench *b, uint32_t rows) {
    double rays = (double)plan_expected_rays(b->world->scene, b->settings);
    double bytes = rays / LANES * sizeof(trace_rays) / rows;
    double fit = (double)b->options->record_bytes / bytes;
    uint32_t tile = b->settings->tile_size;
    if (fit >= rows) return rows;
    return fit < tile ? tile : (uint32_t)fit / tile * tile;
}

static fathom_status time_bands(bench *b, record *r, sums *s) {
    fathom_settings part = *b->settings;
    uint32_t *c = part.crop;
    if (!c[2]) c[0] = c[1] = 0, c[2] = part.width, c[3] = part.height;
    const uint32_t end = c[3], all = end - c[1], rows = band_rows(b, all);
    fathom_status status = FATHOM_OK;
    for (uint32_t y = c[1]; y < end && status == FATHOM_OK; y = c[3]) {
        uint32_t next = (y + rows) / part.tile_size * part.tile_size;
        c[1] = y, c[3] = end - y <= rows ? end : next;
        const bench_watch watch =
            bench_watch_part(&b->ratio, (double)(all - (end - y)) / all, (double)(all - (end - c[3])) / all);
        status = record_band(b, &part, r);
        if (status == FATHOM_OK) status = time_band(b, r, &part, &watch, s);
        b->out->ratio.closest += record_rays(r, BARE_CLOSEST);
        b->out->ratio.any += record_rays(r, BARE_ANY);
        ++b->out->ratio.bands;
    }
    return status;
}

static void set_ratio(render_ratio *ratio, sums *s, unsigned repeats) {
    double to_bare[RENDER_TIME_REPEATS_MAX];
    for (unsigned k = 0; k < repeats; ++k) to_bare[k] = s->render[k] / s->bare[k];
    ratio->render_to_bare = quartiles_of(to_bare, repeats);
    for (unsigned k = 0; k < repeats; ++k) to_bare[k] = s->traced[k] / s->bare[k];
    ratio->traced_to_bare = quartiles_of(to_bare, repeats);
    ratio->render = quartiles_of(s->render, repeats);
    ratio->traced = quartiles_of(s->traced, repeats);
    ratio->bare = quartiles_of(s->bare, repeats);
}

static fathom_status measure_ratio(bench *b) {
    if (!embree_bare_possible(b->tracer)) return FATHOM_OK;
    sums *s = calloc(1, sizeof *s);
    if (!s) return fail_memory(b->context, sizeof *s);
    record r = {.blocks = 0};
    fathom_status status = time_bands(b, &r, s);
    record_free(&r);
    b->out->has_ratio = status == FATHOM_OK;
    if (b->out->has_ratio) set_ratio(&b->out->ratio, s, b->options->repeats);
    free(s);
    return status;
}

/* ---- by threads ---- */

typedef struct speed_sums {
    double plan[RENDER_TIME_REPEATS_MAX];
    double seconds[RENDER_TIME_THREADS_MAX][RENDER_TIME_REPEATS_MAX];
    double cpu[RENDER_TIME_THREADS_MAX][RENDER_TIME_REPEATS_MAX];
} speed_sums;

static void set_speeds(const bench *b, speed_sums *s) {
    unsigned repeats = b->options->repeats;
    double gain[RENDER_TIME_REPEATS_MAX];
    b->out->plan_seconds = quartiles_of(s->plan, repeats);
    b->out->speed_count = b->options->thread_counts;
    for (unsigned t = b->options->thread_counts; t-- > 0;) { /* [0] last: sorting it loses its order */
        render_speed *speed = &b->out->speeds[t];
        for (unsigned k = 0; k < repeats; ++k) gain[k] = s->seconds[0][k] / s->seconds[t][k];
        speed->threads = b->options->threads[t];
        speed->speedup = quartiles_of(gain, repeats);
        speed->seconds = quartiles_of(s->seconds[t], repeats);
        speed->cpu_seconds = quartiles_of(s->cpu[t], repeats);
    }
}

static fathom_status measure_speeds(bench *b) {
    speed_sums *s = calloc(1, sizeof *s);
    if (!s) return fail_memory(b->context, sizeof *s);
    fathom_status status = FATHOM_OK;
    for (unsigned k = 0; k < b->options->repeats; ++k) {
        for (unsigned t = 0; t < b->options->thread_counts && status == FATHOM_OK; ++t) {
            stage_cost render = {.plan = 0};
            status = render_once(b, b->tracer, b->settings, b->options->threads[t], NULL, &render);
            s->plan[k] = render.plan;
            s->seconds[t][k] = render.seconds.by[BENCH_WALL], s->cpu[t][k] = render.seconds.by[BENCH_CPU];
            b->out->rays = render.rays;
        }
        bench_watch_tell(&b->speeds, k + 1, b->options->repeats);
    }
    if (status == FATHOM_OK) set_speeds(b, s);
    free(s);
    return status;
}

fathom_status render_time_measure(fathom_context *context, const world *w, const trace_tracer *tracer,
                                  const fathom_settings *settings, const render_time_options *options,
                                  render_time *out) {
    *out = (render_time){.speed_count = 0};
    /* The replays of a repetition take slightly longer than its renders. */
    const double split = embree_bare_possible(tracer) ? 0.4 : 1;
    bench b = {.context = context,
               .world = w,
               .tracer = tracer,
               .settings = settings,
               .options = options,
               .out = out};
    b.speeds = bench_watch_part(options->watch, 0, split);
    b.ratio = bench_watch_part(options->watch, split, 1);
    fathom_status status = measure_speeds(&b);
    return status == FATHOM_OK ? measure_ratio(&b) : status;
}
