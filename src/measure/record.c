#include "measure/record.h"

#include "trace/tracer.h"

#include <stdlib.h>

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
    size_t blocks = (count + TRACE_WIDTH - 1) / TRACE_WIDTH;
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
