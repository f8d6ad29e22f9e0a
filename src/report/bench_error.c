#include "report/bench_parts.h"
#include "report/drawing.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define METRICS 3
/* A fit whose slope is known no better than this is drawn without its interval, which would fill the plot. */
#define HALF_DRAWN 0.5

static const struct {
    const char *key, *name, *axis;
} metrics[METRICS] = {{"rmse", "RMSE", "RMSE of linear values"},
                      {"relmse", "relative MSE", "relative MSE"},
                      {"flip", "FLIP", "FLIP, 0 to 1"}};

static const char *const patterns[PLOT_KINDS] = {"grid", "stratified", "sobol", NULL};

static bool is_below(const json_t *point, const char *metric) {
    size_t i;
    json_t *name;
    json_array_foreach(json_object_get(point, "belowReference"), i, name) {
        if (strcmp(json_string_value(name), metric) == 0) return true;
    }
    return false;
}

/* ---- plots ---- */

/* Where the fit turns by its interval: at the middle of its points. */
typedef struct span {
    double least, most, sum;
    size_t count;
} span;

static void add_point(drawing *d, const json_t *point, size_t metric, unsigned kind, span *s) {
    double x = number_at(point, "cpuSeconds"), y = number_at(point, metrics[metric].key);
    bool below = is_below(point, metrics[metric].key);
    const plot_point q = {.x = x, .y = y, .high = (double)NAN, .kind = kind, .hollow = below};
    drawing_point(d, q, "%s, %.0f samples a pixel: %s s, %s %s%s", patterns[kind], number_at(point, "spp"),
                  number_of(x).text, metrics[metric].name, number_of(y).text,
                  below ? "; too close to the reference" : "");
    if (below || !(y > 0) || !(x > 0)) return;
    s->least = fmin(s->least, log(x)), s->most = fmax(s->most, log(x)), s->sum += log(x), ++s->count;
}

static void add_fit(drawing *d, const json_t *slope, unsigned kind, const span *s) {
    double b = number_at(slope, "slope"), half = number_at(slope, "half");
    double middle = s->sum / (double)s->count, there = log(number_at(slope, "scale")) + b * middle;
    for (int side = -1; side <= 1; ++side) {
        if (side && !(half <= HALF_DRAWN)) continue;
        double slant = side ? b + side * half : b;
        const plot_line l = {exp(s->least), exp(there + slant * (s->least - middle)),
                             exp(s->most),  exp(there + slant * (s->most - middle)),
                             kind,          side != 0};
        drawing_line(d, l);
    }
}

static void add_curve(drawing *d, const json_t *curve, size_t metric, unsigned kind) {
    span s = {INFINITY, -INFINITY, 0, 0};
    size_t i;
    json_t *point;
    json_array_foreach(json_object_get(curve, "points"), i, point) add_point(d, point, metric, kind, &s);
    const json_t *slopes = json_object_get(json_object_get(curve, "slopes"), metrics[metric].key);
    if (s.count > 1) add_fit(d, json_object_get(slopes, "cpu"), kind, &s);
}

static void put_plot(page *p, const json_t *results, size_t metric) {
    drawing d = {.lost = false};
    size_t i;
    json_t *curve;
    json_array_foreach(json_object_get(results, "curves"), i, curve)
        add_curve(&d, curve, metric, (unsigned)i % PLOT_KINDS);
    const plot t = {.title = metrics[metric].name,
                    .summary =
                        "Error of each pattern against seconds of processor time, both logarithmic, with "
                        "the fitted lines. The tables have the numbers.",
                    .caption = "",
                    .width = 520,
                    .height = 380,
                    .x_name = "processor seconds of rendering",
                    .y_name = metrics[metric].axis,
                    .x_log = true,
                    .y_log = true,
                    .y_low = (double)NAN,
                    .y_high = (double)NAN};
    drawing_put(p, &d, t);
}

static void put_what(page *p, const json_t *results) {
    page_put(p,
             "<p>Images of %.0f \xc3\x97 %.0f pixels, %s of each pattern and number of samples. Times are of "
             "rendering alone: the scene was read and built before, which took %s s of processor time to "
             "build.</p>\n",
             number_at(results, "width"), number_at(results, "height"),
             number_count(count_at(results, "seeds")).text,
             number_of(number_at(json_object_get(results, "build"), "cpuSeconds")).text);
}

static void put_plots(page *p, const json_t *results) {
    page_section(p, "plots", "Error against time");
    put_what(p, results);
    page_put(p,
             "<p>Both axes are logarithmic; lower and further left is better. A line is a power law by least "
             "squares; the dashed ones have the ends of its slope\xe2\x80\x99s 95\xe2\x80\xaf%% interval "
             "over the seeds, where that is not wider than 0.5 to each side. The grid has no seed: its "
             "interval is of times alone.</p>\n");
    plot_legend(p, patterns, "mean of the seeds", "too close to the reference: in no fit");
    page_put(p, "<div class=\"figures\">\n");
    for (size_t m = 0; m < METRICS; ++m) put_plot(p, results, m);
    page_put(p, "</div>\n");
}

/* ---- tables ---- */

