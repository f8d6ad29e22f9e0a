#include "integrate/plan.h"

#include "base/threads.h"
#include "integrate/path/path_scout_inner.h"

#include <math.h>
#include <stdlib.h>

/* One path for this many samples of the image, in squares of 4 × 4 pixels: at least 64 squares, at most 2^15.
 */
#define SAMPLES_PER_PATH 16u
#define SPP_TO_TIME 4u
#define LEAST_SQUARES 64u
#define MOST_SQUARES (1u << 15)
/* Most light has been sampled after this many scatterings. */
#define MOST_DEPTH 4u
/* The image uses other random numbers, because these paths decide how it samples. */
#define OTHER_SEED 0x5ce7a5c0u
/* An eighth of the paths run first, in at most this many squares. The others would gain little if more than a
 * third of their light samples from outside arrive, and more than three quarters of those from several lamps,
 * or if these bring less than an eighth of the light. */
#define FIRST_SQUARES (1u << 10)
#define ROOM (1 / 3.0)
#define LAMP_ROOM 0.75
#define DIM (1 / 8.0)
/* The paths of this many squares set the probabilities of the classes of lights. */
#define GLANCE_SQUARES (1u << 13)

/* All threads. */
typedef struct scouting {
    const render_plan *plan;
    const atomic_bool *stop;
    atomic_bool fails; /* out of memory */
    uint32_t squares, batches, done;
    scout_report *found; /* by batch */
    path_scout **scouts;
    unsigned threads;
} scouting;

/* Squares spread over the image by the additive recurrence R2 (Roberts 2018). */
static wave_square square_at(const render_plan *plan, uint32_t k) {
    const double across = (plan->settings.width + 3) / 4, down = (plan->settings.height + 3) / 4;
    const double u = 0.5 + k * 0.7548776662466927, v = 0.5 + k * 0.5698402909980532;
    return (wave_square){4 * (uint32_t)((u - floor(u)) * across), 4 * (uint32_t)((v - floor(v)) * down), k,
                         0};
}

/* A render to a time may be short, so it is planned as one with few samples. */
static uint32_t square_count(const render_plan *plan) {
    const fathom_settings *s = &plan->settings;
    const uint64_t pixels = (uint64_t)s->width * s->height, /* a crop changes no pixel */
        spp = s->max_time > 0 ? SPP_TO_TIME : plan_expected_spp(s),
                   squares = pixels * spp / (SAMPLES_PER_PATH * LANES);
    return squares < LEAST_SQUARES  ? LEAST_SQUARES
           : squares < MOST_SQUARES ? (uint32_t)squares
                                    : MOST_SQUARES;
}

static path_scout *hire(const scouting *all) {
    path_scout *s = calloc(1, sizeof *s);
    if (!s) return NULL;
    s->wave = (path_wave *)integrator_path.create(all->plan, all->stop);
    if (s->wave) s->wave->scout = s;
    s->fails = !s->wave;
    return s;
}

static void run_batch(scouting *all, path_scout *s, uint32_t b) {
    const wave_region image = {0, 0, all->plan->settings.width, all->plan->settings.height, 0, 0};
    const uint32_t first = b * WAVE_SQUARES;
    wave_batch batch = {.count = min_u32(all->squares - first, WAVE_SQUARES)};
    for (uint32_t k = 0; k < batch.count; ++k) batch.squares[k] = square_at(all->plan, first + k);
    s->glances = first < GLANCE_SQUARES;
    s->fails |= !integrator_path.run(&s->wave->wave.run, &image, &batch);
    all->found[b] = s->report;
    s->report = (scout_report){.sums = {{0}}};
    s->answered = 0;
}

static void run_batches(void *user, size_t begin, size_t end, unsigned worker) {
    scouting *all = user;
    if (!all->scouts[worker]) all->scouts[worker] = hire(all);
    path_scout *s = all->scouts[worker];
    const unsigned state = trace_thread_begin();
    for (size_t b = begin; s && b < end && !s->fails; ++b) run_batch(all, s, all->done + (uint32_t)b);
    trace_thread_end(state);
    if (!s) atomic_store(&all->fails, true);
}

