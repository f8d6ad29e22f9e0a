#include "parity/compare.h"
#include "base/threads.h"

#include <stdlib.h>
#include <string.h>

#define PIECE 256   /* rays that a thread takes at once */
#define BATCH 16384 /* rays between two reports of progress */

/* What one thread has counted. */
typedef struct worker {
    search_result room;
    compare_family family;
    ARRAY(compare_failure) failures;
    bool failed; /* out of memory */
} worker;

typedef struct comparison {
    const compare_subject *subject;
    const compare_options *options;
    rays_family family;
    uint64_t first; /* of the batch */
    worker *workers;
} comparison;

/* ---- one block ---- */

static void put_ray(trace_block *block, unsigned lane, const oracle_ray *ray) {
    trace_rays *r = &block->rays;
    r->org_x[lane] = ray->org.x, r->org_y[lane] = ray->org.y, r->org_z[lane] = ray->org.z;
    r->dir_x[lane] = ray->dir.x, r->dir_y[lane] = ray->dir.y, r->dir_z[lane] = ray->dir.z;
    r->t_near[lane] = ray->t_near, r->t_far[lane] = ray->t_far;
}

static verdict_answer answer_of(const trace_block *block, const trace_fine *fine, unsigned lane) {
    return (verdict_answer){block->hits.geometry[lane], block->hits.primitive[lane],
                            block->hits.instance[lane], fine->t[lane]};
}

static void trace_rays_of(const trace_tracer *tracer, trace_block *block, trace_fine *fine,
                          const oracle_ray *rays, unsigned count) {
    memset(block, 0, sizeof *block);
    memset(fine, 0, sizeof *fine);
    for (unsigned i = 0; i < count; ++i) put_ray(block, i, &rays[i]);
    unsigned state = trace_thread_begin();
    trace_closest_fine(tracer, block, fine, count, TRACE_INCOHERENT);
    trace_thread_end(state);
}

/* ---- counting ---- */

static void keep_most(compare_most *most, double value, uint64_t index, const oracle_ray *ray) {
    if (value > most->value || (value == most->value && value > 0 && index < most->index))
        *most = (compare_most){value, index, *ray};
}

/* The distance between floats around x. */
static double ulp_of(double x) {
    int exponent;
    (void)frexp(x, &exponent);
    return ldexp(1, exponent - 24 < -149 ? -149 : exponent - 24);
}

static void measure(compare_family *f, const compare_subject *s, const verdict_report *report, uint64_t index,
                    const oracle_ray *ray) {
    double ulps = report->t_error / ulp_of(report->exact_t);
    double relative = report->t_error * length_f64(widen(ray->dir)) / rays_world_radius(s->source);
    histogram_add(&f->ulps, ulps);
    histogram_add(&f->relative, relative);
    keep_most(&f->most_ulps, ulps, index, ray);
    keep_most(&f->most_relative, relative, index, ray);
    if (report->condition > 0)
        keep_most(&f->constant, report->t_error / (s->precision.unit * report->condition), index, ray);
}

static void count(worker *w, const comparison *c, uint64_t index, const oracle_ray *ray,
                  const verdict_answer *answer, const verdict_report *report) {
    ++w->family.rays;
    ++w->family.counts[report->verdict];
    if (report->verdict == VERDICT_WRONG || report->verdict == VERDICT_LEAK) {
        compare_failure failure = {c->family, index, *ray, report->verdict, *answer};
        if (c->options->failures && !array_push(&w->failures, failure)) w->failed = true;
    } else if (report->measured) {
        measure(&w->family, c->subject, report, index, ray);
    }
}

static void compare_block(const comparison *c, worker *w, uint64_t first, unsigned lanes) {
    const compare_subject *s = c->subject;
    oracle_ray rays[TRACE_WIDTH] = {{.t_near = 0}};
    trace_block block;
    trace_fine fine;
    for (unsigned i = 0; i < lanes; ++i)
        rays[i] = rays_make(s->source, c->family, c->options->seed, first + i);
    trace_rays_of(s->tracer, &block, &fine, rays, lanes);
    for (unsigned i = 0; i < lanes; ++i) {
        verdict_answer answer = answer_of(&block, &fine, i);
        verdict_report report;
        if (!verdict_closest(s->search, s->world, &s->precision, &rays[i], &answer, &w->room, &report)) {
            w->failed = true;
            return;
        }
        count(w, c, first + i, &rays[i], &answer, &report);
    }
}

static void compare_piece(void *user, size_t begin, size_t end, unsigned index) {
    const comparison *c = user;
    worker *w = &c->workers[index];
    for (size_t i = begin; i < end && !w->failed; i += TRACE_WIDTH) {
        unsigned lanes = end - i < TRACE_WIDTH ? (unsigned)(end - i) : TRACE_WIDTH;
        compare_block(c, w, c->first + i, lanes);
    }
}

bool compare_one(const compare_subject *s, const oracle_ray *ray, verdict_answer *answer,
                 verdict_report *out) {
    trace_block block;
    trace_fine fine;
    trace_rays_of(s->tracer, &block, &fine, ray, 1);
    *answer = answer_of(&block, &fine, 0);
    search_result room = {.asked = 0};
    bool judged = verdict_closest(s->search, s->world, &s->precision, ray, answer, &room, out);
    search_result_free(&room);
    return judged;
}

/* ---- joining what the threads have ---- */

void compare_family_join(compare_family *to, const compare_family *from) {
    to->rays += from->rays;
    for (int i = 0; i < VERDICT_COUNT; ++i) to->counts[i] += from->counts[i];
    histogram_join(&to->ulps, &from->ulps);
    histogram_join(&to->relative, &from->relative);
    keep_most(&to->most_ulps, from->most_ulps.value, from->most_ulps.index, &from->most_ulps.ray);
    keep_most(&to->most_relative, from->most_relative.value, from->most_relative.index,
              &from->most_relative.ray);
    keep_most(&to->constant, from->constant.value, from->constant.index, &from->constant.ray);
    to->asked += from->asked, to->exact += from->exact;
}

static int by_index(const void *a, const void *b) {
    uint64_t x = ((const compare_failure *)a)->index, y = ((const compare_failure *)b)->index;
    return (x > y) - (x < y);
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
        compare_family_join(&out->families[c->family], &w->family);
        memset(&w->family, 0, sizeof w->family);
    }
    return fine;
}

static fathom_status run_family(fathom_context *context, comparison *c, uint64_t *done, compare_result *out) {
    const compare_options *o = c->options;
    size_t family_begin = out->failures.count;
    for (c->first = 0; c->first < o->rays; c->first += BATCH) {
        uint64_t left = o->rays - c->first, batch = left < BATCH ? left : BATCH;
        loop_parallel(o->threads, (size_t)batch, PIECE, compare_piece, c);
        if (!join_workers(c, out, family_begin)) return fail_memory(context, sizeof(compare_failure));
        *done += batch;
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
        array_free(&c.workers[i].failures);
    }
    free(c.workers);
    return status;
}

void compare_result_free(compare_result *result) {
    array_free(&result->failures);
    memset(result, 0, sizeof *result);
}
