#include "verify/compare.h"
#include "base/clock.h"
#include "base/threads.h"
#include "verify/error.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#define BLOCKS 16              /* traced in one go, which is timed */
#define PIECE (BLOCKS * LANES) /* rays that a thread takes at once */
/* Rays between two reports of progress: as many as take about a tenth of a second. */
#define BATCH_LEAST 1024
#define BATCH_MOST 65536
#define BATCH_SECONDS 0.1

/* One thread's counts. */
typedef struct worker {
    search_result room;
    compare_family family;
    ARRAY(compare_failure) failures;
    search_result linear; /* of the sample */
    uint64_t nanoseconds, sampled, differ;
    bool failed; /* out of memory */
} worker;

typedef struct comparison {
    const compare_subject *subject;
    const compare_options *options;
    rays_family family;
    uint64_t first; /* of the batch */
    worker *workers;
} comparison;

/* ---- asking the tracer ---- */

/* Some rays, and what the tracer says to each. */
typedef struct inquiry {
    oracle_ray rays[PIECE];
    trace_block blocks[BLOCKS];
    trace_rays any[BLOCKS];
    trace_fine fine[BLOCKS];
    unsigned count;
} inquiry;

static void put_ray(trace_block *block, unsigned lane, const oracle_ray *ray) {
    trace_rays *r = &block->rays;
    r->org_x[lane] = ray->org.x, r->org_y[lane] = ray->org.y, r->org_z[lane] = ray->org.z;
    r->dir_x[lane] = ray->dir.x, r->dir_y[lane] = ray->dir.y, r->dir_z[lane] = ray->dir.z;
    r->t_near[lane] = ray->t_near, r->t_far[lane] = ray->t_far;
}

static verdict_answer answer_of(const inquiry *q, unsigned i) {
    const trace_hits *hits = &q->blocks[i / LANES].hits;
    unsigned lane = i % LANES;
    return (verdict_answer){hits->geometry[lane], hits->primitive[lane], hits->instance[lane],
                            q->fine[i / LANES].t[lane], q->fine[i / LANES].t_low[lane]};
}

static bool any_of(const inquiry *q, unsigned i) { return q->any[i / LANES].t_far[i % LANES] == -INFINITY; }

/* Processor time of this thread alone. */
static uint64_t thread_nanoseconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

/* Returns the nanoseconds that closest hits took. */
static uint64_t ask_tracer(const trace_tracer *tracer, inquiry *q) {
    memset(q->blocks, 0, sizeof q->blocks);
    memset(q->fine, 0, sizeof q->fine);
    for (unsigned i = 0; i < q->count; ++i) put_ray(&q->blocks[i / LANES], i % LANES, &q->rays[i]);
    for (unsigned b = 0; b < BLOCKS; ++b) q->any[b] = q->blocks[b].rays;
    unsigned state = trace_thread_begin();
    uint64_t start = thread_nanoseconds();
    trace_closest_fine(tracer, q->blocks, q->fine, q->count, TRACE_INCOHERENT);
    uint64_t end = thread_nanoseconds();
    trace_any(tracer, q->any, q->count, TRACE_INCOHERENT);
    trace_thread_end(state);
    return end - start;
}

/* ---- counting ---- */

static void keep_most(compare_most *most, double value, uint64_t index, const oracle_ray *ray) {
    if (value > most->value || (value == most->value && value > 0 && index < most->index))
        *most = (compare_most){value, index, *ray};
}

static void add_error(compare_error *e, double value, uint64_t index, const oracle_ray *ray) {
    histogram_add(&e->counts, value);
    keep_most(&e->most, value, index, ray);
}

static void measure(compare_family *f, const compare_subject *s, const inquiry *q, unsigned i,
                    const verdict_report *report, uint64_t index) {
    const oracle_ray *ray = &q->rays[i];
    const trace_hits *hits = &q->blocks[i / LANES].hits;
    const trace_fine *fine = &q->fine[i / LANES];
    unsigned lane = i % LANES;
    error_said said = {.t = fine->t[lane],
                       .normal = {hits->ng_x[lane], hits->ng_y[lane], hits->ng_z[lane]},
                       .u = fine->u[lane],
                       .v = fine->v[lane]};
    error_report errors;
    error_measure(ray, &report->primitive, &report->exact, &said, &errors);
    double relative = report->t_error * length_f64(widen(ray->dir)) / rays_world_radius(s->source);
    add_error(&f->errors[COMPARE_T_ULPS], report->t_error / error_ulp(report->exact_t), index, ray);
    add_error(&f->errors[COMPARE_T_RELATIVE], relative, index, ray);
    add_error(&f->errors[COMPARE_POSITION], errors.position, index, ray);
    add_error(&f->errors[COMPARE_NORMAL], errors.normal, index, ray);
    if (errors.uv >= 0) add_error(&f->errors[COMPARE_UV], errors.uv, index, ray);
    if (report->condition > 0)
        keep_most(&f->constant, report->t_error / (s->precision.unit * report->condition), index, ray);
}

