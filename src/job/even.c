/* The same samples for every pixel. */
#include "job/job_inner.h"

#include <stdlib.h>

typedef struct even {
    job *job;
    worker *self;
    const wave_region *region;
    uint32_t samples[WAVE_SQUARES];
    wave_batch batch;
} even;

/* Squares whose last sample was in the batch are done. */
static void deliver_finished(const even *e) {
    pixel_sums *sums = e->self->sums;
    const uint32_t groups = sums->groups;
    unit_result result = {.region = *e->region, .sums = sums, .samples = e->samples, .hits = e->samples};
    for (uint32_t place = 0; place < e->batch.count; ++place) {
        const wave_square *s = &e->batch.squares[place];
        if (s->index * groups + s->group + 1 < e->job->plan->settings.spp) continue;
        const uint32_t at = wave_slot(s->left - e->region->left, s->top - e->region->top) / LANES;
        result.squares |= 1ull << at;
    }
    if (result.squares) job_deliver(e->job, e->self, &result);
}

static bool run_batch(even *e) {
    integration *work = e->self->integration;
    const ray_counts before = work->rays;
    if (!e->job->plan->integrator->run(work, e->region, &e->batch)) return false;
    for (uint32_t place = 0; place < e->batch.count; ++place)
        pixel_sums_add(e->self->sums, &work->samples, e->region, &e->batch, place);
    deliver_finished(e);
    job_count_rays(e->job, work, &before);
    e->batch.count = 0;
    return true;
}

/* All samples of as many squares as a batch holds follow each other: in heavy meshes they meet the same boxes
 * and triangles, while the processor's caches hold those. */
static bool take_samples(even *e, const wave_square *squares, uint32_t count) {
    uint32_t spp = e->job->plan->settings.spp, together = spp < WAVE_SQUARES ? WAVE_SQUARES / spp : 1;
    for (uint32_t first = 0; first < count; first += together) {
        uint32_t end = first + together < count ? first + together : count;
        for (uint32_t index = 0; index < spp; ++index) {
            for (uint32_t i = first; i < end; ++i) {
                e->batch.squares[e->batch.count++] =
                    wave_square_sample(squares[i], index, e->self->sums->groups);
                if (e->batch.count == WAVE_SQUARES && !run_batch(e)) return false;
            }
        }
    }
    return !e->batch.count || run_batch(e);
}

static bool render(job *j, worker *self, const wave_region *r) {
    const checkpoint *saving = j->options->saving;
    even e = {.job = j, .self = self, .region = r};
    wave_square squares[WAVE_SQUARES];
    uint64_t left = wave_region_bits(r);
    if (saving) left &= ~checkpoint_finished(saving, checkpoint_wave(saving, r->left, r->top));
    for (uint32_t s = 0; s < WAVE_SQUARES; ++s) e.samples[s] = j->plan->settings.spp;
    pixel_sums_clear(self->sums);
    return take_samples(&e, squares, wave_list_squares(r, left, squares));
}

static bool prepare(const job *j, worker *self) {
    self->sums = malloc(sizeof *self->sums);
    return self->sums && pixel_sums_create(&j->plan->sampler, unit_groups(&j->plan->settings),
                                           j->plan->first_hits, self->sums);
}

static void run(job *j) { job_run_tiles(j, render); }

const job_schedule schedule_even = {prepare, run};
