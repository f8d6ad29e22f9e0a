/* The schedule with the same number of samples for every pixel. */
#include "job/job_inner.h"

#include <stdlib.h>

typedef struct even {
    job *job;
    worker *self;
    const wave_region *region;
    sum_range range; /* samples of each pixel */
    uint32_t samples[WAVE_SQUARES];
    wave_batch batch;
    uint8_t stack[WAVE_SQUARES]; /* stack of the square at each place of the batch */
    sum_stack stacks[WAVE_SQUARES];
} even;

static sum_range range_of(const job *j) {
    const wave_share *share = j->options->share;
    return share && share->sums ? share->range : (sum_range){0, j->plan->settings.spp};
}

/* The number of squares that are sampled together. */
static uint32_t squares_together(sum_range range) { return unit_least_squares(range.end - range.begin); }

static uint32_t square_slot(const even *e, uint32_t place) {
    const wave_square *s = &e->batch.squares[place];
    return wave_slot(s->left - e->region->left, s->top - e->region->top) / LANES;
}

static void keep_share(const even *e, const sum_stack *stack) {
    worker *self = e->self;
    const uint32_t groups = self->sums->groups;
    const film_parts parts = self->sums->parts;
    for (uint32_t i = 0; i < stack->count; ++i) {
        sum_save(&stack->nodes[i].sums, groups, parts, self->share + self->share_bytes);
        self->share_bytes += sum_bytes(groups, parts);
    }
}

/* Stores the sum of all samples, or the nodes if the job is a share of all samples. */
static void finish_square(const even *e, uint32_t place) {
    pixel_sums *sums = e->self->sums;
    sum_stack *stack = (sum_stack *)&e->stacks[e->stack[place]];
    if (e->self->share) {
        keep_share(e, stack);
    } else {
        sum_fold(sums, stack);
        sum_give(&stack->nodes[0].sums, square_slot(e, place), sums);
    }
    stack->count = 0;
}

/* Returns true if the sample at this place was the square's last. */
static bool add_sample(even *e, uint32_t place) {
    const wave_square *s = &e->batch.squares[place];
    pixel_sums *sums = e->self->sums;
    const uint32_t n = s->index * sums->groups + s->group;
    const bool last = n + 1 == e->range.end;
    pixel_sums_add(sums, &e->self->integration->samples, e->region, &e->batch, place);
    if (!e->self->nodes || (!last && (n + 1) % SUM_LEAF)) return last;
    sum_stack *stack = &e->stacks[e->stack[place]];
    sum_node *leaf = &stack->nodes[stack->count];
    leaf->first = n / SUM_LEAF, leaf->level = 0;
    sum_take(sums, square_slot(e, place), &leaf->sums);
    sum_push(sums, stack);
    if (last) finish_square(e, place);
    return last;
}

/* Delivers the squares whose last sample was in the batch. */
static void deliver_finished(const even *e, uint64_t squares) {
    pixel_sums *sums = e->self->sums;
    const unit_result result = {
        .region = *e->region, .squares = squares, .sums = sums, .samples = e->samples, .hits = e->samples};
    job_deliver(e->job, e->self, &result);
}

static bool run_batch(even *e) {
    integration *work = e->self->integration;
    const ray_counts before = work->rays;
    uint64_t finished = 0;
    if (!e->job->plan->integrator->run(work, e->region, &e->batch)) return false;
    for (uint32_t place = 0; place < e->batch.count; ++place)
        finished |= (uint64_t)add_sample(e, place) << square_slot(e, place);
    if (finished) deliver_finished(e, finished);
    job_count_rays(e->job, work, &before);
    e->batch.count = 0;
    return true;
}

/* Takes all samples of one group of squares before the next group, with enough squares to fill a batch. In
 * heavy meshes their rays traverse the same nodes and triangles while these are in the processor's caches. */
static bool take_samples(even *e, const wave_square *squares, uint32_t count) {
    const uint32_t together = squares_together(e->range);
    for (uint32_t first = 0; first < count; first += together) {
        uint32_t end = first + together < count ? first + together : count;
        for (uint32_t index = e->range.begin; index < e->range.end; ++index) {
            for (uint32_t i = first; i < end; ++i) {
                e->stack[e->batch.count] = (uint8_t)(i - first);
                e->batch.squares[e->batch.count++] =
                    wave_square_sample(squares[i], index, e->self->sums->groups);
                if (e->batch.count == WAVE_SQUARES && !run_batch(e)) return false;
            }
        }
    }
    return !e->batch.count || run_batch(e);
}

static bool render(job *j, worker *self, const wave_region *r, uint64_t remaining) {
    even e = {.job = j, .self = self, .region = r, .range = range_of(j)};
    wave_square squares[WAVE_SQUARES];
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) e.samples[s] = e.range.end - e.range.begin;
    for (uint32_t i = 0; self->nodes && i < squares_together(e.range); ++i)
        e.stacks[i].nodes = self->nodes + i * sum_stack_depth(e.range);
    self->share_bytes = 0;
    pixel_sums_clear(self->sums);
    return take_samples(&e, squares, wave_list_squares(r, remaining, squares));
}

/* A single leaf is summed in place and needs no nodes. */
static bool prepare_nodes(const job *j, worker *self) {
    const sum_range range = range_of(j);
    const bool sums = j->options->share && j->options->share->sums;
    if (!sums && sum_leaves(range.end) == 1) return true;
    self->nodes =
        sum_nodes_create(self->sums->parts, (size_t)squares_together(range) * sum_stack_depth(range));
    if (sums) {
        self->share = malloc(WAVE_SQUARES * sum_list_nodes(range, NULL) *
                             sum_bytes(self->sums->groups, self->sums->parts));
    }
    return self->nodes && (self->share || !sums);
}

static bool prepare(const job *j, worker *self) {
    self->sums = malloc(sizeof *self->sums);
    return self->sums &&
           pixel_sums_create(&j->plan->sampler, unit_groups(&j->plan->settings), j->plan->parts,
                             self->sums) &&
           prepare_nodes(j, self);
}

static void run(job *j) { job_run_tiles(j, render); }

const job_schedule schedule_even = {prepare, run};
