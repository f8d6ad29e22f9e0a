/* Rendering to a time. All waves stay in memory, and the threads make rounds over them. The first round takes
 * one sample of each pixel. The next ones double the samples until errors are known. Each later round makes a
 * pass over the squares with the highest priority in the whole image (adaptive.h): this gives the minimum
 * squared error for the time. The clock is read before each batch of rays, so no finished sample is lost. The
 * clock decides which samples are taken, but not their values.
 *
 * Rounds of run 0 and run 1 alternate, and each uses only the priorities of its own run. So the deciding half
 * of the whole image chooses the squares of a round, and the proof in adaptive.h holds for any fixed number
 * of rounds. The clock decides the number of rounds. */
#include "job/job_inner.h"

#include "base/clock.h"
#include "base/threads.h"

#include <stdlib.h>

/* Minimum number of waves in a round, per thread. At the end of a round, threads wait for the last one; this
 * keeps the wait a small fraction of the round. */
#define WAVES_FOR_THREAD 16u

typedef struct ranked {
    double priority;
    uint32_t shuffle, wave;
} ranked;

typedef struct timed {
    job *job;
    adaptive_wave **waves; /* NULL until the first pass */
    adaptive_view *view;
    bool *finished[ADAPTIVE_RUNS];
    ranked *order;
    uint32_t run;        /* run of this round */
    size_t count, round; /* number of waves; number in this round */
    double limit;        /* minimum priority of squares of this round; waves without any use their own */
    wave_grid grid;
    atomic_bool cut;
} timed;

size_t timed_bytes(const job *j) {
    const size_t count = film_waves(j->film).count;
    size_t kept = j->options->saving ? checkpoint_wave_bytes(j->options->saving) : 0;
    return count * (sizeof(adaptive_wave) + adaptive_bytes(j->plan->parts) + kept);
}

/* Highest priority first. Equal priorities are in shuffled order, because nothing is known yet. */
static int by_priority(const void *a, const void *b) {
    const ranked *x = a, *y = b;
    if (x->priority != y->priority) return x->priority > y->priority ? -1 : 1;
    return x->shuffle < y->shuffle ? -1 : x->shuffle > y->shuffle;
}

/* Puts the waves of the next round at the front of `order`. If some waves have no estimate, only those. */
static void choose_round(timed *t) {
    size_t count = 0;
    for (uint32_t i = 0; i < t->count; ++i) {
        if (t->finished[t->run][i]) continue;
        double priority = t->waves[i] ? t->waves[i]->runs[t->run].priority : (double)INFINITY;
        if (!(priority > 0)) continue; /* it has the maximum number of samples */
        t->order[count++] = (ranked){priority, i * 0x9e3779b1u, i};
    }
    qsort(t->order, count, sizeof *t->order, by_priority);
    size_t least = WAVES_FOR_THREAD * t->job->threads;
    t->limit = count ? ADAPTIVE_NEAR_BEST * t->order[0].priority : 0;
    bool unknown = isinf(t->limit);
    for (t->round = 0; t->round < count; ++t->round) {
        if (t->order[t->round].priority < t->limit && (unknown || t->round >= least)) break;
    }
}

static bool make_wave(timed *t, uint32_t i) {
    adaptive_wave *a = malloc(sizeof *a);
    if (!a || !adaptive_create(t->job->plan, a)) {
        free(a);
        return false;
    }
    const wave_region r = wave_grid_region(&t->grid, i);
    adaptive_begin(t->job->plan, r.left, r.top, a);
    if (t->job->options->saving) checkpoint_resume(t->job->options->saving, i, a);
    t->waves[i] = a;
    return true;
}

static void run_pass(timed *t, worker *self, uint32_t i) {
    job *j = t->job;
    if (!t->waves[i] && !make_wave(t, i)) {
        atomic_store(&j->failed, true);
        atomic_store(&j->stop, true);
        return;
    }
    adaptive_wave *a = t->waves[i];
    self->limit.deadline = atomic_load(&j->deadline);
    adaptive_goal goal = adaptive_goal_of(j->plan->settings.target_error);
    const double priority = a->runs[t->run].priority;
    goal.priority = fmax(goal.priority, priority < t->limit ? ADAPTIVE_NEAR_BEST * priority : t->limit);
    const ray_counts before = self->integration->rays;
    switch (adaptive_pass(self->integration, &goal, &self->limit, a, t->run)) {
    case ADAPTIVE_PASSED:
        if (j->options->saving) checkpoint_keep(j->options->saving, i, a);
        if (j->options->live) job_show(j, self, a);
        break;
    case ADAPTIVE_FINISHED: t->finished[t->run][i] = true; break;
    case ADAPTIVE_CUT: atomic_store(&t->cut, true); break;
    case ADAPTIVE_STOPPED: job_stop(j, self->integration); break;
    }
    job_count_rays(j, self->integration, &before);
}

