#include "measure/replay.h"

#include "base/clock.h"
#include "base/threads.h"
#include "trace/tracer.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* ---- the record ---- */

void record_clear(record *r) {
    r->calls.count = 0;
    r->blocks = 0;
    r->out_of_memory = false;
}

void record_free(record *r) {
    for (size_t i = 0; i < r->pieces.count; ++i) free(r->pieces.items[i]);
    array_free(&r->pieces);
    array_free(&r->calls);
    *r = (record){.blocks = 0};
}

static trace_rays *at(const record *r, size_t index) {
    return &r->pieces.items[index / RECORD_PIECE][index % RECORD_PIECE];
}

const trace_rays *record_block(const record *r, size_t index) { return at(r, index); }

uint64_t record_rays(const record *r, bare_query query) {
    uint64_t rays = 0;
    for (size_t i = 0; i < r->calls.count; ++i) {
        if (r->calls.items[i].query == query) rays += r->calls.items[i].rays;
    }
    return rays;
}

/* In pieces that stay where they are, aligned as the blocks must be. */
static bool make_room(record *r, size_t blocks) {
    while (r->pieces.count * RECORD_PIECE < r->blocks + blocks) {
        trace_rays *piece = aligned_alloc(64, RECORD_PIECE * sizeof *piece);
        if (piece && array_push(&r->pieces, piece)) continue;
        free(piece);
        r->out_of_memory = true;
        return false;
    }
    return true;
}

/* One call of so many rays; `stride`: bytes from one block's rays to the next one's. */
static void keep(record *r, bare_query query, trace_coherence coherence, const void *rays, size_t stride,
                 size_t count) {
    if (!r) return;
    size_t blocks = (count + LANES - 1) / LANES;
    record_call call = {query, coherence, r->blocks, count};
    if (!make_room(r, blocks) || !array_push(&r->calls, call)) {
        r->out_of_memory = true;
        return;
    }
    for (size_t b = 0; b < blocks; ++b) {
        *at(r, r->blocks++) = *(const trace_rays *)(const void *)((const char *)rays + b * stride);
    }
}

/* ---- the tracer ---- */

typedef struct recorder {
    trace_tracer base;
    const trace_tracer *real;
    record *to[2]; /* by bare_query */
} recorder;

static const recorder *of(const trace_tracer *tracer) { return (const recorder *)tracer; }

static void destroy(trace_tracer *tracer) { free(tracer); }

static void closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence) {
    keep(of(tracer)->to[BARE_CLOSEST], BARE_CLOSEST, coherence, blocks, sizeof *blocks, count);
    of(tracer)->real->ops->closest(of(tracer)->real, blocks, fine, count, coherence);
}

static void any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    keep(of(tracer)->to[BARE_ANY], BARE_ANY, coherence, blocks, sizeof *blocks, count);
    of(tracer)->real->ops->any(of(tracer)->real, blocks, count, coherence);
}

trace_tracer *record_tracer(const trace_tracer *real, record *closest_to, record *any_to) {
    /* By whether the real one sees planes, and in which precision. */
    static const trace_ops ops[2][2] = {
        {{destroy, closest, any, false, false}, {destroy, closest, any, true, false}},
        {{destroy, closest, any, false, true}, {destroy, closest, any, true, true}}};
    recorder *made = malloc(sizeof *made);
    if (!made) return NULL;
    *made = (recorder){.base = *real, .real = real, .to = {closest_to, any_to}};
    made->base.ops = &ops[real->ops->planes][real->ops->fine];
    return &made->base;
}

/* ---- rays in the form in which they are asked ---- */

void replay_load(const replay_way *way, const replay_part *part, size_t block, const trace_rays *rays,
                 replay_piece *piece) {
    size_t to = part->first + block;
    if (way->bare)
        embree_bare_load(way->tracer, part->query, part->coherence, rays, trace_lanes(part->rays, block),
                         &piece->bare[to]);
    else if (part->query == BARE_ANY)
        piece->any[to] = *rays;
    else
        piece->closest[to].rays = *rays;
}

