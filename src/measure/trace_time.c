#include "measure/trace_time.h"

#include "base/clock.h"
#include "base/threads.h"

#include <stdlib.h>

/* Blocks that a thread copies, untimed, and then traces: 4096 rays. */
#define PIECE 256

typedef struct piece {
    trace_block closest[PIECE];
    trace_rays any[PIECE];
} piece;

/* Of one thread; no two share a line of the cache. */
typedef struct worker {
    _Alignas(64) piece *piece;
    double seconds, cpu;
    uint64_t met;
} worker;

/* One tracer over `blocks` of the set's blocks. */
typedef struct turn {
    const trace_tracer *tracer;
    const trace_set *set;
    trace_set_kind kind;
    size_t blocks;
    worker *workers;
} turn;

static void load(const turn *t, size_t begin, size_t end, piece *p) {
    for (size_t b = begin; b < end; ++b) {
        const trace_rays *rays = &t->set->blocks[b * t->set->count / t->blocks];
        if (trace_set_query(t->kind) == BARE_ANY)
            p->any[b - begin] = *rays;
        else
            p->closest[b - begin].rays = *rays;
    }
}

static uint64_t met(const turn *t, size_t blocks, const piece *p) {
    uint64_t hits = 0;
    for (size_t i = 0; i < blocks * TRACE_WIDTH; ++i) {
        size_t b = i / TRACE_WIDTH, k = i % TRACE_WIDTH;
        hits += trace_set_query(t->kind) == BARE_ANY ? p->any[b].t_far[k] < 0
                                                     : p->closest[b].hits.geometry[k] != FATHOM_NONE;
    }
    return hits;
}

static void run_piece(void *user, size_t begin, size_t end, unsigned index) {
    const turn *t = user;
    worker *w = &t->workers[index];
    trace_coherence coherence = trace_set_coherence(t->kind);
    size_t rays = (end - begin) * TRACE_WIDTH;
    unsigned state = trace_thread_begin();
    load(t, begin, end, w->piece);
    double cpu = clock_thread_seconds(), began = clock_seconds();
    if (trace_set_query(t->kind) == BARE_ANY)
        trace_any(t->tracer, w->piece->any, rays, coherence);
    else
        trace_closest(t->tracer, w->piece->closest, rays, coherence);
    w->seconds += clock_seconds() - began;
    w->cpu += clock_thread_seconds() - cpu;
    trace_thread_end(state);
    w->met += met(t, end - begin, w->piece);
}

typedef struct outcome {
    double seconds, cpu; /* of all threads together */
    uint64_t met;
} outcome;

static outcome take_turn(const turn *t, unsigned threads) {
    turn now = *t;
    for (unsigned i = 0; i < threads; ++i)
        t->workers[i].seconds = t->workers[i].cpu = 0, t->workers[i].met = 0;
    size_t share = (t->blocks + threads - 1) / threads;
    loop_parallel(threads, t->blocks, share < PIECE ? share : PIECE, run_piece, &now);
    outcome sum = {0, 0, 0};
    for (unsigned i = 0; i < threads; ++i) {
        sum.seconds += t->workers[i].seconds, sum.cpu += t->workers[i].cpu;
        sum.met += t->workers[i].met;
    }
    return sum;
}

/* How many blocks fit the time, found by doubling; the first are also what warms the caches. */
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

typedef struct samples {
    double per_second[TRACE_TIME_REPEATS_MAX], per_cpu_second[TRACE_TIME_REPEATS_MAX];
} samples;

/* Finding how many blocks fit takes up to about two turns. */
#define FITTING 2.0

/* turns: that are done. */
static void tell(const trace_time_options *options, size_t count, double turns) {
    bench_watch_tell(options->watch, turns, (options->repeats + FITTING) * (double)(count * TRACE_SETS));
}

static void measure(const trace_tracer *const *tracers, size_t count, turn turns[][TRACE_SETS],
                    const trace_time_options *options, samples *kept, trace_rate (*out)[TRACE_SETS]) {
    for (size_t i = 0; i < count * TRACE_SETS; ++i) {
        turn *t = &turns[i / TRACE_SETS][i % TRACE_SETS];
        t->tracer = tracers[i / TRACE_SETS];
        t->blocks = fitting_blocks(*t, options);
        tell(options, count, FITTING * (double)(i + 1));
    }
    const double fitted = FITTING * (double)(count * TRACE_SETS);
    for (unsigned k = 0; k < options->repeats; ++k) {
        for (size_t i = 0; i < count * TRACE_SETS; ++i) {
            size_t tracer = (i + k) % count, set = i / count;
            const turn *t = &turns[tracer][set];
            outcome o = take_turn(t, options->threads);
            double rays = (double)(t->blocks * TRACE_WIDTH);
            samples *to = &kept[tracer * TRACE_SETS + set];
            to->per_second[k] = rays * options->threads / o.seconds;
            to->per_cpu_second[k] = rays / o.cpu;
            tell(options, count, fitted + (double)(k * count * TRACE_SETS + i + 1));
            out[tracer][set].rays = t->blocks * TRACE_WIDTH, out[tracer][set].met = o.met;
        }
    }
    for (size_t i = 0; i < count * TRACE_SETS; ++i) {
        trace_rate *rate = &out[i / TRACE_SETS][i % TRACE_SETS];
        rate->per_second = quartiles_of(kept[i].per_second, options->repeats);
        rate->per_cpu_second = quartiles_of(kept[i].per_cpu_second, options->repeats);
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

fathom_status trace_time_measure(fathom_context *context, const trace_tracer *const *tracers, size_t count,
                                 const trace_set sets[TRACE_SETS], const trace_time_options *options,
                                 trace_rate (*out)[TRACE_SETS]) {
    worker *workers;
    bool ok = workers_create(options->threads, &workers);
    samples *kept = calloc(count * TRACE_SETS, sizeof *kept);
    turn turns[TRACE_TIME_TRACERS_MAX][TRACE_SETS];
    for (size_t i = 0; i < count * TRACE_SETS; ++i) {
        size_t set = i % TRACE_SETS;
        turns[i / TRACE_SETS][set] =
            (turn){.set = &sets[set], .kind = (trace_set_kind)set, .workers = workers};
    }
    if (ok && kept) measure(tracers, count, turns, options, kept, out);
    for (unsigned i = 0; i < options->threads && workers; ++i) free(workers[i].piece);
    free(workers);
    fathom_status status = ok && kept ? FATHOM_OK : fail_memory(context, sizeof(piece));
    free(kept);
    return status;
}
