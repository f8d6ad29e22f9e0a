#include "report/heat.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WORDS 400

/* ---- from cases to rows and columns ---- */

/* One group of cases as a map. */
typedef struct grid {
    const char *group;
    ARRAY(const char *) rows; /* specs, in the order of the cases */
    ARRAY(double) columns;    /* parameters, in order of size */
    heat_cell *cells;
} grid;

static bool add_row(grid *g, const char *spec) {
    for (size_t i = 0; i < g->rows.count; ++i) {
        if (strcmp(g->rows.items[i], spec) == 0) return true;
    }
    return array_push(&g->rows, spec);
}

static bool add_column(grid *g, double x) {
    size_t at = 0;
    while (at < g->columns.count && g->columns.items[at] < x) ++at;
    if (at < g->columns.count && !(g->columns.items[at] > x)) return true;
    if (!array_push(&g->columns, x)) return false;
    memmove(&g->columns.items[at + 1], &g->columns.items[at], (g->columns.count - 1 - at) * sizeof x);
    g->columns.items[at] = x;
    return true;
}

static double parameter_of(const json_t *item) {
    double x = number_at(item, "parameter");
    return isnan(x) ? 0 : x;
}

static heat_cell *cell_of(const grid *g, const json_t *item) {
    size_t row = 0, column = 0;
    while (strcmp(g->rows.items[row], text_at(item, "spec")) != 0) ++row;
    while (g->columns.items[column] < parameter_of(item)) ++column;
    return &g->cells[row * g->columns.count + column];
}

/* The numbers behind a cell. */
static char *title_of(const json_t *item) {
    char text[640];
    snprintf(text, sizeof text, "%.100s, %.200s: constant %s; %s rays, %s leak, %s wrong%s",
             text_at(item, "spec"), text_at(item, "case"), number_of(number_at(item, "constant")).text,
             number_count(count_at(item, "rays")).text, number_count(case_verdicts(item, "leak")).text,
             number_count(case_verdicts(item, "wrong")).text,
             json_is_true(json_object_get(item, "ok")) ? "" : "; FAILED");
    return strdup(text);
}

static bool is_of(const grid *g, const json_t *item) { return strcmp(text_at(item, "group"), g->group) == 0; }

static bool fill_cell(grid *g, const json_t *item) {
    bool wrong = case_verdicts(item, "wrong") > 0 || !json_is_true(json_object_get(item, "ok"));
    heat_cell *cell = cell_of(g, item);
    heat_sign sign = wrong ? HEAT_WRONG : case_verdicts(item, "leak") ? HEAT_LEAK : HEAT_PLAIN;
    double value = number_at(item, "constant");
    /* Two cases with one parameter share a cell: the worse of them is shown. */
    if (cell->sign > sign || (cell->sign == sign && cell->value >= value)) return true;
    free(cell->title);
    *cell = (heat_cell){sign, value, title_of(item)};
    return cell->title != NULL;
}

static bool fill(grid *g, const json_t *cases) {
    size_t i;
    json_t *item;
    json_array_foreach(cases, i, item) {
        if (is_of(g, item) && (!add_row(g, text_at(item, "spec")) || !add_column(g, parameter_of(item))))
            return false;
    }
    g->cells = calloc(g->rows.count * g->columns.count, sizeof *g->cells);
    if (!g->cells) return false;
    json_array_foreach(cases, i, item) {
        if (is_of(g, item) && !fill_cell(g, item)) return false;
    }
    return true;
}

static void grid_free(grid *g) {
    for (size_t i = 0; g->cells && i < g->rows.count * g->columns.count; ++i) free(g->cells[i].title);
    free(g->cells);
    array_free(&g->rows);
    array_free(&g->columns);
}

/* ---- what a map shows, in words ---- */

/* The words of the case with this parameter. */
static const char *words_of(const grid *g, const json_t *cases, double parameter) {
    size_t i;
    json_t *item;
    json_array_foreach(cases, i, item) {
        if (is_of(g, item) && !(parameter_of(item) < parameter) && !(parameter_of(item) > parameter))
            return text_at(item, "case");
    }
    return "";
}

static bool is_part_of_number(char c) {
    return isalnum((unsigned char)c) || c == '.' || c == '-' || c == '+';
}

/* Where the words hold the number as a word of its own; NULL: nowhere. */
static const char *find_number(const char *words, const char *plain) {
    size_t length = strlen(plain);
    for (const char *at = strstr(words, plain); at; at = strstr(at + 1, plain)) {
        if ((at == words || !is_part_of_number(at[-1])) && !is_part_of_number(at[length])) return at;
    }
    return NULL;
}

/* "a ball of radius 1e-08" of the first or the last case becomes "a ball of radius 10⁻⁸ to 10⁸" of all. False
 * where the words of neither hold the parameter: it then only numbers the cases. */
