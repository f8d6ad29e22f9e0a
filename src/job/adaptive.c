#include "job/adaptive.h"

#include "base/clock.h"

#include <stdlib.h>
#include <string.h>

/* Added to the error of each pixel: pixels are stored as float, so smaller errors are not significant. It
 * also keeps every estimate above zero. */
static const double rounding = 0x1p-48;

bool adaptive_create(const render_plan *plan, adaptive_wave *out) {
    out->sampler = plan->sampler;
    out->kernels = film_kernels_best();
    out->parts = plan->parts;
    out->hits = plan->parts.hits ? malloc(sizeof *out->hits) : NULL;
    const size_t layers = adaptive_layer_count(plan->parts);
    out->layers = layers ? malloc(layers * sizeof *out->layers) : NULL;
    const uint32_t mattes = plan->parts.matte_count;
    out->mattes = mattes ? malloc(mattes * sizeof *out->mattes) : NULL;
    if ((out->hits || !plan->parts.hits) && (out->layers || !layers) && (out->mattes || !mattes)) return true;
    adaptive_destroy(out);
    return false;
}

void adaptive_destroy(adaptive_wave *a) {
    free(a->hits);
    free(a->layers);
    free(a->mattes);
    a->hits = NULL, a->layers = NULL, a->mattes = NULL;
}

size_t adaptive_bytes(film_parts parts) {
    return adaptive_layer_count(parts) * WAVE_SLOTS * sizeof(double) + (parts.hits ? sizeof(hit_sums) : 0) +
           parts.matte_count * WAVE_SLOTS * sizeof(matte_list);
}

adaptive_view *adaptive_view_create(const render_plan *plan) {
    adaptive_view *view = malloc(sizeof *view);
    film_parts parts = plan->parts;
    parts.hits = false, parts.matte_count = 0;
    if (view && pixel_sums_create(&plan->sampler, SAMPLE_GROUPS, parts, &view->sums)) return view;
    free(view);
    return NULL;
}

void adaptive_view_destroy(adaptive_view *view) {
    if (!view) return;
    view->sums.hits = NULL, view->sums.mattes = NULL; /* owned by the wave */
    pixel_sums_destroy(&view->sums);
    free(view);
}

void adaptive_begin(const render_plan *plan, uint32_t left, uint32_t top, adaptive_wave *a) {
    a->region = (wave_region){left,
                              top,
                              min_u32(left + WAVE_SIDE, plan->settings.width),
                              min_u32(top + WAVE_SIDE, plan->settings.height),
                              left,
                              top};
    memset(a->runs, 0, sizeof a->runs);
    memset(a->seen, 0, sizeof a->seen);
    if (a->hits) hit_sums_clear(a->hits);
    if (a->mattes) memset(a->mattes, 0, a->parts.matte_count * sizeof *a->mattes);
    if (a->layers) memset(a->layers, 0, adaptive_layer_count(a->parts) * sizeof *a->layers);
    for (uint32_t r = 0; r < ADAPTIVE_RUNS; ++r) {
        for (uint32_t s = 0; s < WAVE_SQUARES; ++s) a->runs[r].square_error[s] = INFINITY;
        a->runs[r].error = a->runs[r].priority = INFINITY;
    }
}

/* ---- squares ---- */

/* The pixels of the square inside the image, as bits. */
static uint32_t square_pixels(const adaptive_wave *a, uint32_t s) {
    const wave_square square = wave_square_at(&a->region, s);
    return wave_square_pixels(&a->region, &square);
}

/* ---- errors ---- */

/* Adds one channel: the variance of each lane's mean, estimated from the groups p and q, and the channel's
 * contribution to the grey. */
static void add_channel(const double *restrict p, const double *restrict q, double n, double variance[LANES],
                        double grey[LANES]) {
    for (int k = 0; k < LANES; ++k) {
        const double d = (p[k] - q[k]) / n;
        variance[k] += d * d / 8;
        grey[k] += (p[k] + q[k]) / (6 * n);
    }
}

static double square_error(const adaptive_wave *a, uint32_t run, uint32_t s) {
    const adaptive_run *r = &a->runs[run];
    double variance[LANES] = {0}, grey[LANES] = {0}, sum = 0;
    if (r->done[s] < SAMPLE_GROUPS) return INFINITY;
    for (int c = 0; c < 3; ++c) {
        add_channel(r->rgb[run][c] + s * LANES, r->rgb[run + 2][c] + s * LANES,
                    r->done[s] / (double)SAMPLE_GROUPS, variance, grey);
    }
    for (uint32_t left = square_pixels(a, s); left; left &= left - 1) {
        int k = __builtin_ctz(left);
        sum += variance[k] / 3 * film_error_weight(grey[k]) + rounding;
    }
    return sum;
}