static bool is_failure(verdict v) { return v == VERDICT_WRONG || v == VERDICT_LEAK; }

static void keep_failure(worker *w, const comparison *c, compare_failure failure) {
    failure.family = c->family;
    if (c->options->failures && !array_push(&w->failures, failure)) w->failed = true;
}

/* ---- a piece ---- */

static void judge_closest(const comparison *c, worker *w, const inquiry *q, unsigned i, uint64_t index) {
    const compare_subject *s = c->subject;
    verdict_answer answer = answer_of(q, i);
    verdict_report report;
    if (!verdict_closest(s->search, s->world, &s->precision, &q->rays[i], &answer, &w->room, &report)) {
        w->failed = true;
        return;
    }
    ++w->family.rays, ++w->family.counts[report.verdict];
    if (is_failure(report.verdict)) {
        compare_failure failure = {
            .index = index, .ray = q->rays[i], .verdict = report.verdict, .answer = answer};
        keep_failure(w, c, failure);
    } else if (report.measured) {
        measure(&w->family, s, q, i, &report, index);
    }
}

/* The exact answer by the tree of spheres against that by every primitive: the same ties. */
static void check_search(const comparison *c, worker *w, const oracle_ray *ray) {
    const search *s = c->subject->search;
    if (!search_closest(s, ray, &w->room) || !search_exhaustive(s, ray, &w->linear)) {
        w->failed = true;
        return;
    }
    bool same = w->room.ties.count == w->linear.ties.count;
    for (size_t i = 0; same && i < w->room.ties.count; ++i) {
        const search_hit *a = &w->room.ties.items[i], *b = &w->linear.ties.items[i];
        same = a->geometry == b->geometry && a->primitive == b->primitive && a->instance == b->instance;
    }
    ++w->sampled, w->differ += !same;
}

static void judge_any(const comparison *c, worker *w, const inquiry *q, unsigned i, uint64_t index) {
    const compare_subject *s = c->subject;
    bool met = any_of(q, i);
    verdict_answer closest = answer_of(q, i);
    verdict v;
    if (!verdict_any(s->search, s->world, &s->precision, &q->rays[i], met, &closest, &w->room, &v)) {
        w->failed = true;
        return;
    }
    ++w->family.any_rays, ++w->family.any_counts[v];
    if (!is_failure(v)) return;
    compare_failure failure = {.index = index, .ray = q->rays[i], .verdict = v, .any = true};
    failure.answer.geometry = met ? 0 : FATHOM_NONE;
    keep_failure(w, c, failure);
}

static void compare_piece(void *user, size_t begin, size_t end, unsigned index) {
    const comparison *c = user;
    worker *w = &c->workers[index];
    inquiry q;
    for (size_t at = begin; at < end; at += PIECE) {
        q.count = end - at < PIECE ? (unsigned)(end - at) : PIECE;
        for (unsigned i = 0; i < q.count; ++i)
            q.rays[i] = rays_make(c->subject->source, c->family, c->options->seed, c->first + at + i);
        w->nanoseconds += ask_tracer(c->subject->tracer, &q);
        for (unsigned i = 0; i < q.count && !w->failed; ++i) {
            judge_closest(c, w, &q, i, c->first + at + i);
            judge_any(c, w, &q, i, c->first + at + i);
            if (c->first + at + i < c->options->sample) check_search(c, w, &q.rays[i]);
        }
    }
}

static void ask_one(const compare_subject *s, const oracle_ray *ray, inquiry *q) {
    q->count = 1;
    q->rays[0] = *ray;
    (void)ask_tracer(s->tracer, q);
}

bool compare_one(const compare_subject *s, const oracle_ray *ray, verdict_answer *answer,
                 verdict_report *out) {
    inquiry q;
    ask_one(s, ray, &q);
    *answer = answer_of(&q, 0);
    search_result room = {.asked = 0};
    bool judged = verdict_closest(s->search, s->world, &s->precision, ray, answer, &room, out);
    search_result_free(&room);
    return judged;
}

bool compare_one_any(const compare_subject *s, const oracle_ray *ray, bool *met, verdict *out) {
    inquiry q;
    ask_one(s, ray, &q);
    *met = any_of(&q, 0);
    verdict_answer closest = answer_of(&q, 0);
    search_result room = {.asked = 0};
    bool judged = verdict_any(s->search, s->world, &s->precision, ray, *met, &closest, &room, out);
    search_result_free(&room);
    return judged;
}

