#include "report/bench_parts.h"
#include "report/drawing.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <math.h>

/* A number of each run, over its triangles. */
typedef struct series {
    const char *name, *key, *inner;
    const char *fit; /* of "fits"; NULL: none is drawn */
    double scale;    /* from its number to the plot's unit */
} series;

static double value_of(const json_t *run, const series *s) {
    const json_t *value = json_object_get(run, s->key);
    return s->inner ? number_at(json_object_get(value, s->inner), "median") : number_at(value, "median");
}

/* ---- plots ---- */

static void draw_point(drawing *d, const json_t *run, const series *s, unsigned kind, const char *unit) {
    double x = number_at(run, "triangles"), y = s->scale * value_of(run, s);
    drawing_point(d, (plot_point){.x = x, .y = y, .high = (double)NAN, .kind = kind},
                  "%.40s, %s triangles: %s %s", s->name, number_of(x).text, number_of(y).text, unit);
}

static void draw_fit(drawing *d, const json_t *results, const series *s, unsigned kind, size_t first) {
    const json_t *fits = json_object_get(json_object_get(results, "fits"), s->fit);
    const json_t *fit = json_object_get(fits, "all");
    if (!json_is_object(fit) || d->points.count == first) return;
    double b = number_at(fit, "exponent"), factor = s->scale * number_at(fit, "scale");
    double from = d->points.items[first].x, to = d->points.items[d->points.count - 1].x;
    drawing_line(d, (plot_line){from, factor * pow(from, b), to, factor * pow(to, b), kind, true});
}

/* Straight from size to size. */
static void draw_way(drawing *d, unsigned kind, size_t first) {
    for (size_t i = first + 1; i < d->points.count; ++i) {
        const plot_point *a = &d->points.items[i - 1], *b = &d->points.items[i];
        drawing_line(d, (plot_line){a->x, a->y, b->x, b->y, kind, false});
    }
}

static void draw(drawing *d, const json_t *results, const series *all, size_t count, const char *unit) {
    const json_t *runs = json_object_get(results, "runs");
    for (size_t k = 0; k < count; ++k) {
        size_t first = d->points.count, i;
        json_t *run;
        json_array_foreach(runs, i, run) draw_point(d, run, &all[k], (unsigned)k, unit);
        if (all[k].fit)
            draw_fit(d, results, &all[k], (unsigned)k, first);
        else
            draw_way(d, (unsigned)k, first);
    }
}

static void put_series(page *p, const json_t *results, const series *all, size_t count, const char *title,
                       const char *unit, bool y_log) {
    drawing d = {.lost = false};
    const char *names[PLOT_KINDS] = {NULL};
    for (size_t k = 0; k < count; ++k) names[k] = all[k].name;
    draw(&d, results, all, count, unit);
    plot_legend(p, names, "median", NULL);
    const plot t = {.title = title,
                    .summary = "Over the number of triangles. The table has the numbers.",
                    .caption = "",
                    .width = 1040,
                    .height = 400,
                    .x_name = "triangles",
                    .y_name = unit,
                    .x_log = true,
                    .y_log = y_log,
                    .y_low = y_log ? (double)NAN : 0,
                    .y_high = (double)NAN};
    drawing_put(p, &d, t);
}

static void put_plots(page *p, const json_t *results) {
    static const series phases[] = {{"reading", "readSeconds", "cpu", "read", 1e3},
                                    {"building", "buildSeconds", "cpu", "build", 1e3}};
    static const series tracing[] = {{"render phase", "renderCpuSeconds", NULL, NULL, 1e3},
                                     {"Embree\xe2\x80\x99s bare calls", "bareCpuSeconds", NULL, NULL, 1e3}};
    static const series ratio[] = {{"render over bare", "renderToBare", NULL, NULL, 1}};
    page_section(p, "plots", "By the number of triangles");
    page_put(p, "<p>Processor time, medians. Dashed: a power law by least squares over all "
                "sizes.</p>\n<div class=\"figures\">\n");
    put_series(p, results, phases, 2, "Reading and building", "processor milliseconds", true);
    put_series(p, results, tracing, 2, "One sample a pixel, by one thread", "processor milliseconds", true);
    put_series(p, results, ratio, 1, "The render phase over the bare calls", "times", false);
    page_put(p, "</div>\n");
}

