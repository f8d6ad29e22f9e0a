#include "report/bench_parts.h"
#include "report/number.h"
#include "report/plot.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <stdio.h>
#include <string.h>

#define ROWS_MAX 64

static const char *const kinds[PLOT_KINDS] = {"camera", "mirrored", "refracted", "shadow"};

static double inner(const json_t *row, const char *key, const char *name) {
    return number_at(json_object_get(row, key), name);
}

static unsigned kind_of(const json_t *row) {
    for (unsigned k = 0; k < PLOT_KINDS; ++k) {
        if (strcmp(kinds[k], text_at(row, "kind")) == 0) return k;
    }
    return 0;
}

static void put_plot(page *p, const json_t *rows) {
    plot_point points[ROWS_MAX];
    size_t count = 0, i;
    json_t *row;
    json_array_foreach(rows, i, row) {
        if (count == ROWS_MAX) break;
        points[count++] = (plot_point){.x = number_at(row, "depth"),
                                       .y = inner(row, "renderToSingle", "median"),
                                       .high = inner(row, "renderToSingle", "high"),
                                       .title = text_at(row, "kind"),
                                       .kind = kind_of(row)};
    }
    const plot_line one = {.x0 = 0, .y0 = 1, .x1 = 8, .y1 = 1, .dashed = true};
    plot_legend(p, kinds, "median", "upper quartile");
    plot_put(p, &(plot){.title = "The render\xe2\x80\x99s way over single rays",
                        .summary = "Ratio of times by depth, 1 where both are as fast",
                        .caption = "Below the dashed line the render is the faster one.",
                        .width = 560,
                        .height = 320,
                        .x_name = "depth",
                        .y_name = "time over single rays\xe2\x80\x99",
                        .y_low = 0,
                        .y_high = 1.2,
                        .points = points,
                        .count = count,
                        .lines = &one,
                        .line_count = 1});
}

static void put_row(page *p, const json_t *row) {
    char name[64];
    snprintf(name, sizeof name, "%.0f, %.20s", number_at(row, "depth"), text_at(row, "kind"));
    table_row(p, name, false);
    table_count(p, count_at(row, "rays"));
    table_number(p, inner(row, "renderToSingle", "median"));
    table_number(p, inner(row, "renderToSingle", "low"));
    table_number(p, inner(row, "renderToSingle", "high"));
    const char *way;
    const json_t *ns;
    json_object_foreach(json_object_get(row, "nsPerRay"), way, ns) table_number(p, number_at(ns, "median"));
}

void bench_secondary_put(page *p, const json_t *results) {
    const json_t *rows = json_object_get(results, "rows");
    page_section(p, "depths", "By depth and kind");
    page_put(p, "<p>The rays of a render\xe2\x80\x99s first samples, asked again as the render asks them, "
                "its tracer included, and by Embree\xe2\x80\x99s calls alone: one ray a call, or in packets. "
                "Processor time of one thread; each ratio is a median over repetitions that took "
                "turns.</p>\n");
    put_plot(p, rows);
    table_begin(p, "Nanoseconds a ray, and the render\xe2\x80\x99s over single rays\xe2\x80\x99");
    table_column(p, "depth, kind", false);
    table_column(p, "rays", true);
    table_column(p, "render over single", true);
    table_column(p, "lower quartile", true);
    table_column(p, "upper quartile", true);
    const char *way;
    const json_t *ns;
    json_object_foreach(json_object_get(json_array_get(rows, 0), "nsPerRay"), way, ns)
        table_column(p, way, true);
    table_body(p);
    size_t i;
    json_t *row;
    json_array_foreach(rows, i, row) put_row(p, row);
    table_end(p);
}
