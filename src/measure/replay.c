#include "measure/replay.h"

#include "base/clock.h"
#include "trace/tracer.h"

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

uint64_t record_rays(const record *r, bare_query query) {
    uint64_t rays = 0;
    for (size_t i = 0; i < r->calls.count; ++i)
        if (r->calls.items[i].query == query) rays += r->calls.items[i].rays;
    return rays;
}

/* Allocates pieces that never move, with the alignment of the blocks. */
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

/* Records one call of `count` rays. `stride`: bytes from the rays of one block to those of the next. */
static void keep(record *r, bare_query query, trace_coherence coherence, const void *rays, size_t stride,
                 size_t count) {
    size_t blocks = (count + LANES - 1) / LANES;
    record_call call = {query, coherence, r->blocks, count};
    if (!make_room(r, blocks) || !array_push(&r->calls, call)) {
        r->out_of_memory = true;
        return;
    }
    for (size_t b = 0; b < blocks; ++b)
        *at(r, r->blocks++) = *(const trace_rays *)(const void *)((const char *)rays + b * stride);
}

/* ---- the tracer ---- */

typedef struct recorder {
    trace_tracer base;
    trace_ops ops;
    const trace_tracer *real;
    record *to;
} recorder;

static const recorder *of(const trace_tracer *tracer) { return (const recorder *)tracer; }

static void destroy(trace_tracer *tracer) { free(tracer); }

static void closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence) {
    keep(of(tracer)->to, BARE_CLOSEST, coherence, blocks, sizeof *blocks, count);
    of(tracer)->real->ops->closest(of(tracer)->real, blocks, fine, count, coherence);
}

static void any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    keep(of(tracer)->to, BARE_ANY, coherence, blocks, sizeof *blocks, count);
    of(tracer)->real->ops->any(of(tracer)->real, blocks, count, coherence);
}

trace_tracer *record_tracer(const trace_tracer *real, record *to) {
    recorder *made = malloc(sizeof *made);
    if (!made) return NULL;
    *made = (recorder){.base = *real, .ops = *real->ops, .real = real, .to = to};
    made->ops.destroy = destroy, made->ops.closest = closest, made->ops.any = any;
    made->base.ops = &made->ops;
    return &made->base;
}

/* ---- replaying a record ---- */

/* Blocks between two readings of the clock: 4096 rays, about 0.4 MB in either form. Reading the clock takes
 * less than a microsecond; tracing these rays takes more than a hundred. */
#define PIECE 256

typedef struct piece {
    bare_block bare[PIECE];
    trace_block closest[PIECE];
    trace_rays any[PIECE];
} piece;

/* Rays of one call in a piece. */
typedef struct part {
    bare_query query;
    trace_coherence coherence;
    size_t first, rays; /* first: its first block in the piece */
} part;

typedef struct run {
    const trace_tracer *tracer;
    bool bare;
    piece *piece;
    part parts[PIECE];
    size_t blocks, count; /* blocks: in the piece; count: number of parts */
    replay_result result;
} run;

static void load(const run *r, const part *p, size_t block, const trace_rays *rays) {
    size_t to = p->first + block;
    if (r->bare)
        embree_bare_load(r->tracer, p->query, p->coherence, rays, trace_lanes(p->rays, block),
                         &r->piece->bare[to]);
    else if (p->query == BARE_ANY)
        r->piece->any[to] = *rays;
    else
        r->piece->closest[to].rays = *rays;
}

static void trace(const run *r, const part *p) {
    if (r->bare)
        embree_bare_trace(r->tracer, p->query, &r->piece->bare[p->first], (p->rays + LANES - 1) / LANES);
    else if (p->query == BARE_ANY)
        trace_any(r->tracer, &r->piece->any[p->first], p->rays, p->coherence);
    else
        trace_closest(r->tracer, &r->piece->closest[p->first], p->rays, p->coherence);
}

static uint64_t count_met(const run *r, const part *p) {
    uint64_t hits = 0;
    for (size_t b = 0; r->bare && b * LANES < p->rays; ++b)
        hits += embree_bare_met(p->query, &r->piece->bare[p->first + b]);
    for (size_t i = 0; !r->bare && i < p->rays; ++i) {
        size_t from = p->first + i / LANES, k = i % LANES;
        hits += p->query == BARE_ANY ? r->piece->any[from].t_far[k] < 0
                                     : r->piece->closest[from].hits.geometry[k] != FATHOM_NONE;
    }
    return hits;
}

static void finish_piece(run *r) {
    double cpu = clock_thread_seconds();
    for (size_t i = 0; i < r->count; ++i) trace(r, &r->parts[i]);
    r->result.cpu_seconds += clock_thread_seconds() - cpu;
    for (size_t i = 0; i < r->count; ++i) {
        const part *p = &r->parts[i];
        r->result.rays[p->query] += p->rays;
        r->result.met[p->query] += count_met(r, p);
    }
    r->blocks = r->count = 0;
}

static void add_call(run *r, const record *from, const record_call *call) {
    for (size_t done = 0; done < call->rays;) {
        if (r->blocks == PIECE) finish_piece(r);
        size_t room = (PIECE - r->blocks) * LANES, rays = call->rays - done;
        if (rays > room) rays = room;
        part *p = &r->parts[r->count++];
        *p = (part){call->query, call->coherence, r->blocks, rays};
        for (size_t b = 0; b * LANES < rays; ++b, ++r->blocks)
            load(r, p, b, at(from, call->first + done / LANES + b));
        done += rays;
    }
}

bool replay(const record *from, const trace_tracer *tracer, bool bare, replay_result *out) {
    run r = {.tracer = tracer, .bare = bare, .piece = aligned_alloc(64, sizeof *r.piece)};
    if (!r.piece) return false;
    memset(r.piece, 0, sizeof *r.piece); /* touches the pages before the first timing */
    unsigned state = trace_thread_begin();
    for (size_t i = 0; i < from->calls.count; ++i) add_call(&r, from, &from->calls.items[i]);
    finish_piece(&r);
    trace_thread_end(state);
    free(r.piece);
    *out = r.result;
    return true;
}
