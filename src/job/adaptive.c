#include "job/adaptive.h"

#include "base/clock.h"

#include <string.h>

/* A pixel is stored as float: nothing below its rounding is promised, and no estimate is zero. */
static const double rounding = 0x1p-48;

bool adaptive_create(const render_plan *plan, adaptive_wave *out) {
    return pixel_sums_create(&plan->sampler, plan->first_hits, &out->sums);
}

void adaptive_destroy(adaptive_wave *a) { pixel_sums_destroy(&a->sums); }

void adaptive_begin(const render_plan *plan, uint32_t left, uint32_t top, adaptive_wave *a) {
    a->region = (wave_region){left,
                              top,
                              min_u32(left + WAVE_SIDE, plan->settings.width),
                              min_u32(top + WAVE_SIDE, plan->settings.height),
                              left,
                              top};
    pixel_sums_clear(&a->sums);
    memset(a->done, 0, sizeof a->done);
    memset(a->taken, 0, sizeof a->taken);
    memset(a->rays, 0, sizeof a->rays);
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) a->square_error[s] = INFINITY;
    a->error = a->priority = INFINITY;
}

/* ---- squares ---- */

/* The square's pixels inside the image, as bits. */
static uint32_t square_pixels(const adaptive_wave *a, uint32_t s) {
    const wave_square square = wave_square_at(&a->region, s, 0);
    return wave_square_pixels(&a->region, &square);
}

/* ---- errors ---- */

static double weight_of(double grey) {
    double norm = grey < 1 ? fmax(grey, 0.01) : grey * grey;
    return 1 / norm;
}

/* Adds one channel: the variance of each lane's mean, and its share of the grey. */
static void add_channel(const adaptive_wave *a, int c, uint32_t first, double scale, double variance[LANES],
                        double grey[LANES]) {
    const double *restrict p0 = a->parts[0][c] + first, *restrict p1 = a->parts[1][c] + first;
    const double *restrict p2 = a->parts[2][c] + first, *restrict sum = a->sums.rgb[c] + first;
    const double quarter = 4 * scale;
    for (int k = 0; k < LANES; ++k) {
        double mean = sum[k] * scale;
        double d0 = p0[k] * quarter - mean, d1 = (p1[k] - p0[k]) * quarter - mean;
        double d2 = (p2[k] - p1[k]) * quarter - mean, d3 = (sum[k] - p2[k]) * quarter - mean;
        variance[k] += (d0 * d0 + d1 * d1 + d2 * d2 + d3 * d3) / 12;
        grey[k] += mean / 3;
    }
}

static double square_error(const adaptive_wave *a, uint32_t s) {
    double variance[LANES] = {0}, grey[LANES] = {0}, sum = 0;
    if (a->done[s] < 4) return INFINITY;
    for (int c = 0; c < 3; ++c) add_channel(a, c, s * LANES, 1.0 / a->done[s], variance, grey);
    for (uint32_t left = square_pixels(a, s); left; left &= left - 1) {
        int k = __builtin_ctz(left);
        sum += variance[k] / 3 * weight_of(grey[k]) + rounding;
    }
    return sum;
}

static double wave_error(const adaptive_wave *a) {
    double sum = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) sum += square_pixels(a, s) ? a->square_error[s] : 0;
    return sqrt(sum / ((a->region.x1 - a->region.x0) * (a->region.y1 - a->region.y0)));
}

static double square_priority(const adaptive_wave *a, uint32_t s) {
    return a->square_error[s] / (double)a->rays[s];
}

/* ---- which squares ---- */

adaptive_goal adaptive_goal_of(double target) {
    return (adaptive_goal){target, target * target / ADAPTIVE_USUAL_RAYS};
}

static uint32_t least_samples(const fathom_settings *settings) {
    return settings->min_spp ? settings->min_spp : ADAPTIVE_MIN_SPP;
}

static bool may_grow(const adaptive_wave *a, const fathom_settings *settings, uint32_t s) {
    return square_pixels(a, s) && a->done[s] < settings->spp;
}

static double best_priority(const adaptive_wave *a, const fathom_settings *settings) {
    double best = 0;
    if (a->done[0] < least_samples(settings)) return INFINITY;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        if (may_grow(a, settings, s)) best = fmax(best, square_priority(a, s));
    }
    return best;
}

/* Chooses the squares above this priority. Returns the most samples that a square has once theirs are
 * doubled; 0: there are none. A priority that is no number is not small. */
static uint32_t choose_above(const adaptive_wave *a, const fathom_settings *settings, double priority,
                             bool chosen[WAVE_SQUARES]) {
    uint32_t most = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        chosen[s] = may_grow(a, settings, s) && !(square_priority(a, s) < priority);
        if (chosen[s]) most = max_u32(most, 2 * a->done[s]);
    }
    return most;
}

static void choose_laggards(const adaptive_wave *a, const fathom_settings *settings, uint32_t most,
                            bool chosen[WAVE_SQUARES]) {
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        if (may_grow(a, settings, s) && ADAPTIVE_SPREAD * a->done[s] < most) chosen[s] = true;
    }
}

static void choose(const adaptive_wave *a, const fathom_settings *settings, const adaptive_goal *goal,
                   bool chosen[WAVE_SQUARES]) {
    if (a->done[0] < least_samples(settings)) {
        for (uint32_t s = 0; s < WAVE_SQUARES; ++s) chosen[s] = square_pixels(a, s);
        return;
    }
    uint32_t most = choose_above(a, settings, goal->priority, chosen);
    if (!most && !(a->error <= goal->error))
        most = choose_above(a, settings, ADAPTIVE_NEAR_BEST * a->priority, chosen);
    if (most) choose_laggards(a, settings, most, chosen);
}

