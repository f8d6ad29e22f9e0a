#include "measure/replay.h"

#include "base/clock.h"
#include "base/threads.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Blocks between two looks at the clocks: 4096 rays, some 0.4 MB in either form. Reading the clocks takes
 * under a microsecond, tracing so many rays more than a hundred. */
#define PIECE 256

/* Part of a recorded call. */
typedef struct run {
    bare_query query;
    trace_coherence coherence;
    size_t first, rays; /* its first block in the piece */
} run;

typedef struct piece {
    bare_block bare[PIECE];
    trace_block closest[PIECE];
    trace_rays any[PIECE];
    run runs[PIECE];
    size_t blocks, count; /* count: of runs */
} piece;

typedef struct replay {
    const record *record;
    const trace_tracer *tracer;
    piece *piece;
    bool bare, coherent;
    unsigned width; /* of bare calls; 0: the tracer's, which says about coherence too */
    replay_result result;
} replay;

static unsigned lanes_of(const run *r, size_t block) {
    size_t left = r->rays - block * TRACE_WIDTH;
    return left < TRACE_WIDTH ? (unsigned)left : TRACE_WIDTH;
}

/* ---- the two forms ---- */

static void load(replay *p, const run *r, size_t block, const trace_rays *rays) {
    size_t at = r->first + block;
    if (p->bare && p->width)
        embree_bare_load_as(p->tracer, r->query, p->width, p->coherent, rays, lanes_of(r, block),
                            &p->piece->bare[at]);
    else if (p->bare)
        embree_bare_load(p->tracer, r->query, r->coherence, rays, lanes_of(r, block), &p->piece->bare[at]);
    else if (r->query == BARE_ANY)
        p->piece->any[at] = *rays;
    else
        p->piece->closest[at].rays = *rays;
}

static void trace(replay *p, const run *r) {
    size_t blocks = (r->rays + TRACE_WIDTH - 1) / TRACE_WIDTH;
    if (p->bare)
        embree_bare_trace(p->tracer, r->query, &p->piece->bare[r->first], blocks);
    else if (r->query == BARE_ANY)
        trace_any(p->tracer, &p->piece->any[r->first], r->rays, r->coherence);
    else
        trace_closest(p->tracer, &p->piece->closest[r->first], r->rays, r->coherence);
}

static unsigned met(const replay *p, const run *r, size_t block) {
    const piece *q = p->piece;
    size_t at = r->first + block;
    if (p->bare) return embree_bare_met(r->query, &q->bare[at]);
    unsigned hits = 0;
    for (unsigned i = 0; i < lanes_of(r, block); ++i) {
        hits +=
            r->query == BARE_ANY ? q->any[at].t_far[i] < 0 : q->closest[at].hits.geometry[i] != FATHOM_NONE;
    }
    return hits;
}

/* ---- piece by piece ---- */

static void count_answers(replay *p) {
    for (size_t i = 0; i < p->piece->count; ++i) {
        const run *r = &p->piece->runs[i];
        p->result.rays[r->query] += r->rays;
        for (size_t b = 0; b * TRACE_WIDTH < r->rays; ++b) p->result.met[r->query] += met(p, r, b);
    }
}

static void finish_piece(replay *p) {
    double cpu = clock_thread_seconds(), began = clock_seconds();
    for (size_t i = 0; i < p->piece->count; ++i) trace(p, &p->piece->runs[i]);
    p->result.seconds += clock_seconds() - began;
    p->result.cpu_seconds += clock_thread_seconds() - cpu;
    count_answers(p);
    p->piece->blocks = p->piece->count = 0;
}

static void add_call(replay *p, const record_call *call) {
    for (size_t done = 0; done < call->rays;) {
        if (p->piece->blocks == PIECE) finish_piece(p);
        size_t room = (PIECE - p->piece->blocks) * TRACE_WIDTH, rays = call->rays - done;
        if (rays > room) rays = room;
        run *r = &p->piece->runs[p->piece->count++];
        *r = (run){call->query, call->coherence, p->piece->blocks, rays};
        for (size_t b = 0; b * TRACE_WIDTH < rays; ++b) {
            load(p, r, b, record_block(p->record, call->first + done / TRACE_WIDTH + b));
            ++p->piece->blocks;
        }
        done += rays;
    }
}

static bool replay_all(replay *p, replay_result *out) {
    const record *r = p->record;
    p->piece = aligned_alloc(64, sizeof *p->piece);
    if (!p->piece) return false;
    memset(p->piece, 0, sizeof *p->piece); /* the pages are there before the first is timed */
    unsigned state = trace_thread_begin();
    for (size_t i = 0; i < r->calls.count; ++i) add_call(p, &r->calls.items[i]);
    finish_piece(p);
    trace_thread_end(state);
    free(p->piece);
    *out = p->result;
    return true;
}

bool replay_bare(const record *r, const trace_tracer *tracer, replay_result *out) {
    replay p = {.record = r, .tracer = tracer, .bare = true};
    return replay_all(&p, out);
}

typedef struct together {
    const record *record;
    const trace_tracer *tracer;
    replay_result *results; /* of each thread */
    atomic_bool failed;
} together;

static void ask_all(void *user, size_t begin, size_t end, unsigned worker) {
    together *t = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        if (!replay_bare(t->record, t->tracer, &t->results[i])) atomic_store(&t->failed, true);
    }
}

bool replay_bare_together(const record *r, const trace_tracer *tracer, unsigned threads, replay_result *out) {
    together t = {.record = r, .tracer = tracer, .results = calloc(threads, sizeof *t.results)};
    if (!t.results) return false;
    loop_parallel(threads, threads, 1, ask_all, &t);
    *out = t.results[0];
    for (unsigned i = 1; i < threads; ++i) {
        out->seconds += t.results[i].seconds;
        out->cpu_seconds += t.results[i].cpu_seconds;
    }
    out->seconds /= threads;
    out->cpu_seconds /= threads;
    free(t.results);
    return !atomic_load(&t.failed);
}

bool replay_bare_as(const record *r, const trace_tracer *tracer, unsigned width, bool coherent,
                    replay_result *out) {
    replay p = {.record = r, .tracer = tracer, .bare = true, .width = width, .coherent = coherent};
    return replay_all(&p, out);
}

bool replay_traced(const record *r, const trace_tracer *tracer, replay_result *out) {
    replay p = {.record = r, .tracer = tracer};
    return replay_all(&p, out);
}