static double mean_error(const adaptive_wave *a, double sum) {
    return sqrt(sum / ((a->region.x1 - a->region.x0) * (a->region.y1 - a->region.y0)));
}

static double run_error(const adaptive_wave *a, const adaptive_run *r) {
    double sum = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) sum += square_pixels(a, s) ? r->square_error[s] : 0;
    return mean_error(a, sum);
}

/* Both halves cost about the same number of rays. Only the deciding half's own rays may be used. */
static double square_priority(const adaptive_run *r, uint32_t run, uint32_t s) {
    return r->square_error[s] / (2.0 * (double)r->rays[run][s]);
}

/* ---- which squares ---- */

adaptive_goal adaptive_goal_of(double target) {
    const double aim = ADAPTIVE_AIM * target;
    return (adaptive_goal){aim, aim * aim / ADAPTIVE_USUAL_RAYS};
}

static uint32_t least_samples(const fathom_settings *settings) {
    return settings->min_spp ? settings->min_spp : ADAPTIVE_MIN_SPP;
}

/* Chooses squares for a run of a wave. */
typedef struct chooser {
    const fathom_settings *settings;
    const adaptive_wave *a;
    const adaptive_run *r;
    uint32_t run;
} chooser;

static bool may_grow(const chooser *c, uint32_t s) {
    return square_pixels(c->a, s) && c->r->done[s] < c->settings->spp;
}

static bool is_young(const chooser *c) { return c->r->done[0] < least_samples(c->settings); }

static double best_priority(const chooser *c) {
    double best = 0;
    if (is_young(c)) return INFINITY;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        if (may_grow(c, s)) best = fmax(best, square_priority(c->r, c->run, s));
    }
    return best;
}

/* Chooses the squares of at least this priority. Returns the maximum number of samples of a chosen square
 * after doubling; 0: none was chosen. A priority of NaN counts as high. */
static uint32_t choose_above(const chooser *c, double priority, bool chosen[WAVE_SQUARES]) {
    uint32_t most = 0;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        chosen[s] = may_grow(c, s) && !(square_priority(c->r, c->run, s) < priority);
        if (chosen[s]) most = max_u32(most, 2 * c->r->done[s]);
    }
    return most;
}

static void choose_laggards(const chooser *c, uint32_t most, bool chosen[WAVE_SQUARES]) {
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        if (may_grow(c, s) && ADAPTIVE_SPREAD * c->r->done[s] < most) chosen[s] = true;
    }
}

static void choose(const chooser *c, const adaptive_goal *goal, bool chosen[WAVE_SQUARES]) {
    if (is_young(c)) {
        for (uint32_t s = 0; s < WAVE_SQUARES; ++s) chosen[s] = square_pixels(c->a, s);
        return;
    }
    uint32_t most = choose_above(c, goal->priority, chosen);
    if (!most && !(c->r->error <= goal->error))
        most = choose_above(c, ADAPTIVE_NEAR_BEST * c->r->priority, chosen);
    if (most) choose_laggards(c, most, chosen);
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
    adaptive_run *r;
    uint32_t run; /* index of `r` */
    adaptive_limit *limit;
    wave_batch batch;
    uint8_t square[WAVE_SQUARES]; /* index in the wave, by place in the batch */
    uint32_t rays[WAVE_SQUARES];  /* by place in the batch */
} pass;

static uint32_t doubled(uint32_t done) { return done ? 2 * done : 1; }

static void copy_layers(const pass *p, uint32_t s) {
    for (uint32_t g = 0; g < SAMPLE_GROUPS; ++g) {
        double(*from)[WAVE_SLOTS] = adaptive_layers(p->a, 1 - p->run, g),
        (*to)[WAVE_SLOTS] = adaptive_layers(p->a, p->run, g);
        for (uint32_t k = 0; k < 3 * film_part_sums(p->a->parts); ++k)
            memcpy(to[k] + s * LANES, from[k] + s * LANES, LANES * sizeof(double));
    }
}

