#include "verify/ask.h"

#include "base/clock.h"
#include "base/threads.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

/* ---- batches ---- */

void ask_batch_free(ask_batch *batch) {
    free(batch->rays), free(batch->closest), free(batch->fine), free(batch->any), free(batch->call_of);
    array_free(&batch->calls);
    *batch = (ask_batch){.stopped = batch->stopped};
}

bool ask_batch_clear(ask_batch *batch, size_t blocks) {
    batch->blocks = batch->calls.count = 0;
    if (blocks <= batch->room) return true;
    ask_batch_free(batch);
    batch->rays = calloc(blocks * LANES, sizeof *batch->rays);
    batch->closest = aligned_alloc(64, blocks * sizeof *batch->closest);
    batch->fine = calloc(blocks, sizeof *batch->fine);
    batch->any = aligned_alloc(64, blocks * sizeof *batch->any);
    batch->call_of = calloc(blocks, sizeof *batch->call_of);
    batch->room = blocks;
    return batch->rays && batch->closest && batch->fine && batch->any && batch->call_of;
}

bool ask_batch_add(ask_batch *batch, size_t count, trace_coherence coherence, bool closest, bool any) {
    const ask_call call = {batch->blocks, count, coherence, closest, any};
    size_t end = batch->blocks + (count + LANES - 1) / LANES;
    if (!array_push(&batch->calls, call)) return false;
    for (; batch->blocks < end; ++batch->blocks)
        batch->call_of[batch->blocks] = (uint32_t)batch->calls.count - 1;
    return true;
}

static const ask_call *call_of(const ask_batch *batch, size_t block) {
    return &batch->calls.items[batch->call_of[block]];
}

unsigned ask_lanes(const ask_batch *batch, size_t block) {
    const ask_call *call = call_of(batch, block);
    return trace_lanes(call->count, block - call->first);
}

/* ---- one block ---- */

static void put_ray(trace_rays *r, unsigned lane, const oracle_ray *ray) {
    r->org_x[lane] = ray->org.x, r->org_y[lane] = ray->org.y, r->org_z[lane] = ray->org.z;
    r->dir_x[lane] = ray->dir.x, r->dir_y[lane] = ray->dir.y, r->dir_z[lane] = ray->dir.z;
    r->t_near[lane] = ray->t_near, r->t_far[lane] = ray->t_far;
}

ask_answer ask_closest_of(const trace_block *block, const trace_fine *fine, unsigned lane) {
    const trace_hits *h = &block->hits;
    if (h->geometry[lane] == FATHOM_NONE) return (ask_answer){.hit = {.geometry = FATHOM_NONE}};
    return (ask_answer){.hit = {h->geometry[lane], h->primitive[lane], h->instance[lane],
                                fine ? fine->t[lane] : (double)block->rays.t_far[lane],
                                fine ? fine->t_low[lane] : 0},
                        .u = fine ? fine->u[lane] : (double)h->u[lane],
                        .v = fine ? fine->v[lane] : (double)h->v[lane],
                        .normal = {h->ng_x[lane], h->ng_y[lane], h->ng_z[lane]}};
}

static bool met_of(const trace_rays *rays, unsigned lane) { return rays->t_far[lane] == -INFINITY; }

ask_answer ask_answer_of(const ask_batch *batch, size_t ray) {
    size_t block = ray / LANES;
    unsigned lane = ray % LANES;
    ask_answer a = {.hit = {.geometry = FATHOM_NONE}};
    if (call_of(batch, block)->closest) a = ask_closest_of(&batch->closest[block], &batch->fine[block], lane);
    a.met = call_of(batch, block)->any && met_of(&batch->any[block], lane);
    return a;
}

bool ask_same_primitive(const ask_answer *a, const ask_answer *b) {
    const verdict_answer *h = &a->hit, *k = &b->hit;
    if (h->geometry == FATHOM_NONE) return k->geometry == FATHOM_NONE;
    return h->geometry == k->geometry && h->primitive == k->primitive && h->instance == k->instance;
}

static bool same_bits(double a, double b) { return memcmp(&a, &b, sizeof a) == 0; }

bool ask_same(const ask_answer *a, const ask_answer *b, bool any) {
    if (any) return a->met == b->met;
    return ask_same_primitive(a, b) && same_bits(a->hit.t, b->hit.t) &&
           same_bits(a->hit.t_low, b->hit.t_low) && same_bits(a->u, b->u) && same_bits(a->v, b->v) &&
           memcmp(&a->normal, &b->normal, sizeof a->normal) == 0;
}

bool ask_alike(const ask_answer *a, const ask_answer *b, bool any) {
    if (any) return a->met == b->met;
    return ask_same_primitive(a, b) && (a->hit.geometry == FATHOM_NONE || (float)a->hit.t == (float)b->hit.t);
}

