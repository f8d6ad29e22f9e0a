#include "measure/replay.h"

#include "base/clock.h"
#include "base/threads.h"
#include "trace/tracer.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* ---- what is kept ---- */

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

void record_keep(record *r, bare_query query, trace_coherence coherence, const void *rays, size_t stride,
                 size_t count) {
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

static void keep(const trace_tracer *tracer, bare_query query, trace_coherence coherence, const void *rays,
                 size_t stride, size_t count) {
    record *to = of(tracer)->to[query];
    if (to) record_keep(to, query, coherence, rays, stride, count);
}

static void closest(const trace_tracer *tracer, trace_block *blocks, trace_fine *fine, size_t count,
                    trace_coherence coherence) {
    keep(tracer, BARE_CLOSEST, coherence, blocks, sizeof *blocks, count);
    of(tracer)->real->ops->closest(of(tracer)->real, blocks, fine, count, coherence);
}

static void any(const trace_tracer *tracer, trace_rays *blocks, size_t count, trace_coherence coherence) {
    keep(tracer, BARE_ANY, coherence, blocks, sizeof *blocks, count);
    of(tracer)->real->ops->any(of(tracer)->real, blocks, count, coherence);
}

/* Rays asked again are the tracer's own affair, and are not kept. */
static bool retry_closest(const trace_tracer *tracer, trace_block *block, unsigned lane, unsigned round) {
    return of(tracer)->real->retry->closest(of(tracer)->real, block, lane, round);
}
static bool retry_any(const trace_tracer *tracer, trace_rays *rays, unsigned lane, unsigned round) {
    return of(tracer)->real->retry->any(of(tracer)->real, rays, lane, round);
}
static bool retry_crossings(const trace_tracer *tracer, uint32_t group, vec3_f32 org, vec3_f32 dir,
                            trace_crossings *out) {
    return of(tracer)->real->retry->crossings(of(tracer)->real, group, org, dir, out);
}
static void retry_bounds(const trace_tracer *tracer, uint32_t group, vec3_f32 *lower, vec3_f32 *upper) {
    of(tracer)->real->retry->bounds(of(tracer)->real, group, lower, upper);
}

trace_tracer *record_tracer(const trace_tracer *real, record *to) {
    static const trace_retry retry = {retry_closest, retry_any, retry_crossings, retry_bounds};
    /* By whether the real one sees planes, and in which precision. */
    static const trace_ops ops[2][2] = {
        {{destroy, closest, any, false, false}, {destroy, closest, any, true, false}},
        {{destroy, closest, any, false, true}, {destroy, closest, any, true, true}}};
    recorder *made = malloc(sizeof *made);
    if (!made) return NULL;
    *made = (recorder){.base = *real, .real = real, .to = {to, to}};
    made->base.ops = &ops[real->ops->planes][real->ops->fine];
    made->base.retry = real->retry ? &retry : NULL;
    return &made->base;
}

void record_redirect(trace_tracer *tracer, record *closest, record *any) {
    recorder *r = (recorder *)tracer;
    r->to[BARE_CLOSEST] = closest, r->to[BARE_ANY] = any;
}

/* ---- asked again ---- */

/* Blocks between two looks at the clocks: 4096 rays, some 0.4 MB in either form. Reading the clocks takes
 * under a microsecond, tracing so many rays more than a hundred. */
#define PIECE 256

/* Part of a recorded call. */
typedef struct part {
    bare_query query;
    trace_coherence coherence;
    size_t first, rays; /* its first block in the piece */
} part;

typedef struct piece {
    bare_block bare[PIECE];
    trace_block closest[PIECE];
    trace_rays any[PIECE];
    part parts[PIECE];
    size_t blocks, count; /* count: of parts */
} piece;

typedef struct replay {
    const record *record;
    const trace_tracer *tracer;
    piece *piece;
    bool bare, coherent;
    unsigned width; /* of bare calls; 0: the tracer's, which says about coherence too */
    replay_result result;
} replay;

/* ---- the two forms ---- */

static void load(replay *p, const part *r, size_t block, const trace_rays *rays) {
    size_t at = r->first + block;
    if (p->bare && p->width)
        embree_bare_load_as(p->tracer, r->query, p->width, p->coherent, rays, trace_lanes(r->rays, block),
                            &p->piece->bare[at]);
    else if (p->bare)
        embree_bare_load(p->tracer, r->query, r->coherence, rays, trace_lanes(r->rays, block),
                         &p->piece->bare[at]);
    else if (r->query == BARE_ANY)
        p->piece->any[at] = *rays;
    else
        p->piece->closest[at].rays = *rays;
}

static void trace(replay *p, const part *r) {
    size_t blocks = (r->rays + LANES - 1) / LANES;
    if (p->bare)
        embree_bare_trace(p->tracer, r->query, &p->piece->bare[r->first], blocks);
    else if (r->query == BARE_ANY)
        trace_any(p->tracer, &p->piece->any[r->first], r->rays, r->coherence);
    else
        trace_closest(p->tracer, &p->piece->closest[r->first], r->rays, r->coherence);
}

static unsigned met(const replay *p, const part *r, size_t block) {
    const piece *q = p->piece;
    size_t at = r->first + block;
    if (p->bare) return embree_bare_met(r->query, &q->bare[at]);
    unsigned hits = 0;
    for (unsigned i = 0; i < trace_lanes(r->rays, block); ++i) {
        hits +=
            r->query == BARE_ANY ? q->any[at].t_far[i] < 0 : q->closest[at].hits.geometry[i] != FATHOM_NONE;
    }
    return hits;
}

/* ---- piece by piece ---- */

static void count_answers(replay *p) {
    for (size_t i = 0; i < p->piece->count; ++i) {
        const part *r = &p->piece->parts[i];
        p->result.rays[r->query] += r->rays;
        for (size_t b = 0; b * LANES < r->rays; ++b) p->result.met[r->query] += met(p, r, b);
    }
}

static void finish_piece(replay *p) {
    double cpu = clock_thread_seconds(), began = clock_seconds();
    for (size_t i = 0; i < p->piece->count; ++i) trace(p, &p->piece->parts[i]);
    p->result.seconds += clock_seconds() - began;
    p->result.cpu_seconds += clock_thread_seconds() - cpu;
    count_answers(p);
    p->piece->blocks = p->piece->count = 0;
}

static void add_call(replay *p, const record_call *call) {
    for (size_t done = 0; done < call->rays;) {
        if (p->piece->blocks == PIECE) finish_piece(p);
        size_t room = (PIECE - p->piece->blocks) * LANES, rays = call->rays - done;
        if (rays > room) rays = room;
        part *r = &p->piece->parts[p->piece->count++];
        *r = (part){call->query, call->coherence, p->piece->blocks, rays};
        for (size_t b = 0; b * LANES < rays; ++b) {
            load(p, r, b, record_block(p->record, call->first + done / LANES + b));
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