/* A copy is exact: sums in the same order of samples have the same bits. */
static void copy_square(const pass *p, uint32_t s) {
    const adaptive_run *from = &p->a->runs[1 - p->run];
    adaptive_run *to = p->r;
    if (p->a->layers) copy_layers(p, s);
    for (uint32_t g = 0; g < SAMPLE_GROUPS; ++g) {
        for (int c = 0; c < 3; ++c)
            memcpy(to->rgb[g][c] + s * LANES, from->rgb[g][c] + s * LANES, LANES * sizeof(double));
    }
    for (int half = 0; half < 2; ++half) to->rays[half][s] = from->rays[half][s];
    to->taken[s] = from->taken[s];
}

/* Moves the squares that are left to sample to the front, and returns their number. */
static uint32_t copy_squares(const pass *p, uint8_t *squares, uint32_t count) {
    const adaptive_run *other = &p->a->runs[1 - p->run];
    uint32_t left = 0;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t s = squares[i];
        if (other->done[s] == doubled(p->r->done[s]))
            copy_square(p, s);
        else
            squares[left++] = (uint8_t)s;
    }
    return left;
}

/* Adds first hits and mattes only once if both runs take the same samples. */
static void add_square(pass *p, uint32_t place) {
    adaptive_wave *a = p->a;
    adaptive_run *r = p->r;
    const uint32_t s = p->square[place], group = p->batch.squares[place].group;
    for (int c = 0; c < 3; ++c) {
        a->kernels->add_samples(p->work->samples.radiance[c] + place * LANES, r->rgb[group][c] + s * LANES);
    }
    double(*layers)[WAVE_SLOTS] = adaptive_layers(a, p->run, group);
    for (uint32_t k = 0; k < 3 * a->parts.layers; ++k) {
        a->kernels->add_samples(p->work->samples.layers[k] + place * LANES, layers[k] + s * LANES);
    }
    if (a->parts.cascades)
        fireflies_add(&p->work->samples, place * LANES, a->parts.octave, layers + 3 * a->parts.layers,
                      s * LANES);
    r->rays[group % 2][s] += p->rays[place];
    if (r->taken[s]++ < a->seen[s]) return;
    ++a->seen[s];
    if (a->mattes) matte_sums_add(a->mattes, &p->work->samples, a->parts, &a->region, &p->batch, place);
    if (a->hits) hit_sums_add(a->hits, &a->sampler, p->work->samples.first, &a->region, &p->batch, place);
}

/* Allows 1.5 times the duration of the last batch: batches of one wave differ by the paths they follow. */
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

static adaptive_result add_to_batch(pass *p, uint32_t s, uint32_t n) {
    uint32_t place = p->batch.count++;
    p->batch.squares[place] = wave_square_sample(wave_square_at(&p->a->region, s), n, SAMPLE_GROUPS);
    p->square[place] = (uint8_t)s;
    return p->batch.count == WAVE_SQUARES ? run_batch(p) : ADAPTIVE_PASSED;
}

/* Takes one sample of each square in turn. So samples of one square stay in order, and after a cut all
 * squares have got about the same number of samples. */
static adaptive_result take_samples(pass *p, const uint8_t *squares, uint32_t count) {
    adaptive_result result = ADAPTIVE_PASSED;
    uint32_t most = 0;
    for (uint32_t i = 0; i < count; ++i) most = max_u32(most, max_u32(p->r->done[squares[i]], 1));
    for (uint32_t k = 0; k < most; ++k) {
        for (uint32_t i = 0; i < count && result == ADAPTIVE_PASSED; ++i) {
            uint32_t done = p->r->done[squares[i]];
            if (k < max_u32(done, 1)) result = add_to_batch(p, squares[i], done + k);
        }
    }
    return result == ADAPTIVE_PASSED && p->batch.count ? run_batch(p) : result;
}

static void rate(const fathom_settings *settings, adaptive_wave *a, uint32_t run) {
    adaptive_run *r = &a->runs[run];
    r->error = run_error(a, r);
    r->priority = best_priority(&(chooser){settings, a, r, run});
}

void adaptive_rate(const fathom_settings *settings, adaptive_wave *a) {
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run) rate(settings, a, run);
}

adaptive_result adaptive_pass(integration *work, const adaptive_goal *goal, adaptive_limit *limit,
                              adaptive_wave *a, uint32_t run) {
    bool chosen[WAVE_SQUARES];
    uint8_t squares[WAVE_SQUARES], all[WAVE_SQUARES];
    adaptive_run *r = &a->runs[run];
    const chooser c = {&work->plan->settings, a, r, run};
    choose(&c, goal, chosen);
    const uint32_t count = list_chosen(chosen, all);
    if (!count) return ADAPTIVE_FINISHED;
    memcpy(squares, all, sizeof squares);
    pass p = {.work = work, .a = a, .r = r, .run = run, .limit = limit};
    work->square_rays = p.rays;
    adaptive_result result = take_samples(&p, squares, copy_squares(&p, squares, count));
    work->square_rays = NULL;
    if (result != ADAPTIVE_PASSED) return result;
    for (uint32_t i = 0; i < count; ++i) {
        const uint32_t s = all[i];
        r->done[s] = r->taken[s];
        r->square_error[s] = square_error(a, run, s);
    }
    rate(c.settings, a, run);
    return ADAPTIVE_PASSED;
}