static void put_reference(page *p, const json_t *reference) {
    page_section(p, "reference", "The reference");
    page_put(
        p,
        "<p>The mean of two independent halves of the pattern sobol with %s samples a pixel each. Its own "
        "RMSE is half of what is between them, its relative MSE a quarter; for FLIP, what is between them "
        "is a bound. An image closer to it than the halves are to each other is marked.</p>\n",
        number_count(count_at(reference, "sppOfEach")).text);
    table_begin(p, "Errors of the reference");
    table_column(p, "", false);
    for (size_t m = 0; m < METRICS; ++m) table_column(p, metrics[m].name, true);
    table_body(p);
    static const char *const rows[2][2] = {{"its own", "ownError"}, {"between its halves", "betweenHalves"}};
    for (int i = 0; i < 2; ++i) {
        table_row(p, rows[i][0], false);
        for (size_t m = 0; m < METRICS; ++m)
            table_number(p, number_at(json_object_get(reference, rows[i][1]), metrics[m].key));
    }
    table_end(p);
}

static uint64_t nonfinite_of(const json_t *results, const char *pattern, double spp) {
    uint64_t sum = 0;
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(results, "runs"), i, run) {
        if (strcmp(text_at(run, "pattern"), pattern) == 0 && number_at(run, "spp") == spp)
            sum += count_at(run, "notFinite");
    }
    return sum;
}

static void put_point(page *p, const json_t *results, const json_t *curve, const json_t *point) {
    table_row(p, text_at(curve, "pattern"), false);
    table_number(p, number_at(point, "spp"));
    table_number(p, number_at(point, "cpuSeconds"));
    table_number(p, number_at(point, "seconds"));
    char marks[64] = "";
    for (size_t m = 0; m < METRICS; ++m) {
        table_number(p, number_at(point, metrics[m].key));
        size_t used = strlen(marks);
        if (is_below(point, metrics[m].key))
            snprintf(marks + used, sizeof marks - used, "%s%s", used ? ", " : "", metrics[m].name);
    }
    table_marked(p, nonfinite_of(results, text_at(curve, "pattern"), number_at(point, "spp")), "bad");
    table_words(p, marks);
}

static void put_points(page *p, const json_t *results) {
    page_section(p, "images", "All images");
    table_begin(p,
                "Medians of times, geometric means of errors; rendering alone, without reading and building");
    table_column(p, "pattern", false);
    static const char *const names[] = {"samples a pixel", "processor s", "clock s",   "RMSE",
                                        "relative MSE",    "FLIP",        "not finite"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) table_column(p, names[i], true);
    table_column(p, "too close to the reference", false);
    table_body(p);
    size_t i, k;
    json_t *curve, *point;
    json_array_foreach(json_object_get(results, "curves"), i, curve) {
        json_array_foreach(json_object_get(curve, "points"), k, point) put_point(p, results, curve, point);
    }
    table_end(p);
}

static void put_slopes(page *p, const json_t *results) {
    static const char *const clocks[2][2] = {{"cpu", "processor"}, {"wall", "clock"}};
    page_section(p, "slopes", "Slopes");
    page_put(
        p, "<p>b in error \xe2\x88\x9d seconds<sup>b</sup>: \xce\xa3 (x \xe2\x88\x92 x\xcc\x84)(y "
           "\xe2\x88\x92 \xc8\xb3) / \xce\xa3 (x \xe2\x88\x92 x\xcc\x84)\xc2\xb2 of the logarithms for each "
           "seed; the mean of all seeds \xc2\xb1 t s / \xe2\x88\x9an.</p>\n");
    table_begin(p, "Slopes of ln error over ln seconds, and half the width of the 95\xe2\x80\xaf% interval");
    table_column(p, "pattern", false);
    table_column(p, "time", false);
    for (size_t m = 0; m < METRICS; ++m)
        table_column(p, metrics[m].name, true), table_column(p, "\xc2\xb1", true);
    table_body(p);
    size_t i;
    json_t *curve;
    json_array_foreach(json_object_get(results, "curves"), i, curve) {
        for (int c = 0; c < 2; ++c) {
            table_row(p, text_at(curve, "pattern"), false);
            table_words(p, clocks[c][1]);
            for (size_t m = 0; m < METRICS; ++m) {
                const json_t *slope = json_object_get(
                    json_object_get(json_object_get(curve, "slopes"), metrics[m].key), clocks[c][0]);
                table_number(p, number_at(slope, "slope"));
                table_number(p, number_at(slope, "half"));
            }
        }
    }
    table_end(p);
}

static void put_equal(page *p, const json_t *tables, const char *caption, const char *key, const char *at,
                      size_t metric) {
    const json_t *rows = json_object_get(tables, metrics[metric].key);
    if (!json_array_size(rows)) {
        put_absent(p, "The patterns have nothing in common here.");
        return;
    }
    char text[200];
    snprintf(text, sizeof text, caption, metrics[metric].name);
    table_begin(p, text);
    table_column(p, at ? at : metrics[metric].name, false);
    for (unsigned k = 0; patterns[k]; ++k) table_column(p, patterns[k], true);
    table_body(p);
    size_t i;
    json_t *row;
    json_array_foreach(rows, i, row) {
        table_row(p, number_of(number_at(row, key)).text, false);
        for (unsigned k = 0; patterns[k]; ++k) table_number(p, number_at(row, patterns[k]));
    }
    table_end(p);
}

void bench_error_put(page *p, const json_t *results) {
    put_plots(p, results);
    put_reference(p, json_object_get(results, "reference"));
    put_slopes(p, results);
    page_section(p, "time", "Equal time");
    for (size_t m = 0; m < METRICS; ++m)
        put_equal(p, json_object_get(results, "equalTime"), "%s in the same time", "cpuSeconds",
                  "processor s", m);
    page_section(p, "error", "Equal error");
    for (size_t m = 0; m < METRICS; ++m)
        put_equal(p, json_object_get(results, "equalError"), "Processor seconds for the same %s", "error",
                  NULL, m);
    put_points(p, results);
}
