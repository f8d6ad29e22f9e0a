#include "verify/compare_inner.h"

#include "base/clock.h"
#include "base/threads.h"
#include "verify/recorded.h"

#include <stdlib.h>
#include <string.h>

/* Rays per batch, between two reports of progress: chosen to take about a tenth of a second. */
#define BATCH_LEAST 1024
#define BATCH_MOST 16384
#define BATCH_SECONDS 0.1

static uint64_t index_of(const comparison *c, size_t ray) { return c->first + ray; }

/* ---- checking ---- */

static bool is_failure(verdict v) { return v == VERDICT_WRONG || v == VERDICT_LEAK; }

static void keep_failure(compare_worker *w, const comparison *c, size_t ray, unsigned way, bool any,
                         verdict v, const ask_answer *answer) {
    if (!c->options->failures) return;
    compare_failure failure = {c->family, index_of(c, ray), v, way, ask_block_of(&c->batch, ray, way, any),
                               *answer};
    if (!array_push(&w->failures, failure)) w->failed = true;
}

/* Checks u, v and the normal of a hit with a correct t. */
static verdict judge_details(const compare_subject *s, const oracle_ray *ray, const ask_answer *a,
                             verdict_report *report, error_report *errors) {
    const error_said said = {.t = a->hit.t, .normal = a->normal, .u = a->u, .v = a->v};
    error_measure(ray, &report->primitive, &report->exact, &said, errors);
    verdict_bound bound = verdict_bound_all(&s->precision, ray, &report->primitive, &report->exact);
    report->bound = bound.t;
    bool uv = errors->uv * 0x1p-24 > bound.weight, normal = errors->normal * 0x1p-24 > bound.normal;
    bool none = isnan(a->u) || isnan(a->v) || (!finite_f32(a->normal) && isfinite(bound.normal));
    return uv || normal || none ? VERDICT_WRONG : report->verdict;
}

bool compare_judge(const compare_subject *s, const oracle_ray *ray, const ask_answer *answer, bool any,
                   search_result *room, verdict_report *out, error_report *errors) {
    *out = (verdict_report){.measured = false};
    if (any)
        return verdict_any(s->search, s->world, &s->precision, ray, answer->met, &answer->hit, room,
                           &out->verdict);
    if (!verdict_closest(s->search, s->world, &s->precision, ray, &answer->hit, room, out)) return false;
    out->measured = out->measured && !is_failure(out->verdict) && out->verdict != VERDICT_BEYOND;
    if (out->measured) out->verdict = judge_details(s, ray, answer, out, errors);
    return true;
}

static bool judge(const comparison *c, compare_worker *w, size_t ray, const ask_answer *answer, bool any,
                  verdict_report *report, error_report *errors) {
    const oracle_ray *r = &c->batch.rays[ray];
    if (!compare_judge(c->subject, r, answer, any, &w->room, report, errors)) w->failed = true;
    return !w->failed;
}

static void judge_first(const comparison *c, compare_worker *w, size_t ray, bool any) {
    const ask_answer answer = ask_answer_of(&c->batch, ray);
    verdict_report report;
    error_report errors = {.uv = -1};
    if (!judge(c, w, ray, &answer, any, &report, &errors)) return;
    if (any)
        ++w->family.any_rays, ++w->family.any_counts[report.verdict];
    else
        ++w->family.rays, ++w->family.counts[report.verdict];
    if (is_failure(report.verdict))
        keep_failure(w, c, ray, COMPARE_FIRST, any, report.verdict, &answer);
    else if (report.measured)
        compare_family_measure(&w->family, &c->batch.rays[ray], index_of(c, ray), &report, &errors,
                               c->subject->precision.unit, c->subject->source->radius);
}

void compare_judge_other(const comparison *c, compare_worker *w, const ask_other *other) {
    verdict_report report;
    error_report errors;
    if (!judge(c, w, other->ray, &other->answer, other->any, &report, &errors)) return;
    w->family.repaired += other->way == ASK_REPAIRED;
    ++w->family.others, ++w->family.other_counts[report.verdict];
    if (is_failure(report.verdict))
        keep_failure(w, c, other->ray, other->way, other->any, report.verdict, &other->answer);
}

/* Compares the exact search by the sphere tree with the search over all primitives: the ties must be
 * equal. */