/* ---- the image ---- */

static void show_layers(const adaptive_wave *a, uint32_t run, uint32_t group, uint32_t s, double scale,
                        const adaptive_view *v) {
    double(*from)[WAVE_SLOTS] = adaptive_layers(a, run, group);
    for (uint32_t i = 0; i < 3 * film_part_sums(a->parts); ++i) {
        double *to = v->sums.layers[i] + s * LANES;
        for (int k = 0; k < LANES; ++k)
            to[k] = (group ? to[k] : 0) + from[i][s * LANES + (uint32_t)k] * scale;
    }
}

/* Stores the groups of the image's two means, scaled as if all had the same number of samples: then the mean
 * of the groups is the mean of both means. A group comes from the run that the other half decides. */
static void show_means(const adaptive_wave *a, uint32_t s, adaptive_view *v) {
    uint32_t counts[SAMPLE_GROUPS], samples = 0;
    for (uint32_t g = 0; g < SAMPLE_GROUPS; ++g) {
        counts[g] = wave_group_count(a->runs[1 - g % 2].taken[s], g, SAMPLE_GROUPS);
        samples += counts[g];
    }
    v->samples[s] = samples;
    for (uint32_t g = 0; g < SAMPLE_GROUPS; ++g) {
        const double scale = samples / (double)(SAMPLE_GROUPS * counts[g]);
        for (int c = 0; c < 3; ++c) {
            const double *from = a->runs[1 - g % 2].rgb[g][c] + s * LANES;
            for (int k = 0; k < LANES; ++k) v->sums.rgb[g][c][s * LANES + (uint32_t)k] = from[k] * scale;
        }
        show_layers(a, 1 - g % 2, g, s, scale, v);
    }
}

/* Shows all samples of a run: nothing was decided before every group has a sample. */
static void show_few(const adaptive_wave *a, uint32_t run, uint32_t s, adaptive_view *v) {
    const adaptive_run *r = &a->runs[run];
    v->samples[s] = r->taken[s];
    for (uint32_t g = 0; g < SAMPLE_GROUPS; ++g) {
        for (int c = 0; c < 3; ++c)
            memcpy(v->sums.rgb[g][c] + s * LANES, r->rgb[g][c] + s * LANES, LANES * sizeof(double));
        show_layers(a, run, g, s, 1, v);
    }
}

static double image_error(const adaptive_wave *a, const adaptive_view *v, uint32_t s) {
    double sum = 0, squared[3];
    if (v->samples[s] < SAMPLE_GROUPS) return square_pixels(a, s) ? (double)INFINITY : 0;
    for (uint32_t left = square_pixels(a, s); left; left &= left - 1) {
        const uint32_t slot = s * LANES + (uint32_t)__builtin_ctz(left);
        const double weight = film_error_weight(pixel_sums_error(&v->sums, slot, v->samples[s], squared));
        sum += (squared[0] + squared[1] + squared[2]) / 3 * weight + rounding;
    }
    return sum;
}

unit_result adaptive_unit(const adaptive_wave *a, const fathom_film *film, adaptive_view *view) {
    const wave_region *r = &a->region;
    double sum = 0;
    view->sums.equal = true, view->sums.hits = a->hits, view->sums.mattes = a->mattes;
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) {
        if (min_u32(a->runs[0].taken[s], a->runs[1].taken[s]) < SAMPLE_GROUPS)
            show_few(a, a->runs[1].taken[s] > a->runs[0].taken[s], s, view);
        else
            show_means(a, s, view);
        sum += image_error(a, view, s);
    }
    return (unit_result){.region = {max_u32(r->x0, film->x), max_u32(r->y0, film->y),
                                    min_u32(r->x1, film->x + film->width),
                                    min_u32(r->y1, film->y + film->height), r->left, r->top},
                         .squares = ~0ull,
                         .sums = &view->sums,
                         .samples = view->samples,
                         .hits = a->seen,
                         .error = mean_error(a, sum)};
}
