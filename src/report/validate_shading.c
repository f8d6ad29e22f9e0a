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
        "from a millionth to ten; the upright line is the bound.</p>\n<div data-marks=\"%zu\">\n",
        json_array_size(cases));
    table_begin(p, "Shading cases");
    static const char *const columns[7] = {"case",  "measured",      "expected", "error",
                                           "bound", "error / bound", ""};
    for (int c = 0; c < 7; ++c) table_column(p, columns[c], c > 0 && c < 5);
    table_body(p);
    const char *group = "";
    size_t i;
    json_t *item;
    json_array_foreach(cases, i, item) {
        if (i == 0 || strcmp(group, text_at(item, "group")) != 0)
            group = text_at(item, "group"), table_group(p, 7, "", group);
        put_case(p, item);
    }
    table_end(p);
    page_put(p, "</div>\n");
}
