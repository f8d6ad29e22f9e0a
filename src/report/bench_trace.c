#include "report/bench_parts.h"
#include "report/drawing.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SETS 4
static const char *const set_names[SETS] = {"camera", "bounce", "shadow", "between"};
static const char *const set_titles[SETS] = {
    "Camera rays: closest hit, coherent", "Bounced rays: closest hit, incoherent",
    "Shadow rays: any hit, coherent", "Rays between points: any hit, incoherent"};
static const char *const kind_names[PLOT_KINDS] = {"Embree", "our BVH", "linear search", "plug-in"};

static const json_t *rate_of(const json_t *run, const char *set) {
    size_t i;
    json_t *rate;
    json_array_foreach(json_object_get(run, "rates"), i, rate) {
        if (strcmp(text_at(rate, "set"), set) == 0) return rate;
    }
    return NULL;
}

static double millions(const json_t *rate, const char *which) {
    return number_at(json_object_get(rate, "millionRaysPerCpuSecond"), which);
}

static unsigned kind_of(const char *spec) {
    if (strncmp(spec, "embree", 6) == 0) return 0;
    if (strncmp(spec, "bvh", 3) == 0) return 1;
    return strncmp(spec, "linear", 6) == 0 || strncmp(spec, "reference", 9) == 0 ? 2 : 3;
}

/* ---- the table ---- */

/* Half the distance of the quartiles. */
static const char *spread_text(const json_t *rate, char out[32]) {
    snprintf(out, 32, "\xc2\xb1%.0f\xe2\x80\xaf%%",
             50 * (millions(rate, "high") - millions(rate, "low")) / millions(rate, "median"));
    return out;
}

static void put_run(page *p, const json_t *run) {
    char text[32];
    table_row(p, text_at(run, "spec"), true);
    table_number(p, number_at(run, "buildSeconds"));
    table_number(p, 1e-6 * number_at(run, "bvhBytes"));
    for (int s = 0; s < SETS; ++s) {
        const json_t *rate = rate_of(run, set_names[s]);
        table_number(p, millions(rate, "median"));
        table_words(p, spread_text(rate, text));
        table_count(p, count_at(rate, "rays"));
    }
}

static void put_table(page *p, const json_t *runs) {
    page_section(p, "rates", "Million rays a second");
    page_put(p, "<p>Rays for each second of a thread\xe2\x80\x99s processor time: medians, half the distance "
                "of the quartiles, and "
                "how many rays each repetition had: slow tracers get "
                "fewer, taken evenly out of the same ones. Tracers took turns.</p>\n");
    table_begin(p, "Million rays a second of processor time, seconds to build, megabytes of BVH");
    table_column(p, "tracer", false);
    table_column(p, "build, s", true);
    table_column(p, "BVH, MB", true);
    for (int s = 0; s < SETS; ++s) {
        table_column(p, set_names[s], true);
        table_column(p, "spread", false);
        table_column(p, "rays", true);
    }
    table_body(p);
    size_t i;
    json_t *run;
    const char *last = "";
    uint64_t triangles = UINT64_MAX;
    json_array_foreach(runs, i, run) {
        if (strcmp(last, text_at(run, "scene")) != 0 || triangles != count_at(run, "triangles")) {
            char words[64];
            snprintf(words, sizeof words, "%s triangles", number_count(count_at(run, "triangles")).text);
            table_group(p, 3 + 3 * SETS, text_at(run, "scene"), words);
        }
        last = text_at(run, "scene"), triangles = count_at(run, "triangles");
        put_run(p, run);
    }
    table_end(p);
}

/* ---- by triangle count ---- */

/* The runs in the order of their tracers' first appearance, and of triangles within each. */
typedef struct ordered {
    const json_t *run;
    size_t tracer;
    double triangles;
} ordered;

static size_t first_of(const json_t *runs, size_t i) {
    for (size_t k = 0; k < i; ++k) {
        if (same_tracer(runs, i, k)) return k;
    }
    return i;
}

static int in_order(const void *a, const void *b) {
    const ordered *x = a, *y = b;
    if (x->tracer != y->tracer) return x->tracer < y->tracer ? -1 : 1;
    return (x->triangles > y->triangles) - (x->triangles < y->triangles);
}

static ordered *order(const json_t *runs) {
    size_t count = json_array_size(runs);
    ordered *items = calloc(count ? count : 1, sizeof *items);
    for (size_t i = 0; i < count && items; ++i) {
        const json_t *run = json_array_get(runs, i);
        items[i] = (ordered){run, first_of(runs, i), number_at(run, "triangles")};
    }
    if (items) qsort(items, count, sizeof *items, in_order);
    return items;
}