static uint32_t list_chosen(const bool chosen[WAVE_SQUARES], uint8_t out[WAVE_SQUARES]) {
    uint32_t count = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        if (chosen[s]) out[count++] = (uint8_t)s;
    }
    return count;
}

/* ---- a pass ---- */

typedef struct pass {
    integration *work;
    adaptive_wave *a;
    adaptive_limit *limit;
    wave_batch batch;
    uint8_t square[WAVE_SQUARES]; /* of the wave, by place in the batch */
    uint32_t rays[WAVE_SQUARES];  /* by place in the batch */
} pass;

static void copy_sums(adaptive_wave *a, int part, uint32_t s) {
    for (int c = 0; c < 3; ++c)
        memcpy(a->parts[part][c] + s * LANES, a->sums.rgb[c] + s * LANES, LANES * sizeof(double));
}

/* Half and whole of what there was become a quarter and half. What a cut pass had left half done is
 * forgotten with its wave: nothing follows a cut. */
static void begin_square(adaptive_wave *a, uint32_t s) {
    for (int c = 0; c < 3; ++c)
        memcpy(a->parts[0][c] + s * LANES, a->parts[1][c] + s * LANES, LANES * sizeof(double));
    copy_sums(a, 1, s);
}

static void add_square(pass *p, uint32_t place) {
    adaptive_wave *a = p->a;
    uint32_t s = p->square[place];
    if (p->batch.squares[place].index == a->done[s] + a->done[s] / 2) copy_sums(a, 2, s);
    pixel_sums_add(&a->sums, &p->work->samples, &a->region, &p->batch, place);
    a->rays[s] += p->rays[place];
    ++a->taken[s];
}

/* Half of a batch's time more than the last one took: batches of one wave differ by the paths they follow. */
static bool in_time(const adaptive_limit *limit) {
    return !limit || clock_seconds() + 1.5 * limit->batch_seconds < limit->deadline;
}

static adaptive_result run_batch(pass *p) {
    if (!in_time(p->limit)) return ADAPTIVE_CUT;
    double began = p->limit ? clock_seconds() : 0;
    if (!p->work->plan->integrator->run(p->work, &p->a->region, &p->batch)) return ADAPTIVE_STOPPED;
    for (uint32_t place = 0; place < p->batch.count; ++place) add_square(p, place);
    p->batch.count = 0;
    if (p->limit) p->limit->batch_seconds = clock_seconds() - began;
    return ADAPTIVE_PASSED;
}

static adaptive_result add_to_batch(pass *p, uint32_t s, uint32_t index) {
    uint32_t place = p->batch.count++;
    p->batch.squares[place] = wave_square_at(&p->a->region, s, index);
    p->square[place] = (uint8_t)s;
    return p->batch.count == WAVE_SQUARES ? run_batch(p) : ADAPTIVE_PASSED;
}

/* The next sample of each square, and so on: samples of one square stay in order, and a pass that is cut has
 * about as many in each. */
static adaptive_result take_samples(pass *p, const uint8_t *squares, uint32_t count) {
    adaptive_result result = ADAPTIVE_PASSED;
    uint32_t most = 0;
    for (uint32_t i = 0; i < count; ++i) most = max_u32(most, max_u32(p->a->done[squares[i]], 1));
    for (uint32_t k = 0; k < most; ++k) {
        for (uint32_t i = 0; i < count && result == ADAPTIVE_PASSED; ++i) {
            uint32_t done = p->a->done[squares[i]];
            if (k < max_u32(done, 1)) result = add_to_batch(p, squares[i], done + k);
        }
    }
    return result == ADAPTIVE_PASSED && p->batch.count ? run_batch(p) : result;
}

void adaptive_rate(const fathom_settings *settings, adaptive_wave *a) {
    a->error = wave_error(a);
    a->priority = best_priority(a, settings);
}

adaptive_result adaptive_pass(integration *work, const adaptive_goal *goal, adaptive_limit *limit,
                              adaptive_wave *a) {
    bool chosen[WAVE_SQUARES];
    uint8_t squares[WAVE_SQUARES];
    const fathom_settings *settings = &work->plan->settings;
    choose(a, settings, goal, chosen);
    uint32_t count = list_chosen(chosen, squares);
    if (!count) return ADAPTIVE_FINISHED;
    pass p = {.work = work, .a = a, .limit = limit};
    for (uint32_t i = 0; i < count; ++i) begin_square(a, squares[i]);
    work->square_rays = p.rays;
    adaptive_result result = take_samples(&p, squares, count);
    work->square_rays = NULL;
    if (result != ADAPTIVE_PASSED) return result;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t s = squares[i];
        a->done[s] = a->taken[s];
        a->square_error[s] = square_error(a, s);
    }
    adaptive_rate(settings, a);
    return ADAPTIVE_PASSED;
}

unit_result adaptive_unit(const adaptive_wave *a, const fathom_film *film) {
    const wave_region *r = &a->region;
    return (unit_result){.region = {max_u32(r->x0, film->x), max_u32(r->y0, film->y),
                                    min_u32(r->x1, film->x + film->width),
                                    min_u32(r->y1, film->y + film->height), r->left, r->top},
                         .squares = ~0ull,
                         .sums = &a->sums,
                         .samples = a->taken,
                         .error = a->error};
}