/* ---- joining what the threads have ---- */

void compare_family_join(compare_family *to, const compare_family *from) {
    to->rays += from->rays, to->any_rays += from->any_rays;
    for (int i = 0; i < VERDICT_COUNT; ++i) {
        to->counts[i] += from->counts[i];
        to->any_counts[i] += from->any_counts[i];
    }
    for (int i = 0; i < COMPARE_MEASURES; ++i) {
        const compare_error *e = &from->errors[i];
        histogram_join(&to->errors[i].counts, &e->counts);
        keep_most(&to->errors[i].most, e->most.value, e->most.index, &e->most.ray);
    }
    keep_most(&to->constant, from->constant.value, from->constant.index, &from->constant.ray);
    to->asked += from->asked, to->exact += from->exact;
}

static int by_index(const void *a, const void *b) {
    const compare_failure *x = a, *y = b;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    return (int)x->any - (int)y->any;
}

/* Batches follow each other, so sorting each by itself sorts all. */
static bool join_failures(const comparison *c, compare_result *out, size_t family_begin) {
    size_t begin = out->failures.count;
    for (unsigned i = 0; i < c->options->threads; ++i) {
        worker *w = &c->workers[i];
        for (size_t k = 0; k < w->failures.count; ++k) {
            if (!array_push(&out->failures, w->failures.items[k])) return false;
        }
        w->failures.count = 0;
    }
    if (out->failures.count > begin)
        qsort(out->failures.items + begin, out->failures.count - begin, sizeof *out->failures.items,
              by_index);
    size_t kept = out->failures.count - family_begin;
    if (kept > c->options->failures) out->failures.count = family_begin + c->options->failures;
    return true;
}

static bool join_workers(const comparison *c, compare_result *out, size_t family_begin) {
    bool fine = join_failures(c, out, family_begin);
    for (unsigned i = 0; i < c->options->threads; ++i) {
        worker *w = &c->workers[i];
        fine = fine && !w->failed;
        w->family.asked = w->room.asked, w->family.exact = w->room.exact;
        w->room.asked = w->room.exact = 0;
        out->nanoseconds += w->nanoseconds, out->rays += w->family.rays;
        out->sampled += w->sampled, out->differ += w->differ;
        w->nanoseconds = w->sampled = w->differ = 0;
        compare_family_join(&out->families[c->family], &w->family);
        memset(&w->family, 0, sizeof w->family);
    }
    return fine;
}

/* No result depends on how many go at once. */
static uint64_t next_batch(uint64_t batch, double seconds) {
    if (seconds < BATCH_SECONDS / 2 && batch < BATCH_MOST) return 2 * batch;
    return seconds > 2 * BATCH_SECONDS && batch > BATCH_LEAST ? batch / 2 : batch;
}

static fathom_status run_family(fathom_context *context, comparison *c, uint64_t *done, compare_result *out) {
    const compare_options *o = c->options;
    size_t family_begin = out->failures.count;
    uint64_t batch = BATCH_LEAST;
    for (c->first = 0; c->first < o->rays;) {
        uint64_t left = o->rays - c->first, count = left < batch ? left : batch;
        double start = clock_seconds();
        loop_parallel(o->threads, (size_t)count, PIECE, compare_piece, c);
        if (!join_workers(c, out, family_begin)) return fail_memory(context, sizeof(compare_failure));
        batch = next_batch(batch, clock_seconds() - start);
        c->first += count, *done += count;
        if (o->progress && !o->progress(o->user, *done))
            return fail(context, FATHOM_INTERRUPTED, "validation stopped after %llu rays",
                        (unsigned long long)*done);
    }
    return FATHOM_OK;
}

fathom_status compare_run(fathom_context *context, const compare_subject *subject,
                          const compare_options *options, compare_result *out) {
    comparison c = {.subject = subject, .options = options};
    c.workers = calloc(options->threads, sizeof *c.workers);
    if (!c.workers) return fail_memory(context, options->threads * sizeof *c.workers);
    fathom_status status = FATHOM_OK;
    uint64_t done = 0;
    for (int f = 0; f < RAYS_FAMILIES && status == FATHOM_OK; ++f) {
        c.family = (rays_family)f;
        if (options->families >> f & 1) status = run_family(context, &c, &done, out);
    }
    for (unsigned i = 0; i < options->threads; ++i) {
        search_result_free(&c.workers[i].room);
        search_result_free(&c.workers[i].linear);
        array_free(&c.workers[i].failures);
    }
    free(c.workers);
    return status;
}

void compare_result_free(compare_result *result) {
    array_free(&result->failures);
    memset(result, 0, sizeof *result);
}
