#include "report/table.h"

#include "report/number.h"

#include <math.h>

void table_begin(page *p, const char *caption) {
    page_put(p, "<div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"");
    page_text(p, caption);
    page_put(p, "\"><table>\n<caption>");
    page_text(p, caption);
    page_put(p, "</caption>\n<thead><tr>\n");
}

void table_column(page *p, const char *name, bool numbers) {
    page_put(p, "<th scope=\"col\"%s>", numbers ? " class=\"n\"" : "");
    page_text(p, name);
    page_put(p, "</th>\n");
}

void table_body(page *p) { page_put(p, "</tr></thead>\n"); }

void table_group(page *p, size_t columns, const char *code, const char *words) {
    page_put(p, "<tbody>\n<tr class=\"group\"><th scope=\"rowgroup\" colspan=\"%zu\"><code>", columns);
    page_text(p, code);
    page_put(p, "</code> ");
    page_text(p, words);
    page_put(p, "</th></tr>\n");
}

/* HTML closes rows, cells and groups of rows by itself. */
void table_row(page *p, const char *name, bool code) {
    page_put(p, "<tr><th scope=\"row\">%s", code ? "<code>" : "");
    page_text(p, name);
    page_put(p, "%s</th>\n", code ? "</code>" : "");
}

void table_words(page *p, const char *text) {
    page_put(p, "<td>");
    page_text(p, text);
    page_put(p, "</td>\n");
}

void table_code(page *p, const char *text) {
    page_put(p, "<td><code>");
    page_text(p, text);
    page_put(p, "</code></td>\n");
}

void table_number(page *p, double x) {
    page_put(p, "<td class=\"n\">%s</td>\n", isnan(x) ? "" : number_of(x).text);
}

void table_exact(page *p, double x) {
    page_put(p, isnan(x) ? "<td class=\"n\"></td>\n" : "<td class=\"n\">%.9g</td>\n", x);
}

void table_count(page *p, uint64_t n) {
    page_put(p, n ? "<td class=\"n\">%s</td>\n" : "<td class=\"n zero\">%s</td>\n",
             n ? number_count(n).text : "0");
}

void table_marked(page *p, uint64_t n, const char *class) {
    if (n)
        page_put(p, "<td class=\"n %s\">%s</td>\n", class, number_count(n).text);
    else
        table_count(p, 0);
}

void table_end(page *p) { page_put(p, "</table></div>\n"); }
