#include "measure/trace_time.h"

#include "base/clock.h"
#include "base/threads.h"

#include <stdlib.h>

/* One thread's state; no two share a cache line. */
typedef struct worker {
    _Alignas(64) replay_piece *piece;
    double seconds, cpu;
    uint64_t met;
} worker;

/* One tracer over `blocks` of the set's blocks. */
typedef struct turn {
    const replay_way *way;
    const trace_set *set;
    size_t blocks;
    worker *workers;
} turn;

static void run_piece(void *user, size_t begin, size_t end, unsigned index) {
    const turn *t = user;
    worker *w = &t->workers[index];
    const replay_part part = {t->set->query, t->set->coherence, 0, (end - begin) * LANES};
    unsigned state = trace_thread_begin();
    for (size_t b = begin; b < end; ++b)
        replay_load(t->way, &part, b - begin, &t->set->blocks[b * t->set->count / t->blocks], w->piece);
    double cpu = clock_thread_seconds(), began = clock_seconds();
    replay_trace(t->way, &part, w->piece);
    w->seconds += clock_seconds() - began;
    w->cpu += clock_thread_seconds() - cpu;
    trace_thread_end(state);
    w->met += replay_met(t->way, &part, w->piece);
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
    loop_parallel(threads, t->blocks, share < REPLAY_PIECE ? share : REPLAY_PIECE, run_piece, &now);
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

/* Finding how many blocks fit takes up to about two turns. */
#define FITTING 2.0

typedef struct contest {
    const replay_way *ways;
    size_t count, all; /* of ways; of ways and sets together */
    const trace_sets *sets;
    const trace_time_options *options;
    worker *workers;
    size_t *blocks;     /* by way and set, like the next */
    double *samples[2]; /* rays a second by the clock, and of processor time: `repeats` of each */
} contest;

static turn turn_of(const contest *c, size_t way, size_t set) {
    return (turn){&c->ways[way], &c->sets->items[set], c->blocks[way * c->sets->count + set], c->workers};
}

/* turns: that are done. */
static void tell(const contest *c, double turns) {
    bench_watch_tell(c->options->watch, turns, (c->options->repeats + FITTING) * (double)c->all);
}

static void measure(const contest *c, trace_rate (*out)[TRACE_SETS_MAX]) {
    const size_t sets = c->sets->count, repeats = c->options->repeats;
    for (size_t i = 0; i < c->all; ++i) {
        c->blocks[i] = fitting_blocks(turn_of(c, i / sets, i % sets), c->options);
        tell(c, FITTING * (double)(i + 1));
    }
    for (size_t k = 0; k < repeats; ++k) {
        for (size_t i = 0; i < c->all; ++i) {
            const size_t way = (i + k) % c->count, set = i / c->count, at = way * sets + set;
            const turn t = turn_of(c, way, set);
            const outcome o = take_turn(&t, c->options->threads);
            const double rays = (double)(t.blocks * LANES);
            c->samples[0][at * repeats + k] = rays * c->options->threads / o.seconds;
            c->samples[1][at * repeats + k] = rays / o.cpu;
            out[way][set].rays = t.blocks * LANES, out[way][set].met = o.met;
            tell(c, FITTING * (double)c->all + (double)(k * c->all + i + 1));
        }
    }
    for (size_t i = 0; i < c->all; ++i) {
        out[i / sets][i % sets].per_second = quartiles_of(&c->samples[0][i * repeats], repeats);
        out[i / sets][i % sets].per_cpu_second = quartiles_of(&c->samples[1][i * repeats], repeats);
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

fathom_status trace_time_measure(fathom_context *context, const replay_way *ways, size_t count,
                                 const trace_sets *sets, const trace_time_options *options,
                                 trace_rate (*out)[TRACE_SETS_MAX]) {
    contest c = {.ways = ways, .count = count, .all = count * sets->count, .sets = sets, .options = options};
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
    return ok ? FATHOM_OK : fail_memory(context, sizeof(replay_piece));
}