static void check_search(const comparison *c, compare_worker *w, const oracle_ray *ray) {
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

/* Compares the render's result with the repeated call. */
static void judge_given(const comparison *c, compare_worker *w, size_t ray, bool any) {
    const ask_answer first = ask_answer_of(&c->batch, ray);
    const ask_other other = {ray, ASK_GIVEN, any, c->given[ray]};
    if (!ask_alike(&first, &other.answer, any)) compare_judge_other(c, w, &other);
}

static void judge_blocks(void *user, size_t begin, size_t end, unsigned index) {
    const comparison *c = user;
    compare_worker *w = &c->workers[index];
    for (size_t block = begin; block < end; ++block) {
        const ask_call *call = &c->batch.calls.items[c->batch.call_of[block]];
        unsigned lanes = ask_lanes(&c->batch, block);
        for (unsigned i = 0; i < lanes && !w->failed; ++i) {
            size_t ray = block * LANES + i;
            if (call->closest) judge_first(c, w, ray, false);
            if (call->any) judge_first(c, w, ray, true);
            if (c->given) judge_given(c, w, ray, call->any);
            if (index_of(c, ray) < c->options->sample) check_search(c, w, &c->batch.rays[ray]);
        }
    }
}

static void judge_others(void *user, size_t begin, size_t end, unsigned index) {
    const comparison *c = user;
    for (size_t i = begin; i < end && !c->workers[index].failed; ++i)
        compare_judge_other(c, &c->workers[index], &c->others.items[i]);
}

/* ---- joining the threads' results ---- */

static int by_index(const void *a, const void *b) {
    const compare_failure *x = a, *y = b;
    if (x->index != y->index) return x->index < y->index ? -1 : 1;
    if (x->block.any != y->block.any) return (int)x->block.any - (int)y->block.any;
    return x->way == y->way ? 0 : x->way < y->way ? -1 : 1;
}

/* Batches come in order, so sorting each one sorts the whole list. */
static bool join_failures(const comparison *c, compare_result *out, size_t family_begin) {
    size_t begin = out->failures.count;
    for (unsigned i = 0; i < c->options->threads; ++i) {
        compare_worker *w = &c->workers[i];
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

fathom_status compare_join_workers(fathom_context *context, const comparison *c, compare_result *out,
                                   size_t family_begin) {
    bool fine = join_failures(c, out, family_begin);
    for (unsigned i = 0; i < c->options->threads; ++i) {
        compare_worker *w = &c->workers[i];
        fine = fine && !w->failed;
        out->sampled += w->sampled, out->differ += w->differ;
        out->screened += w->screened, out->unequal += w->unequal;
        w->sampled = w->differ = w->screened = w->unequal = 0;
        compare_family_join(&out->families[c->family], &w->family);
        memset(&w->family, 0, sizeof w->family);
    }
    return fine ? FATHOM_OK : fail_memory(context, sizeof(compare_failure));
}

/* ---- a batch ---- */

/* Makes intervals that end exactly at the hit: at the tracer's t rounded down or up, and one ulp beyond. */
static void end_in_hits(const comparison *c) {
    for (size_t ray = 0; ray < c->batch.blocks * LANES; ++ray) {
        if (ray % LANES >= ask_lanes(&c->batch, ray / LANES)) continue;
        const ask_answer a = ask_answer_of(&c->batch, ray);
        oracle_ray *r = &c->batch.rays[ray], ended = *r;
        float t = (float)a.hit.t;
        if (a.hit.geometry == FATHOM_NONE || !isfinite(t)) continue;
        float low = (double)t > a.hit.t ? nextafterf(t, 0) : t,
              high = (double)t < a.hit.t ? nextafterf(t, INFINITY) : t;
        switch (ray / 4 % 4) {
        case 0: ended.t_far = rays_normal((double)low); break;
        case 1: ended.t_near = rays_normal((double)high); break;
        case 2: ended.t_far = rays_normal((double)nextafterf(high, INFINITY)); break;
        default: ended.t_near = rays_normal((double)nextafterf(low, 0)); break;
        }
        if (rays_allowed(c->subject->source, &ended)) *r = ended;
    }
}

/* Adds this batch's results from a render's repair to `others`, to be checked with them. */
static bool add_repaired(comparison *c) {
    const recorded *r = c->options->rendered;
    for (size_t i = 0; c->given && i < r->repaired.count; ++i) {
        ask_other other = r->repaired.items[i];
        if (other.ray < c->first || other.ray - c->first >= c->batch.blocks * LANES) continue;
        other.ray -= c->first;
        if (!array_push(&c->others, other)) return false;
    }
    return true;
}

static fathom_status judge_batch(fathom_context *context, comparison *c, uint64_t done, compare_result *out,
                                 size_t family_begin) {
    const compare_options *o = c->options;
    const trace_tracer *tracer = c->subject->tracer;
    out->nanoseconds += ask_all(tracer, &c->batch, o->threads);
    if (c->family == RAYS_ENDS) {
        end_in_hits(c);
        out->nanoseconds += ask_all(tracer, &c->batch, o->threads);
    }
    c->others.count = 0;
    if (!ask_others_find(tracer, &c->batch, o->threads, o->once, &c->others) || !add_repaired(c))
        return fail_memory(context, sizeof(ask_other));
    if (o->stopped && o->stopped()) return compare_tell(context, o, done); /* answers may be missing */
    loop_workers(o->threads, c->batch.blocks, 2, judge_blocks, c);
    loop_workers(o->threads, c->others.count, 1, judge_others, c);
    for (size_t i = 0; i < c->batch.calls.count; ++i)
        out->rays += c->batch.calls.items[i].closest ? c->batch.calls.items[i].count : 0;
    return compare_join_workers(context, c, out, family_begin);
}

void compare_make_rays(void *user, size_t begin, size_t end) {
    const comparison *c = user;
    for (size_t i = begin; i < end; ++i)
        c->batch.rays[i] = rays_make(c->subject->source, c->family, c->options->seed, c->first + i);
}

static bool fill_batch(comparison *c, size_t count) {
    if (!ask_batch_clear(&c->batch, (count + LANES - 1) / LANES)) return false;
    for (size_t at = 0; at < count; at += COMPARE_CALL) {
        if (!ask_batch_add(&c->batch, count - at < COMPARE_CALL ? count - at : COMPARE_CALL, TRACE_INCOHERENT,
                           true, true))
            return false;
    }
    loop_parallel(c->options->threads, count, 64, compare_make_rays, c);
    return true;
}

/* Results do not depend on the batch size. */
static uint64_t next_batch(uint64_t batch, double seconds) {
    if (seconds < BATCH_SECONDS / 2 && batch < BATCH_MOST) return 2 * batch;
    return seconds > 2 * BATCH_SECONDS && batch > BATCH_LEAST ? batch / 2 : batch;
}

fathom_status compare_tell(fathom_context *context, const compare_options *o, uint64_t done) {
    if (!o->progress || o->progress(o->user, done)) return FATHOM_OK;
    return fail(context, FATHOM_INTERRUPTED, "validation stopped after %llu rays", (unsigned long long)done);
}

static fathom_status run_family(fathom_context *context, comparison *c, uint64_t *done, compare_result *out) {
    const compare_options *o = c->options;
    const size_t family_begin = out->failures.count;
    fathom_status status = FATHOM_OK;
    uint64_t batch = BATCH_LEAST;
    for (c->first = 0; c->first < o->rays && status == FATHOM_OK;) {
        uint64_t left = o->rays - c->first, count = left < batch ? left : batch;
        double start = clock_seconds();
        if (!fill_batch(c, (size_t)count)) return fail_memory(context, (size_t)count * sizeof(oracle_ray));
        status = judge_batch(context, c, *done, out, family_begin);
        batch = next_batch(batch, clock_seconds() - start);
        c->first += count, *done += count;
        if (status == FATHOM_OK) status = compare_tell(context, o, *done);
    }
    return status;
}

/* ---- a render's rays ---- */

static bool fill_recorded(comparison *c, const recorded *r, size_t *call, size_t *first) {
    size_t blocks = 0, end = *call;
    *first = r->calls.items[*call].first;
    for (; end < r->calls.count && (end == *call || blocks * LANES < BATCH_MOST); ++end)
        blocks += (r->calls.items[end].count + LANES - 1) / LANES;
    if (!ask_batch_clear(&c->batch, blocks)) return false;
    for (; *call < end; ++*call) {
        const recorded_call *from = &r->calls.items[*call];
        if (!ask_batch_add(&c->batch, from->count, from->coherence, !from->any, from->any)) return false;
    }
    memcpy(c->batch.rays, &r->rays.items[*first * LANES], blocks * LANES * sizeof *c->batch.rays);
    return true;
}

static fathom_status run_recorded(fathom_context *context, comparison *c, uint64_t done,
                                  compare_result *out) {
    const recorded *r = c->options->rendered;
    const size_t family_begin = out->failures.count;
    fathom_status status = FATHOM_OK;
    c->family = RAYS_RENDERED;
    for (size_t call = 0, first; call < r->calls.count && status == FATHOM_OK;) {
        if (!fill_recorded(c, r, &call, &first)) return fail_memory(context, sizeof(oracle_ray));
        c->first = first * LANES, c->given = &r->answers.items[first * LANES];
        status = judge_batch(context, c, done, out, family_begin);
        if (status == FATHOM_OK) status = compare_tell(context, c->options, done);
    }
    c->given = NULL;
    return status;
}

static void free_comparison(comparison *c) {
    for (unsigned i = 0; c->workers && i < c->options->threads; ++i) {
        search_result_free(&c->workers[i].room);
        search_result_free(&c->workers[i].linear);
        ask_batch_free(&c->workers[i].batch);
        array_free(&c->workers[i].failures);
    }
    free(c->workers);
    ask_batch_free(&c->batch);
    array_free(&c->others);
}

fathom_status compare_run(fathom_context *context, const compare_subject *subject,
                          const compare_options *options, compare_result *out) {
    comparison c = {.subject = subject, .options = options, .batch.stopped = options->stopped};
    c.workers = calloc(options->threads, sizeof *c.workers);
    fathom_status status = c.workers ? FATHOM_OK : fail_memory(context, options->threads * sizeof *c.workers);
    uint64_t done = 0;
    for (int f = 0; f < RAYS_RENDERED && status == FATHOM_OK; ++f) {
        c.family = (rays_family)f;
        if (options->families >> f & 1) status = run_family(context, &c, &done, out);
    }
    if (status == FATHOM_OK && options->rendered) status = run_recorded(context, &c, done, out);
    if (status == FATHOM_OK && options->second) status = compare_screen(context, &c, done, out);
    free_comparison(&c);
    return status;
}

void compare_result_free(compare_result *result) {
    array_free(&result->failures);
    memset(result, 0, sizeof *result);
}
