/* The schedule to an error: renders each wave until its estimated error is small enough (adaptive.h). */
#include "job/job_inner.h"

#include "base/clock.h"

#include <stdlib.h>

/* Records a long-running wave between two passes, so that a checkpoint loses little of its work. */
static void keep_wave(checkpoint *saving, worker *self, uint32_t wave) {
    double now = saving ? clock_seconds() : 0;
    if (!saving || now - self->kept < checkpoint_keep_seconds(saving)) return;
    checkpoint_keep(saving, wave, self->adaptive);
    self->kept = now;
}

/* Makes one pass of each run in turn, so that each can copy the other's samples. ADAPTIVE_FINISHED: neither
 * has more to do. */
static adaptive_result pass_both(job *j, worker *self, const adaptive_goal *goal) {
    adaptive_result all = ADAPTIVE_FINISHED;
    for (uint32_t run = 0; run < ADAPTIVE_RUNS; ++run) {
        const ray_counts before = self->integration->rays;
        const adaptive_result one = adaptive_pass(self->integration, goal, NULL, self->adaptive, run);
        job_count_rays(j, self->integration, &before);
        if (one == ADAPTIVE_STOPPED) return one;
        if (one == ADAPTIVE_PASSED) all = one;
    }
    return all;
}

/* Always renders the whole wave, because its squares decide together. */
static bool render(job *j, worker *self, const wave_region *region, uint64_t squares) {
    const adaptive_goal goal = adaptive_goal_of(j->plan->settings.target_error);
    checkpoint *saving = j->options->saving;
    const uint32_t wave = saving ? checkpoint_wave(saving, region->left, region->top) : 0;
    adaptive_result result;
    (void)squares;
    adaptive_begin(j->plan, region->left, region->top, self->adaptive);
    if (saving) checkpoint_resume(saving, wave, self->adaptive);
    self->kept = saving ? clock_seconds() : 0;
    do {
        result = pass_both(j, self, &goal);
        if (result == ADAPTIVE_PASSED) keep_wave(saving, self, wave);
        if (result == ADAPTIVE_PASSED && j->options->live) job_show(j, self, self->adaptive);
    } while (result == ADAPTIVE_PASSED);
    if (result != ADAPTIVE_FINISHED) return false;
    const unit_result done = adaptive_unit(self->adaptive, j->film, self->view);
    job_deliver(j, self, &done);
    return true;
}

static bool prepare(const job *j, worker *self) {
    self->adaptive = calloc(1, sizeof *self->adaptive);
    self->view = adaptive_view_create(j->plan);
    return self->view && self->adaptive && adaptive_create(j->plan, self->adaptive);
}

static void run(job *j) { job_run_tiles(j, render); }

const job_schedule schedule_to_error = {prepare, run};