/* A plot of some number of each run. */
typedef struct growth {
    const char *title, *unit;
    int set; /* of rates; below 0: a number of the run itself */
    const char *key;
    double scale;
} growth;

static double value_of(const growth *g, const json_t *run) {
    if (g->set < 0) return g->scale * number_at(run, g->key);
    return millions(rate_of(run, set_names[g->set]), "median");
}

/* Asked of fewer rays than another tracer. */
static bool was_slow(const growth *g, const ordered *items, size_t count, size_t i) {
    if (g->set < 0) return false;
    uint64_t rays = count_at(rate_of(items[i].run, set_names[g->set]), "rays");
    for (size_t k = 0; k < count; ++k) {
        if (items[k].triangles == items[i].triangles &&
            count_at(rate_of(items[k].run, set_names[g->set]), "rays") > rays)
            return true;
    }
    return false;
}

static void draw(drawing *d, const growth *g, const ordered *items, size_t count) {
    for (size_t i = 0; i < count; ++i) {
        const char *spec = text_at(items[i].run, "spec");
        bool last = i + 1 == count || items[i + 1].tracer != items[i].tracer;
        double x = items[i].triangles, y = value_of(g, items[i].run);
        plot_point q = {.x = x, .y = y, .high = (double)NAN, .label = last ? spec : NULL};
        q.kind = kind_of(spec), q.hollow = was_slow(g, items, count, i);
        drawing_point(d, q, "%.80s, %s triangles: %s %s", spec, number_of(x).text, number_of(y).text,
                      g->unit);
        if (i == 0 || items[i - 1].tracer != items[i].tracer) continue;
        double x_before = items[i - 1].triangles, y_before = value_of(g, items[i - 1].run);
        drawing_line(d, (plot_line){x_before, y_before, x, y, q.kind, false});
    }
}

static void put_growth(page *p, const growth *g, const ordered *items, size_t count) {
    drawing d = {.lost = false};
    draw(&d, g, items, count);
    const plot t = {.title = g->title,
                    .summary = "Lines: each tracer over the number of triangles, both axes logarithmic. The "
                               "table has the numbers.",
                    .caption = "",
                    .width = 1040,
                    .height = 400,
                    .x_name = "triangles",
                    .y_name = g->unit,
                    .x_log = true,
                    .y_log = true,
                    .y_low = (double)NAN,
                    .y_high = (double)NAN};
    drawing_put(p, &d, t);
}

static bool grows(const ordered *items, size_t count) {
    for (size_t i = 1; i < count; ++i) {
        if (items[i].tracer == items[i - 1].tracer && items[i].triangles > items[i - 1].triangles &&
            items[i - 1].triangles > 0)
            return true;
    }
    return false;
}

static void put_growths(page *p, const ordered *items, size_t count) {
    bool kinds[PLOT_KINDS] = {false};
    const char *names[PLOT_KINDS];
    for (size_t i = 0; i < count; ++i) kinds[kind_of(text_at(items[i].run, "spec"))] = true;
    for (unsigned k = 0; k < PLOT_KINDS; ++k) names[k] = kinds[k] ? kind_names[k] : NULL;
    plot_legend(p, names, "median", "median of fewer rays: a slow tracer");
    page_put(p, "<div class=\"figures\">\n");
    for (int s = 0; s < SETS; ++s) {
        growth g = {set_titles[s], "million rays a second", s, NULL, 1};
        put_growth(p, &g, items, count);
    }
    const growth build = {"Building", "seconds", -1, "buildSeconds", 1};
    const growth memory = {"BVH", "megabytes", -1, "bvhBytes", 1e-6};
    put_growth(p, &build, items, count);
    put_growth(p, &memory, items, count);
    page_put(p, "</div>\n");
}

void bench_trace_put(page *p, const json_t *results) {
    const json_t *runs = json_object_get(results, "runs");
    put_table(p, runs);
    page_section(p, "growth", "By triangle count");
    ordered *items = order(runs);
    if (!items) p->lost = true;
    if (items && !grows(items, json_array_size(runs)))
        put_absent(p, "One scene only: --triangles 10k,100k,1M shows how rates fall with the triangles.");
    else if (items)
        put_growths(p, items, json_array_size(runs));
    free(items);
}