static bool is_stopped(const ask_batch *batch) { return batch->stopped && batch->stopped(); }

/* ---- the first way ---- */

static void load_call(const ask_batch *batch, const ask_call *call) {
    for (size_t i = 0; i < call->count; ++i) {
        size_t block = call->first + i / LANES;
        put_ray(&batch->closest[block].rays, i % LANES, &batch->rays[call->first * LANES + i]);
        put_ray(&batch->any[block], i % LANES, &batch->rays[call->first * LANES + i]);
    }
}

typedef struct first_way {
    const trace_tracer *tracer;
    ask_batch *batch;
    _Atomic uint64_t nanoseconds;
} first_way;

static void ask_calls(void *user, size_t begin, size_t end) {
    first_way *w = user;
    ask_batch *batch = w->batch;
    double spent = 0;
    for (size_t i = begin; i < end && !is_stopped(batch); ++i) {
        const ask_call *call = &batch->calls.items[i];
        load_call(batch, call);
        unsigned state = trace_thread_begin();
        double start = clock_thread_seconds();
        if (call->closest)
            trace_closest_fine(w->tracer, &batch->closest[call->first], &batch->fine[call->first],
                               call->count, call->coherence);
        spent += clock_thread_seconds() - start;
        if (call->any) trace_any(w->tracer, &batch->any[call->first], call->count, call->coherence);
        trace_thread_end(state);
    }
    w->nanoseconds += (uint64_t)(1e9 * spent);
}

uint64_t ask_all(const trace_tracer *tracer, ask_batch *batch, unsigned threads) {
    first_way w = {tracer, batch, 0};
    memset(batch->closest, 0, batch->blocks * sizeof *batch->closest);
    memset(batch->fine, 0, batch->blocks * sizeof *batch->fine);
    memset(batch->any, 0, batch->blocks * sizeof *batch->any);
    loop_parallel(threads, batch->calls.count, 1, ask_calls, &w);
    return w.nanoseconds;
}

/* ---- other ways ---- */

typedef struct way {
    const char *name;
    unsigned lanes;
    trace_coherence coherence;
    bool reversed;
} way;

/* Slow tracers use only the first way. */
#define SLOW_WAYS 1
static const way ways[] = {
    {"16-coherent", 16, TRACE_COHERENT, false},
    {"5", 5, TRACE_INCOHERENT, true},
    {"1", 1, TRACE_INCOHERENT, false},
    {"16", 16, TRACE_INCOHERENT, false},
    {"16-neighbours", 16, TRACE_NEIGHBOURS, true},
    {"11-coherent", 11, TRACE_COHERENT, false},
    {"8-coherent", 8, TRACE_COHERENT, true},
    {"8", 8, TRACE_INCOHERENT, false},
    {"4-coherent", 4, TRACE_COHERENT, false},
    {"4", 4, TRACE_INCOHERENT, true},
    {"1-coherent", 1, TRACE_COHERENT, false},
};

#define WAYS (sizeof ways / sizeof *ways)

const char *ask_way_name(unsigned w) { return w < WAYS ? ways[w].name : "given"; }

/* The lane of the block at this position in the calls of a way. */
static unsigned lane_at(const way *w, unsigned place, unsigned lanes) {
    return w->reversed ? lanes - 1 - place : place;
}

ask_block ask_block_of(const ask_batch *batch, size_t ray, unsigned w, bool any) {
    const size_t block = ray / LANES;
    const unsigned lanes = ask_lanes(batch, block);
    const way as_it_was = {"given", LANES, call_of(batch, block)->coherence, false};
    const way *how = w < WAYS ? &ways[w] : &as_it_was;
    unsigned place = lane_at(how, ray % LANES, lanes), begin = place / how->lanes * how->lanes;
    ask_block out = {.lane = place - begin, .coherence = how->coherence, .any = any};
    for (unsigned i = begin; i < lanes && i < begin + how->lanes; ++i)
        out.rays[out.lanes++] = batch->rays[block * LANES + lane_at(how, i, lanes)];
    return out;
}

static void make_call(const trace_tracer *tracer, const ask_block *b, bool closest, bool any,
                      ask_answer out[LANES]) {
    trace_block block;
    trace_fine fine;
    memset(&block, 0xff, sizeof block), memset(&fine, 0, sizeof fine);
    for (unsigned i = 0; i < b->lanes; ++i) put_ray(&block.rays, i, &b->rays[i]);
    trace_rays rays = block.rays;
    if (closest) trace_closest_fine(tracer, &block, &fine, b->lanes, b->coherence);
    if (any) trace_any(tracer, &rays, b->lanes, b->coherence);
    for (unsigned i = 0; i < b->lanes; ++i) {
        out[i] = ask_closest_of(&block, &fine, i);
        out[i].met = met_of(&rays, i);
    }
}