static void run_round(void *user, size_t begin, size_t end, unsigned index) {
    timed *t = user;
    unsigned state = trace_thread_begin();
    for (size_t i = begin; i < end && !atomic_load(&t->cut); ++i) {
        worker *self = job_worker(t->job, index);
        if (!self) break;
        run_pass(t, self, t->order[i].wave);
    }
    trace_thread_end(state);
}

/* Stores the waves, and recounts their samples and errors. */
static void store_waves(timed *t) {
    const unit_sink film = unit_film_sink(t->job->film);
    job_result *result = &t->job->result;
    result->samples = 0, result->error = 0;
    for (size_t i = 0; i < t->count; ++i) {
        if (!t->waves[i]) continue;
        const unit_result unit = adaptive_unit(t->waves[i], t->job->film, t->view);
        film.take(film.user, &unit);
        result->samples += unit_samples(&unit);
        result->error = fmax(result->error, unit.error);
    }
}

/* Storing the waves also takes time after the deadline. */
static void reserve_time(timed *t) {
    job *j = t->job;
    const job_reserve *reserve = j->options->reserve;
    double began = clock_seconds();
    store_waves(t);
    double stored = clock_seconds(), deadline = atomic_load(&j->deadline);
    double after = reserve->seconds(reserve->user, j->film, deadline - stored);
    /* Stays above 0, which would mean no deadline. */
    atomic_store(&j->deadline, fmax(deadline - (stored - began) - after, j->began));
}

/* Loads the waves that earlier calls sampled. */
static bool take_up_waves(timed *t) {
    checkpoint *saving = t->job->options->saving;
    for (uint32_t i = 0; saving && i < t->count; ++i) {
        if (checkpoint_is_begun(saving, i) && !make_wave(t, i)) return false;
    }
    return true;
}

static bool all_begun(const timed *t) {
    for (size_t i = 0; i < t->count; ++i) {
        if (!t->waves[i]) return false;
    }
    return true;
}

static void run_rounds(timed *t) {
    unsigned idle = 0; /* rounds in a row with nothing to do */
    for (bool reserved = !t->job->options->reserve; idle < ADAPTIVE_RUNS; t->run = 1 - t->run) {
        choose_round(t);
        idle = t->round ? 0 : idle + 1;
        if (!reserved && all_begun(t)) {
            reserve_time(t);
            reserved = true;
        }
        loop_workers(t->job->threads, t->round, 1, run_round, t);
        if (atomic_load(&t->cut) || atomic_load(&t->job->stop)) return;
    }
}

static void tell_sampled(const timed *t) {
    size_t sampled = 0;
    for (size_t i = 0; i < t->count; ++i) sampled += t->waves[i] && t->waves[i]->runs[0].taken[0];
    t->job->sampled = (double)sampled / (double)t->count;
    if (sampled < t->count) t->job->result.error = INFINITY;
}

static void destroy_waves(timed *t) {
    for (size_t i = 0; i < t->count && t->waves; ++i) {
        if (t->waves[i]) adaptive_destroy(t->waves[i]);
        free(t->waves[i]);
    }
    free(t->waves);
    for (unsigned run = 0; run < ADAPTIVE_RUNS; ++run) free(t->finished[run]);
    adaptive_view_destroy(t->view);
    free(t->order);
}

static void run(job *j) {
    timed t = {.job = j, .grid = film_waves(j->film)};
    t.count = t.grid.count;
    t.waves = calloc(t.count, sizeof(adaptive_wave *));
    for (unsigned run = 0; run < ADAPTIVE_RUNS; ++run) t.finished[run] = calloc(t.count, sizeof **t.finished);
    t.view = adaptive_view_create(j->plan);
    t.order = malloc(t.count * sizeof *t.order);
    if (t.waves && t.finished[0] && t.finished[1] && t.order && t.view && take_up_waves(&t)) {
        run_rounds(&t);
        atomic_store(&j->complete, !atomic_load(&j->stop));
        store_waves(&t);
        tell_sampled(&t);
    } else {
        atomic_store(&j->failed, true);
    }
    destroy_waves(&t);
}

/* Waves keep their own memory for the whole job, so workers need only a view. */
static bool prepare(const job *j, worker *self) {
    self->view = adaptive_view_create(j->plan);
    return self->view;
}

const job_schedule schedule_to_time = {prepare, run};
