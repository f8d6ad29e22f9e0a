#include "report/bars.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static double ratio_of(const json_t *item) {
    double error = number_at(item, "error"), bound = number_at(item, "bound");
    if (error <= 0) return 0;
    return bound > 0 ? error / bound : (double)INFINITY;
}

static void put_case(page *p, const json_t *item) {
    char title[200];
    double ratio = ratio_of(item);
    snprintf(title, sizeof title, "error %s, bound %s: %s of the bound",
             number_of(number_at(item, "error")).text, number_of(number_at(item, "bound")).text,
             number_of(ratio).text);
    table_row(p, text_at(item, "case"), false);
    table_exact(p, number_at(item, "measured"));
    table_exact(p, number_at(item, "expected"));
    table_number(p, number_at(item, "error"));
    table_number(p, number_at(item, "bound"));
    page_put(p, "<td>");
    bars_ratio(p, ratio, title);
    page_put(p, "</td>\n");
    bool ok = json_is_true(json_object_get(item, "ok"));
    page_put(p, ok ? "<td class=\"good\">ok</td>\n" : "<td class=\"bad\">failed</td>\n");
}

static const char *group_at(const json_t *cases, size_t i) {
    return text_at(json_array_get(cases, i), "group");
}

/* ---- by group ---- */

typedef struct group_sum {
    uint64_t cases, failed;
    double ratio; /* the largest */
    const json_t *worst;
} group_sum;

static group_sum sum_group(const json_t *cases, const char *group) {
    group_sum sum = {.ratio = -1};
    size_t i;
    json_t *item;
    json_array_foreach(cases, i, item) {
        if (strcmp(text_at(item, "group"), group) != 0) continue;
        double ratio = ratio_of(item);
        ++sum.cases, sum.failed += !json_is_true(json_object_get(item, "ok"));
        if (ratio > sum.ratio || !sum.worst) sum.ratio = ratio, sum.worst = item;
    }
    return sum;
}

static void put_group(page *p, const json_t *cases, const char *group) {
    group_sum sum = sum_group(cases, group);
    char title[100];
    snprintf(title, sizeof title, "%s of the bound", number_of(sum.ratio).text);
    table_row(p, group, false);
    table_count(p, sum.cases);
    table_marked(p, sum.failed, "bad");
    table_number(p, sum.ratio);
    page_put(p, "<td>");
    bars_ratio(p, sum.ratio, title);
    page_put(p, "</td>\n<td class=\"wide\">");
    page_text(p, text_at(sum.worst, "case"));
    page_put(p, "</td>\n");
}

/* The first of its group: groups are shown in the order in which they come. */
static bool is_first(const json_t *cases, size_t i) {
    for (size_t k = 0; k < i; ++k) {
        if (strcmp(group_at(cases, i), group_at(cases, k)) == 0) return false;
    }
    return true;
}

static void put_groups(page *p, const json_t *cases) {
    table_begin(p, "Groups of shading cases, and the case of each that comes nearest to its bound");
    static const char *const columns[6] = {"", "cases", "failed", "largest error / bound", "", "in"};
    for (int c = 0; c < 6; ++c) table_column(p, columns[c], c > 0 && c < 4);
    table_body(p);
    for (size_t i = 0; i < json_array_size(cases); ++i) {
        if (is_first(cases, i)) put_group(p, cases, group_at(cases, i));
    }
    table_end(p);
}

/* ---- all ---- */

static void put_cases(page *p, const json_t *cases) {
    page_put(p, "<details><summary>All cases with their numbers</summary>\n");
    table_begin(p, "Every shading case");
    static const char *const columns[7] = {"case",  "measured",      "expected", "error",
                                           "bound", "error / bound", ""};
    for (int c = 0; c < 7; ++c) table_column(p, columns[c], c > 0 && c < 5);
    table_body(p);
    for (size_t i = 0; i < json_array_size(cases); ++i) {
        if (!is_first(cases, i)) continue;
        table_group(p, 7, "", group_at(cases, i));
        for (size_t k = i; k < json_array_size(cases); ++k) {
            if (strcmp(group_at(cases, k), group_at(cases, i)) == 0) put_case(p, json_array_get(cases, k));
        }
    }
    table_end(p);
    page_put(p, "</details>\n");
}

/* Those that failed, in sight. */
static void put_failed(page *p, const json_t *cases) {
    size_t i;
    json_t *item;
    bool any = false;
    json_array_foreach(cases, i, item) {
        if (json_is_true(json_object_get(item, "ok"))) continue;
        page_put(p, any ? "<li>" : "<p>Out of bounds:</p>\n<ul>\n<li>");
        any = true;
        page_text(p, text_at(item, "group"));
        page_put(p, ": ");
        page_text(p, text_at(item, "case"));
        page_put(p, "; error %s, bound %s</li>\n", number_of(number_at(item, "error")).text,
                 number_of(number_at(item, "bound")).text);
    }
    if (any) page_put(p, "</ul>\n");
}

void validate_shading_put(page *p, const json_t *results) {
    const json_t *cases = json_object_get(results, "shading");
    page_section(p, "shading", "Shading at extremes");
    if (!json_array_size(cases)) {
        put_absent(p, "Left out: these results have none; --extremes runs them.");
        return;
    }
    page_put(
        p,
        "<p>Rendered values against closed forms. A bar is the error over its bound on a logarithmic scale "
        "from a millionth to ten; the upright line is the bound.</p>\n");
    put_groups(p, cases);
    put_failed(p, cases);
    put_cases(p, cases);
}
