#include "verify/laws/laws.h"

#include "base/clock.h"
#include "base/status.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const law *const lists[] = {laws_of_enclosures, laws_of_lights, laws_of_matter, laws_of_layers,
                                   laws_of_motion};

/* The i-th of the selected laws; NULL past the last. */
static const law *law_at(const laws_options *o, size_t i) {
    for (size_t list = 0; list < sizeof lists / sizeof *lists; ++list) {
        for (const law *l = lists[list]; l->name; ++l) {
            if (o->only && !strstr(l->name, o->only)) continue;
            if (i-- == 0) return l;
        }
    }
    return NULL;
}

const char *laws_verdict_name(laws_verdict v) {
    static const char *const names[LAWS_VERDICTS] = {"holds", "broken", "noisy", "refused"};
    return names[v];
}

/* ---- testing ---- */

/* Seeds of a law, and so its renders at most. */
enum { SEEDS = 6 };

static double relative_error(const law_room *room, const sample_mean found[3]) {
    double most = 0;
    for (int c = 0; c < 3; ++c) most = fmax(most, found[c].error / fabs(room->value[c]));
    return most;
}

/* A pilot's error is only an estimate, so an error of up to 1.5 times the wanted one is accepted. */
static bool is_noisy(const laws_options *o, const laws_row *row) {
    return !(row->relative <= 1.5 * o->error);
}

/* A pilot render estimates the number of samples for the wanted error; a fifth more allows for its
 * uncertainty. A render that is too noisy after all is the pilot of another one. The samples of pilots are
 * not reused, so the tested samples do not decide when to stop. */
static fathom_status render(const laws_options *o, const law_room *room, uint64_t seed, laws_row *row) {
    fathom_status status = FATHOM_OK;
    row->samples = o->pilot;
    for (uint64_t pass = 0; pass < SEEDS && status == FATHOM_OK; ++pass) {
        status = o->render(room, row->samples, seed + pass, row->found);
        row->relative = relative_error(room, row->found);
        if (pass > 0 && (!is_noisy(o, row) || row->samples >= o->samples)) break;
        const double ratio = row->relative / o->error;
        if (pass + 1 < SEEDS)
            row->samples =
                (uint64_t)fmin(fmax(1.2 * ratio * ratio, 1) * (double)row->samples, (double)o->samples);
    }
    return status;
}

static void judge(const laws_options *o, laws_row *row) {
    row->p = 1;
    for (int c = 0; c < 3; ++c) {
        const sample_mean *m = &row->found[c];
        const double value = row->value[c], allowance = o->allowance * fabs(value);
        const double beyond = fmax(fabs(m->mean - value) - allowance, 0);
        const double p = mean_p(*m, value, allowance);
        if (p < row->p) row->p = p, row->worst = c, row->off = beyond / m->error;
    }
}

/* An integrator may refuse a scene that it does not implement; this breaks no law of light. */
static void refuse(fathom_context *context, laws_row *row, fathom_status *status) {
    snprintf(row->refusal, sizeof row->refusal, "%s", fathom_context_message(context));
    row->verdict = LAWS_REFUSED, row->p = 1;
    *status = FATHOM_OK;
}

static fathom_status run_law(fathom_context *context, const laws_options *o, const law *tested, size_t index,
                             laws_row *row) {
    law_room room;
    const double start = clock_seconds();
    *row = (laws_row){.law = tested};
    fathom_status status = law_open(context, tested, &room);
    memcpy(row->value, room.value, sizeof row->value);
    if (status == FATHOM_OK) {
        status = render(o, &room, o->seed * 1000 + SEEDS * index, row);
        if (status == FATHOM_BAD_INPUT || status == FATHOM_BAD_USAGE)
            refuse(context, row, &status);
        else
            judge(o, row);
    }
    law_close(&room);
    row->seconds = clock_seconds() - start;
    return status;
}