void replay_trace(const replay_way *way, const replay_part *part, replay_piece *piece) {
    size_t blocks = (part->rays + LANES - 1) / LANES;
    if (way->bare)
        embree_bare_trace(way->tracer, part->query, &piece->bare[part->first], blocks);
    else if (part->query == BARE_ANY)
        trace_any(way->tracer, &piece->any[part->first], part->rays, part->coherence);
    else
        trace_closest(way->tracer, &piece->closest[part->first], part->rays, part->coherence);
}

uint64_t replay_met(const replay_way *way, const replay_part *part, const replay_piece *piece) {
    uint64_t hits = 0;
    for (size_t b = 0; way->bare && b * LANES < part->rays; ++b)
        hits += embree_bare_met(part->query, &piece->bare[part->first + b]);
    for (size_t i = 0; !way->bare && i < part->rays; ++i) {
        size_t from = part->first + i / LANES, k = i % LANES;
        hits += part->query == BARE_ANY ? piece->any[from].t_far[k] < 0
                                        : piece->closest[from].hits.geometry[k] != FATHOM_NONE;
    }
    return hits;
}

/* ---- a whole record asked again ---- */

typedef struct run {
    const record *record;
    const replay_way *way;
    replay_piece *piece;
    replay_part parts[REPLAY_PIECE];
    size_t blocks, count; /* in the piece; count: of parts */
    replay_result result;
} run;

static void finish_piece(run *p) {
    double cpu = clock_thread_seconds(), began = clock_seconds();
    for (size_t i = 0; i < p->count; ++i) replay_trace(p->way, &p->parts[i], p->piece);
    p->result.seconds += clock_seconds() - began;
    p->result.cpu_seconds += clock_thread_seconds() - cpu;
    for (size_t i = 0; i < p->count; ++i) {
        const replay_part *part = &p->parts[i];
        p->result.rays[part->query] += part->rays;
        p->result.met[part->query] += replay_met(p->way, part, p->piece);
    }
    p->blocks = p->count = 0;
}

static void add_call(run *p, const record_call *call) {
    for (size_t done = 0; done < call->rays;) {
        if (p->blocks == REPLAY_PIECE) finish_piece(p);
        size_t room = (REPLAY_PIECE - p->blocks) * LANES, rays = call->rays - done;
        if (rays > room) rays = room;
        replay_part *part = &p->parts[p->count++];
        *part = (replay_part){call->query, call->coherence, p->blocks, rays};
        for (size_t b = 0; b * LANES < rays; ++b, ++p->blocks)
            replay_load(p->way, part, b, at(p->record, call->first + done / LANES + b), p->piece);
        done += rays;
    }
}

bool replay(const record *r, const replay_way *way, replay_result *out) {
    run p = {.record = r, .way = way, .piece = aligned_alloc(64, sizeof *p.piece)};
    if (!p.piece) return false;
    memset(p.piece, 0, sizeof *p.piece); /* the pages are there before the first is timed */
    unsigned state = trace_thread_begin();
    for (size_t i = 0; i < r->calls.count; ++i) add_call(&p, &r->calls.items[i]);
    finish_piece(&p);
    trace_thread_end(state);
    free(p.piece);
    *out = p.result;
    return true;
}

typedef struct together {
    const record *record;
    replay_way way;
    replay_result *results; /* of each thread */
    atomic_bool failed;
} together;

static void ask_all(void *user, size_t begin, size_t end, unsigned worker) {
    together *t = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        if (!replay(t->record, &t->way, &t->results[i])) atomic_store(&t->failed, true);
    }
}

bool replay_together(const record *r, const trace_tracer *tracer, unsigned threads, replay_result *out) {
    together t = {.record = r, .way = {tracer, true}, .results = calloc(threads, sizeof *t.results)};
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
