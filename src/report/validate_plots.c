#include "report/bars.h"
#include "report/drawing.h"
#include "report/number.h"
#include "report/validate_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define TITLE 400

static const char *const kind_names[PLOT_KINDS] = {"Embree", "our BVH", "linear search", "plug-in"};

/* ---- error against time ---- */

static void draw_errors(drawing *d, const tracer_sum *sum, const spread *errors) {
    const plot_point q = {.x = sum->nanoseconds,
                          .y = spread_quantile(errors, 0.999),
                          .high = errors->most,
                          .label = sum->spec,
                          .kind = sum->kind};
    drawing_point(d, q, "%.100s: %s ns a ray; error of t %s ulp for all but 1 in 1000 rays, at most %s ulp",
                  sum->spec, number_of(q.x).text, number_of(q.y).text, number_of(q.high).text);
}

static void put_error_plot(page *p, const tracer_sums *sums, bool ordinary) {
    drawing d = {.lost = false};
    for (size_t i = 0; i < sums->count; ++i) {
        const tracer_sum *sum = &sums->items[i];
        draw_errors(&d, sum, ordinary ? &sum->ordinary : &sum->hard);
    }
    const plot t = {
        .title = ordinary ? "Ordinary rays: camera and uniform" : "Difficult rays: all other families",
        .summary =
            "Points: each tracer's error of t in ulp against its nanoseconds a ray, both logarithmic. The "
            "table of tracers and scenes has the numbers.",
        .caption = "",
        .width = 1040,
        .height = 400,
        .x_name = "nanoseconds a ray",
        .y_name = "error of t, ulp of a float",
        .x_log = true,
        .y_log = true,
        .y_low = (double)NAN,
        .y_high = (double)NAN};
    drawing_put(p, &d, t);
}

static void put_errors(page *p, const tracer_sums *sums) {
    page_section(p, "time", "Error against time");
    bool timed = sums->count > 0, kinds[PLOT_KINDS] = {false};
    for (size_t i = 0; i < sums->count; ++i) {
        timed &= isfinite(sums->items[i].nanoseconds) && sums->items[i].all.total > 0;
        kinds[sums->items[i].kind] = true;
    }
    if (!timed) {
        put_absent(p, "Left out: these results have no times of the tracers.");
        return;
    }
    page_put(
        p,
        "<p>What an answer costs, and how exact it is. Both axes are logarithmic; lower and further left is "
        "better. Difficult rays are mostly ill-conditioned: there even the nearest float is many units off, "
        "for any tracer.</p>\n");
    const char *names[PLOT_KINDS];
    for (unsigned k = 0; k < PLOT_KINDS; ++k) names[k] = kinds[k] ? kind_names[k] : NULL;
    plot_legend(p, names, "all but 1 in 1000 rays", "the largest error");
    page_put(p, "<div class=\"figures\">\n");
    put_error_plot(p, sums, true);
    put_error_plot(p, sums, false);
    page_put(p, "</div>\n");
}

/* ---- histograms ---- */

/* Bars of an octave each: what is finer does not show. */
static size_t bars_of(const spread *s, bar *out) {
    size_t count = 0;
    if (s->zeros) out[count++] = (bar){0, 0, (double)s->zeros};
    for (size_t i = 0; i < SPREAD_BINS; i += s->per_octave) {
        uint64_t sum = 0;
        for (size_t k = i; k < i + s->per_octave && k < SPREAD_BINS; ++k) sum += s->bins[k];
        int octave = s->first + (int)(i / s->per_octave);
        if (sum) out[count++] = (bar){exp2(octave), exp2(octave + 1), (double)sum};
    }
    return count;
}

typedef struct limits {
    double low, high, most;
    bool zero;
} limits;

static limits limits_of(const tracer_sums *sums, bar *room) {
    limits l = {INFINITY, 0, 0, false};
    for (size_t i = 0; i < sums->count; ++i) {
        size_t count = bars_of(&sums->items[i].all, room);
        for (size_t k = 0; k < count; ++k) {
            l.most = fmax(l.most, room[k].count);
            if (room[k].to > 0)
                l.low = fmin(l.low, room[k].from), l.high = fmax(l.high, room[k].to);
            else
                l.zero = true;
        }
    }
    if (!(l.low < l.high)) l.low = 0.5, l.high = 2;
    return l;
}

static void put_histogram(page *p, const tracer_sum *sum, const limits *l, bar *room) {
    char caption[TITLE];
    snprintf(caption, sizeof caption, "%s rays; median %s ulp, 99.9\xe2\x80\xaf%% %s ulp, largest %s ulp.",
             number_count(sum->all.total).text, number_of(spread_quantile(&sum->all, 0.5)).text,
             number_of(spread_quantile(&sum->all, 0.999)).text, number_of(sum->all.most).text);
    bars b = {.title = sum->spec,
              .summary = caption,
              .caption = caption,
              .x_name = "error of t, ulp of a float",
              .y_name = "rays",
              .width = 320,
              .height = 210,
              .low = l->low,
              .high = l->high,
              .most = l->most,
              .zero = l->zero,
              .items = room,
              .count = bars_of(&sum->all, room)};
    bars_put(p, &b);
}

static void put_histograms(page *p, const tracer_sums *sums) {
    page_section(p, "histograms", "Distribution of errors");
    bool there = sums->count > 0;
    for (size_t i = 0; i < sums->count; ++i)
        there &= sums->items[i].all.total > 0 && sums->items[i].all.per_octave;
    bar *room = calloc(SPREAD_BINS + 1, sizeof *room);
    if (!room) p->lost = true;
    if (!there) put_absent(p, "Left out: these results have no histograms.");
    if (there && room) {
        page_put(p,
                 "<p>How many rays have which error of t, over all scenes and families. One bar doubles the "
                 "error; heights are logarithmic, so that the few rays far out are seen.</p>\n"
                 "<div class=\"figures\">\n");
        limits l = limits_of(sums, room);
        for (size_t i = 0; i < sums->count; ++i) put_histogram(p, &sums->items[i], &l, room);
        page_put(p, "</div>\n");
    }
    free(room);
}

void validate_plots_put(page *p, const json_t *results) {
    tracer_sums sums = {.count = 0};
    if (!tracer_sums_of(results, &sums)) p->lost = true;
    put_errors(p, &sums);
    put_histograms(p, &sums);
    array_free(&sums);
}