static void finish(const laws_options *o, laws_rows *out) {
    double least = 1;
    out->tests = 0;
    for (size_t i = 0; i < out->rows.count; ++i)
        out->tests += out->rows.items[i].verdict == LAWS_REFUSED ? 0 : 3;
    out->test_level = out->tests ? sidak_level(o->level, (double)out->tests) : o->level;
    for (size_t i = 0; i < out->rows.count; ++i) {
        laws_row *row = &out->rows.items[i];
        if (row->verdict == LAWS_REFUSED) continue;
        least = fmin(least, row->p);
        if (is_noisy(o, row)) row->verdict = LAWS_NOISY;
        if (row->p < out->test_level) row->verdict = LAWS_BROKEN;
    }
    out->p = sidak(least, (double)out->tests);
}

fathom_status laws_run(fathom_context *context, const laws_options *o, laws_rows *out) {
    size_t count = 0;
    fathom_status status = FATHOM_OK;
    while (law_at(o, count)) ++count;
    for (size_t i = 0; i < count && status == FATHOM_OK; ++i) {
        laws_row row;
        if (o->go_on && !o->go_on(o->user, (double)i / (double)count))
            status = fail(context, FATHOM_INTERRUPTED, "stopped by the caller");
        if (status == FATHOM_OK) status = run_law(context, o, law_at(o, i), i, &row);
        if (status == FATHOM_OK && !array_push(&out->rows, row)) status = fail_memory(context, sizeof row);
    }
    finish(o, out);
    return status;
}

void laws_rows_free(laws_rows *rows) { array_free(&rows->rows); }

size_t laws_failed(const laws_rows *rows) {
    size_t failed = 0;
    for (size_t i = 0; i < rows->rows.count; ++i)
        failed += rows->rows.items[i].verdict == LAWS_BROKEN || rows->rows.items[i].verdict == LAWS_NOISY;
    return failed;
}

/* ---- two renders ---- */

/* The variance of a mean divided by the mean: how much light each of its samples brings that brings any. Of
 * all means it is the largest. */
static double grain(const sample_mean *means, size_t count) {
    double most = 0;
    for (size_t i = 0; i < count; ++i)
        if (means[i].mean > 0) most = fmax(most, means[i].error * means[i].error / means[i].mean);
    return most;
}

/* The sum of a channel's means over all cells; degrees of freedom by Welch and Satterthwaite. */
static sample_mean sum_of(const sample_mean *means, size_t count, size_t channel) {
    double sum = 0, square = 0, fourth = 0;
    for (size_t i = channel; i < count; i += 3) {
        const double x = means[i].error * means[i].error;
        sum += means[i].mean, square += x, fourth += x * x / means[i].freedom;
    }
    return (sample_mean){sum, sqrt(square), fourth > 0 ? square * square / fourth : (double)INFINITY};
}

/* Rare bright paths carry much of the light of a room behind a window. A cell that met too few of them has a
 * mean that is too low and an error that is too small, so Welch's test alone would raise false alarms. If the
 * lower mean lacks a difference d for this reason, its variance lacks d times the grain; other cells show the
 * grain that this one missed. */
laws_difference laws_compare(const sample_mean *a, const sample_mean *b, size_t count, double allowance) {
    laws_difference d = {.tests = count + 3, .p = 1};
    const double of_a = grain(a, count), of_b = grain(b, count);
    double sum = 0, difference = 0, square = 0;
    for (size_t i = 0; i < d.tests; ++i) {
        const sample_mean x = i < count ? a[i] : sum_of(a, count, i - count),
                          y = i < count ? b[i] : sum_of(b, count, i - count);
        const double more = x.mean - y.mean, missed = more < 0 ? -more * of_a : more * of_b;
        const double p = welch_p(x, y, missed, allowance * fmax(fabs(x.mean), fabs(y.mean)));
        if (p < d.p) d.p = p, d.worst = i;
        if (i >= count) sum += (x.mean + y.mean) / 2, difference += more;
    }
    /* The three channels of a cell are correlated, so their errors add linearly. */
    for (size_t i = 0; i + 2 < count; i += 3) {
        double error = 0;
        for (size_t c = i; c < i + 3; ++c) error += sqrt(a[c].error * a[c].error + b[c].error * b[c].error);
        square += error * error;
    }
    d.p = sidak(d.p, (double)d.tests);
    if (sum > 0) d.relative = difference / sum, d.relative_error = sqrt(square) / sum;
    return d;
}
