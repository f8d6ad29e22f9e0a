#include "measure/trace_time.h"

#include "base/clock.h"
#include "base/threads.h"

#include <stdlib.h>

/* Blocks between two readings of the clocks: 4096 rays fit in the second-level cache. Reading the clocks
 * takes less than a microsecond; tracing these rays takes more than a hundred. */
#define PIECE 256

typedef union piece {
    trace_block closest[PIECE];
    trace_rays any[PIECE];
} piece;

/* State of one thread. Aligned, so that no two threads share a cache line. */
typedef struct worker {
    _Alignas(64) piece *piece;
    double seconds, cpu;
    uint64_t met;
} worker;

/* One tracer traces `blocks` of the set's blocks. */
typedef struct turn {
    const trace_tracer *tracer;
    const trace_set *set;
    size_t blocks;
    worker *workers;
} turn;

static uint64_t count_met(bool any, const piece *p, size_t rays) {
    uint64_t met = 0;
    for (size_t i = 0; i < rays; ++i)
        met += any ? p->any[i / LANES].t_far[i % LANES] < 0
                   : p->closest[i / LANES].hits.geometry[i % LANES] != FATHOM_NONE;
    return met;
}

static void run_piece(void *user, size_t begin, size_t end, unsigned index) {
    const turn *t = user;
    const trace_set *set = t->set;
    worker *w = &t->workers[index];
    const size_t rays = (end - begin) * LANES;
    unsigned state = trace_thread_begin();
    for (size_t b = begin; b < end; ++b)
        *(set->any ? &w->piece->any[b - begin] : &w->piece->closest[b - begin].rays) =
            set->blocks[b * set->count / t->blocks];
    double cpu = clock_thread_seconds(), began = clock_seconds();
    if (set->any)
        trace_any(t->tracer, w->piece->any, rays, set->coherence);
    else
        trace_closest(t->tracer, w->piece->closest, rays, set->coherence);
    w->seconds += clock_seconds() - began;
    w->cpu += clock_thread_seconds() - cpu;
    trace_thread_end(state);
    w->met += count_met(set->any, w->piece, rays);
}

typedef struct outcome {
    double seconds, cpu; /* sums over all threads */
    uint64_t met;
} outcome;

static outcome take_turn(const turn *t, unsigned threads) {
    turn now = *t;
    for (unsigned i = 0; i < threads; ++i)
        t->workers[i].seconds = t->workers[i].cpu = 0, t->workers[i].met = 0;
    size_t share = (t->blocks + threads - 1) / threads;
    loop_workers(threads, t->blocks, share < PIECE ? share : PIECE, run_piece, &now);
    outcome sum = {0, 0, 0};
    for (unsigned i = 0; i < threads; ++i) {
        sum.seconds += t->workers[i].seconds, sum.cpu += t->workers[i].cpu;
        sum.met += t->workers[i].met;
    }
    return sum;
}

/* The number of blocks that fit the time, found by doubling. These runs also warm the caches. */
static size_t fitting_blocks(turn t, const trace_time_options *options) {
    for (t.blocks = 1;; t.blocks *= 2) {
        if (t.blocks > t.set->count) t.blocks = t.set->count;
        double seconds = take_turn(&t, options->threads).cpu / options->threads;
        if (t.blocks == t.set->count && seconds <= options->seconds) return t.blocks;
        if (seconds < options->seconds / 16 && t.blocks < t.set->count) continue;
        double fit = (double)t.blocks * options->seconds / seconds;
        if (fit < 1) return 1;
        return fit < (double)t.set->count ? (size_t)fit : t.set->count;
    }
}

/* ---- all of them ---- */

/* Finding this number takes up to about two turns. */
#define FITTING 2.0

typedef struct contest {
    trace_tracer *const *tracers;
    size_t count, all; /* number of tracers; number of pairs of tracer and set */
    const trace_sets *sets;
    const trace_time_options *options;
    worker *workers;
    size_t *blocks;     /* by tracer and set, as are `samples` */
    double *samples[2]; /* rays per second of wall-clock and of processor time: `repeats` values each */
} contest;

static turn turn_of(const contest *c, size_t i) {
    return (turn){c->tracers[i / TRACE_SETS], &c->sets->items[i % TRACE_SETS], c->blocks[i], c->workers};
}

/* turns: number of finished turns. */
static void tell(const contest *c, double turns) {
    bench_watch_tell(c->options->watch, turns, (c->options->repeats + FITTING) * (double)c->all);
}

static void measure(const contest *c, trace_rate (*out)[TRACE_SETS]) {
    const size_t repeats = c->options->repeats;
    for (size_t i = 0; i < c->all; ++i) {
        c->blocks[i] = fitting_blocks(turn_of(c, i), c->options);
        tell(c, FITTING * (double)(i + 1));
    }
    for (size_t k = 0; k < repeats; ++k) {
        for (size_t i = 0; i < c->all; ++i) {
            const size_t tracer = (i + k) % c->count, set = i / c->count, at = tracer * TRACE_SETS + set;
            const turn t = turn_of(c, at);
            const outcome o = take_turn(&t, c->options->threads);
            const double rays = (double)(t.blocks * LANES);
            c->samples[0][at * repeats + k] = rays * c->options->threads / o.seconds;
            c->samples[1][at * repeats + k] = rays / o.cpu;
            out[tracer][set].rays = t.blocks * LANES, out[tracer][set].met = o.met;
            tell(c, FITTING * (double)c->all + (double)(k * c->all + i + 1));
        }
    }
    for (size_t i = 0; i < c->all; ++i) {
        trace_rate *rate = &out[i / TRACE_SETS][i % TRACE_SETS];
        rate->per_second = quartiles_of(&c->samples[0][i * repeats], repeats);
        rate->per_cpu_second = quartiles_of(&c->samples[1][i * repeats], repeats);
    }
}

static bool workers_create(unsigned threads, worker **out) {
    worker *workers = aligned_alloc(64, threads * sizeof *workers);
    bool ok = workers != NULL;
    for (unsigned i = 0; i < threads && workers; ++i) {
        workers[i].piece = aligned_alloc(64, sizeof *workers[i].piece);
        ok &= workers[i].piece != NULL;
    }
    *out = workers;
    return ok;
}

fathom_status trace_time_measure(fathom_context *context, trace_tracer *const *tracers, size_t count,
                                 const trace_sets *sets, const trace_time_options *options,
                                 trace_rate (*out)[TRACE_SETS]) {
    contest c = {
        .tracers = tracers, .count = count, .all = count * TRACE_SETS, .sets = sets, .options = options};
    bool ok = workers_create(options->threads, &c.workers);
    c.blocks = calloc(c.all + 1, sizeof *c.blocks);
    for (int i = 0; i < 2; ++i) c.samples[i] = calloc(c.all * options->repeats + 1, sizeof *c.samples[i]);
    ok = ok && c.blocks && c.samples[0] && c.samples[1];
    if (ok) measure(&c, out);
    for (unsigned i = 0; i < options->threads && c.workers; ++i) free(c.workers[i].piece);
    free(c.workers);
    free(c.blocks);
    free(c.samples[0]);
    free(c.samples[1]);
    return ok ? FATHOM_OK : fail_memory(context, sizeof(piece));
}