static bool words_of_all(const grid *g, const json_t *cases, char out[WORDS]) {
    double ends[2] = {g->columns.items[0], g->columns.items[g->columns.count - 1]};
    out[0] = '\0';
    for (int i = 0; i < 2; ++i) {
        const char *words = words_of(g, cases, ends[i]);
        char plain[32];
        snprintf(plain, sizeof plain, "%g", ends[i]);
        const char *at = find_number(words, plain);
        if (!at) continue;
        snprintf(out, WORDS, "%.*s%s to %s%s.", (int)(at - words), words, number_tick(ends[0]).text,
                 number_tick(ends[1]).text, at + strlen(plain));
        return true;
    }
    return false;
}

static void put_list(page *p, const grid *g, const json_t *cases) {
    page_put(p, "<ol>\n");
    for (size_t i = 0; i < g->columns.count; ++i) {
        page_put(p, "<li>");
        page_text(p, words_of(g, cases, g->columns.items[i]));
        page_put(p, "</li>\n");
    }
    page_put(p, "</ol>\n");
}

/* ---- the maps ---- */

/* The same on each page. Verdicts bound the constant by 16 to 64, by the shape; below 0.1 an answer is as
 * good as exact. */
static const heat_range range = {0.1, 100};

static void put_grid(page *p, const json_t *cases, const char *group) {
    grid g = {.group = group};
    if (fill(&g, cases)) {
        char words[WORDS];
        bool listed = !words_of_all(&g, cases, words);
        if (listed) page_put(p, "<div class=\"listed\">");
        heat h = {.title = group,
                  .summary =
                      "Rows are tracers, columns values of the parameter; the table below has the numbers.",
                  .caption = words,
                  .range = range,
                  .rows = g.rows.items,
                  .columns = g.columns.items,
                  .row_count = g.rows.count,
                  .column_count = g.columns.count,
                  .cells = g.cells};
        heat_put(p, &h);
        if (listed) {
            put_list(p, &g, cases);
            page_put(p, "</div>\n");
        }
    } else {
        p->lost = true;
    }
    grid_free(&g);
}

/* The first case of its group: groups are shown in the order in which they come. */
static bool is_first(const json_t *cases, size_t i) {
    const char *group = text_at(json_array_get(cases, i), "group");
    for (size_t k = 0; k < i; ++k) {
        if (strcmp(group, text_at(json_array_get(cases, k), "group")) == 0) return false;
    }
    return true;
}

static void put_case(page *p, const json_t *item) {
    bool ok = json_is_true(json_object_get(item, "ok"));
    table_row(p, text_at(item, "case"), false);
    table_code(p, text_at(item, "spec"));
    table_count(p, count_at(item, "rays"));
    table_marked(p, case_verdicts(item, "leak"), "leak");
    table_marked(p, case_verdicts(item, "wrong"), "bad");
    table_number(p, number_at(item, "constant"));
    page_put(p, ok ? "<td class=\"good\">ok</td>\n" : "<td class=\"bad\">failed</td>\n");
}

static void put_case_table(page *p, const json_t *cases) {
    page_put(p, "<details><summary>All cases with their numbers</summary>\n");
    table_begin(p, "Every extreme case");
    static const char *const columns[7] = {"case", "tracer", "rays", "leak", "wrong", "constant", ""};
    for (int c = 0; c < 7; ++c) table_column(p, columns[c], c > 1 && c < 6);
    table_body(p);
    for (size_t i = 0; i < json_array_size(cases); ++i) {
        if (!is_first(cases, i)) continue;
        const char *group = text_at(json_array_get(cases, i), "group");
        table_group(p, 7, "", group);
        for (size_t k = i; k < json_array_size(cases); ++k) {
            const json_t *item = json_array_get(cases, k);
            if (strcmp(text_at(item, "group"), group) == 0) put_case(p, item);
        }
    }
    table_end(p);
    page_put(p, "</details>\n");
}

void validate_extremes_put(page *p, const json_t *results) {
    const json_t *cases = json_object_get(results, "extremes");
    page_section(p, "extremes", "Extreme cases");
    if (!json_array_size(cases)) {
        put_absent(p, "Left out: these results have none; --extremes runs them.");
        return;
    }
    page_put(p, "<p>A map a kind of case: rows are tracers, columns go along the parameter. The colour is "
                "the largest "
                "error of t in units of the condition number times the unit roundoff, which the verdicts "
                "bound.</p>\n");
    heat_legend(p, &range, "constant");
    page_put(p, "<div class=\"figures\">\n");
    for (size_t i = 0; i < json_array_size(cases); ++i) {
        if (is_first(cases, i)) put_grid(p, cases, text_at(json_array_get(cases, i), "group"));
    }
    page_put(p, "</div>\n");
    put_case_table(p, cases);
}