/* The fraction of a class's light samples that arrived, and its fraction of all light. */
typedef struct scout_view {
    double seen, light;
} scout_view;

static scout_view view_of(const scouting *all, emitter_part part) {
    scout_sum own = {0};
    double light = 0;
    for (uint32_t b = 0; b < all->done; ++b) {
        const scout_sum *sums = all->found[b].sums;
        own.asked += sums[part].asked, own.seen += sums[part].seen, own.light += sums[part].light;
        for (int k = 0; k < EMITTER_PARTS; ++k) light += sums[k].light;
    }
    return (scout_view){own.asked > 0 ? own.seen / own.asked : 1, light > 0 ? own.light / light : 0};
}

/* True if further paths may gain something. */
static bool is_hidden(const scouting *all, emitter_part part, double room) {
    const scout_view view = view_of(all, part);
    return view.seen < room && view.light > DIM;
}

/* Runs batches up to `end`. False: out of memory. */
static bool run_until(scouting *all, uint32_t end) {
    loop_workers(all->threads, end - all->done, 1, run_batches, all);
    all->done = end;
    for (unsigned t = 0; t < all->threads; ++t)
        if (all->scouts[t] && all->scouts[t]->fails) return false;
    return !all->fails;
}

/* The first paths tell whether more are needed. False: out of memory. */
static bool scout(scouting *all, emitters *e) {
    const uint32_t first = min_u32((all->batches + 7) / 8, FIRST_SQUARES / WAVE_SQUARES);
    emitter_lesson lesson = {.by = all->plan->emitters};
    if (!run_until(all, first)) return false;
    const bool more = is_hidden(all, EMITTER_OUTSIDE, ROOM) ||
                      (emitters_choose_finite(e) && is_hidden(all, EMITTER_FINITE, LAMP_ROOM));
    if (more && !run_until(all, all->batches)) return false;
    const scout_view outside = view_of(all, EMITTER_OUTSIDE);
    lesson.seen = outside.seen, lesson.outside = outside.light;
    scout_report *r = &all->found[0];
    if (!scout_collect(r, all->done)) return false;
    lesson.rays = r->rays.items, lesson.ray_count = r->rays.count;
    lesson.glances = r->glances.items, lesson.glance_count = r->glances.count;
    return emitters_learn(e, &lesson);
}

static render_plan plan_for(const render_plan *plan, emitters *asked) {
    render_plan out = plan_before(plan, OTHER_SEED);
    out.emitters = asked;
    out.groups.count = 0;
    out.max_depth = min_u32(plan->max_depth, MOST_DEPTH);
    return out;
}

static void release(scouting *all) {
    for (unsigned t = 0; all->scouts && t < all->threads; ++t) {
        if (!all->scouts[t]) continue;
        if (all->scouts[t]->wave) integrator_path.destroy(&all->scouts[t]->wave->wave.run);
        array_free(&all->scouts[t]->report.rays);
        array_free(&all->scouts[t]->report.glances);
        free(all->scouts[t]);
    }
    for (uint32_t b = 0; all->found && b < all->batches; ++b) {
        array_free(&all->found[b].rays);
        array_free(&all->found[b].glances);
    }
    free(all->scouts);
    free(all->found);
}

fathom_status path_scout_lights(fathom_context *context, render_plan *plan, const atomic_bool *stop) {
    emitters *asked;
    bool fine = emitters_scout(plan->emitters, &asked);
    if (fine && !asked) return FATHOM_OK;
    const render_plan few = plan_for(plan, asked);
    const uint32_t squares = square_count(plan), batches = (squares + WAVE_SQUARES - 1) / WAVE_SQUARES;
    scouting all = {.plan = &few,
                    .stop = stop,
                    .squares = squares,
                    .batches = batches,
                    .threads = fathom_context_threads(context)};
    all.found = calloc(batches, sizeof *all.found), all.scouts = calloc(all.threads, sizeof *all.scouts);
    fine = fine && all.found && all.scouts && (scout(&all, plan->emitters) || atomic_load(stop));
    release(&all);
    free(asked);
    return fine ? FATHOM_OK : fail_memory(context, (size_t)squares * LANES * sizeof(sky_ray));
}