/* ---- tables ---- */

static void put_sizes(page *p, const json_t *results) {
    static const char *const columns[] = {
        "file, bytes",     "BVH, bytes", "at most, bytes", "read, s",       "clock, s", "build, s",
        "clock, s",        "rays",       "render, s",      "bare calls, s", "Mrays/s",  "bare, Mrays/s",
        "render over bare"};
    page_section(p, "sizes", "Sizes");
    page_put(p, "<p>Seconds of processor time, of all threads together; rendering is of one thread. At most: "
                "what Embree holds while it builds.</p>\n");
    table_begin(p, "Reading, building and rendering by the number of triangles");
    table_column(p, "triangles", false);
    for (size_t i = 0; i < sizeof columns / sizeof *columns; ++i) table_column(p, columns[i], true);
    table_body(p);
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(results, "runs"), i, run) {
        table_row(p, number_count(count_at(run, "triangles")).text, false);
        table_count(p, count_at(run, "fileBytes"));
        table_count(p, count_at(run, "bvhBytes"));
        table_count(p, count_at(run, "bvhPeakBytes"));
        static const series numbers[] = {{"", "readSeconds", "cpu", NULL, 1},
                                         {"", "readSeconds", "wall", NULL, 1},
                                         {"", "buildSeconds", "cpu", NULL, 1},
                                         {"", "buildSeconds", "wall", NULL, 1}};
        for (int k = 0; k < 4; ++k) table_number(p, value_of(run, &numbers[k]));
        table_count(p, count_at(run, "rays"));
        table_number(p, number_at(json_object_get(run, "renderCpuSeconds"), "median"));
        table_number(p, number_at(json_object_get(run, "bareCpuSeconds"), "median"));
        table_number(p, number_at(json_object_get(run, "millionRaysPerCpuSecond"), "render"));
        table_number(p, number_at(json_object_get(run, "millionRaysPerCpuSecond"), "bare"));
        table_number(p, number_at(json_object_get(run, "renderToBare"), "median"));
    }
    table_end(p);
}

static void put_fits(page *p, const json_t *results) {
    static const char *const rows[][2] = {{"read", "reading"},
                                          {"build", "building"},
                                          {"render", "render phase"},
                                          {"bare", "bare calls"},
                                          {"renderToBare", "render over bare"}};
    static const char *const parts[] = {"all", "heavy"};
    page_section(p, "exponents", "Exponents");
    page_put(p, "<p>b of processor seconds \xe2\x88\x9d triangles<sup>b</sup> with half its "
                "95\xe2\x80\xaf%% interval: 1 is linear. Of render over bare, 0 says that both grow "
                "alike.</p>\n");
    table_begin(p, "Fitted exponents");
    table_column(p, "of", false);
    table_column(p, "all sizes", true);
    table_column(p, "\xc2\xb1", true);
    table_column(p, "from a million on", true);
    table_column(p, "\xc2\xb1", true);
    table_body(p);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; ++i) {
        const json_t *fits = json_object_get(json_object_get(results, "fits"), rows[i][0]);
        table_row(p, rows[i][1], false);
        for (int k = 0; k < 2; ++k) {
            table_number(p, number_at(json_object_get(fits, parts[k]), "exponent"));
            table_number(p, number_at(json_object_get(fits, parts[k]), "half"));
        }
    }
    table_end(p);
}

void bench_growth_put(page *p, const json_t *results) {
    put_plots(p, results);
    put_fits(p, results);
    put_sizes(p, results);
}