typedef struct other_ways {
    const trace_tracer *tracer;
    const ask_batch *batch;
    unsigned ways;
    pthread_mutex_t lock;
    ask_others *out;
    bool failed;
} other_ways;

static void keep(other_ways *o, size_t ray, unsigned w, bool any, const ask_answer *answer) {
    const ask_other other = {ray, w, any, *answer};
    pthread_mutex_lock(&o->lock);
    if (o->out->count < ASK_OTHERS_MOST) o->failed = !array_push(o->out, other) || o->failed;
    pthread_mutex_unlock(&o->lock);
}

/* Makes the call of the way that begins at this position of the block. */
static void ask_part(other_ways *o, size_t block, unsigned w, unsigned begin) {
    const ask_batch *batch = o->batch;
    const ask_call *call = call_of(batch, block);
    const unsigned lanes = ask_lanes(batch, block);
    const ask_block part = ask_block_of(batch, block * LANES + lane_at(&ways[w], begin, lanes), w, false);
    ask_answer now[LANES];
    make_call(o->tracer, &part, call->closest, call->any, now);
    for (unsigned i = 0; i < part.lanes; ++i) {
        const size_t ray = block * LANES + lane_at(&ways[w], begin + i, lanes);
        const ask_answer first = ask_answer_of(batch, ray);
        if (call->closest && !ask_same(&first, &now[i], false)) keep(o, ray, w, false, &now[i]);
        if (call->any && !ask_same(&first, &now[i], true)) keep(o, ray, w, true, &now[i]);
    }
}

/* Repeats the blocks several times: neighbours in the loop run at the same time. */
static void ask_block_ways(void *user, size_t begin, size_t end) {
    other_ways *o = user;
    unsigned state = trace_thread_begin();
    for (size_t i = begin; i < end; ++i) {
        size_t block = i % o->batch->blocks;
        unsigned lanes = ask_lanes(o->batch, block);
        for (unsigned w = 0; w < o->ways && !is_stopped(o->batch); ++w) {
            for (unsigned at = 0; at < lanes; at += ways[w].lanes) ask_part(o, block, w, at);
        }
    }
    trace_thread_end(state);
}

/* Equal results are ordered by their ways. */
static int by_answer(const void *a, const void *b) {
    const ask_other *x = a, *y = b;
    if (x->ray != y->ray) return x->ray < y->ray ? -1 : 1;
    if (x->any != y->any) return x->any ? 1 : -1;
    const verdict_answer *h = &x->answer.hit, *k = &y->answer.hit;
    int order = memcmp(&h->geometry, &k->geometry, 3 * sizeof h->geometry);
    if (!order) order = memcmp(&h->t, &k->t, sizeof h->t);
    if (!order) order = memcmp(&x->answer.u, &y->answer.u, 2 * sizeof x->answer.u);
    return order ? order : (int)x->way - (int)y->way;
}

static void drop_repeats(ask_others *others) {
    if (!others->count) return;
    qsort(others->items, others->count, sizeof *others->items, by_answer);
    size_t kept = 1;
    for (size_t i = 1; i < others->count; ++i) {
        const ask_other *a = &others->items[kept - 1], *b = &others->items[i];
        if (a->ray != b->ray || a->any != b->any || !ask_same(&a->answer, &b->answer, a->any))
            others->items[kept++] = *b;
    }
    others->count = kept;
}

/* Minimum number of blocks for which threads overlap in the tracer; fewer blocks are repeated. */
#define BLOCKS_LEAST 16

bool ask_others_find(const trace_tracer *tracer, const ask_batch *batch, unsigned threads, bool once,
                     ask_others *out) {
    bool slow = trace_piece(tracer) <= LANES;
    once = once || slow || batch->blocks == 0 || batch->blocks >= BLOCKS_LEAST;
    other_ways o = {tracer, batch, slow ? SLOW_WAYS : WAYS, PTHREAD_MUTEX_INITIALIZER, out, false};
    size_t rounds = once ? 1 : BLOCKS_LEAST / batch->blocks;
    loop_parallel(threads, rounds * batch->blocks, 1, ask_block_ways, &o);
    drop_repeats(out);
    return !o.failed;
}

ask_answer ask_block_again(const trace_tracer *tracer, const ask_block *block) {
    ask_answer answers[LANES];
    unsigned state = trace_thread_begin();
    make_call(tracer, block, true, true, answers);
    trace_thread_end(state);
    return answers[block->lane];
}
