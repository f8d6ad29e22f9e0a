#include "report/table.h"
#include "report/validate_parts.h"

#include <string.h>

static uint64_t leaks_of(const json_t *run, const char *family) {
    uint64_t sum = 0;
    size_t i;
    json_t *item;
    json_array_foreach(json_object_get(run, "families"), i, item) {
        if (strcmp(text_at(item, "family"), family) == 0)
            sum += count_at(json_object_get(item, "verdicts"), "leak");
    }
    return sum;
}

/* Of a tracer in all its scenes, from the run `first` on; family NULL: of all. */
static uint64_t sum_leaks(const json_t *runs, size_t first, const char *family) {
    uint64_t sum = 0;
    for (size_t i = first; i < json_array_size(runs) && same_tracer(runs, i, first); ++i) {
        const json_t *run = json_array_get(runs, i);
        sum += family ? leaks_of(run, family) : verdicts_of(run, "leak", false);
    }
    return sum;
}

static void put_leak_row(page *p, const json_t *runs, size_t first, const char *const *families,
                         size_t count) {
    const json_t *run = json_array_get(runs, first);
    uint64_t rays = 0, leaks = sum_leaks(runs, first, NULL);
    if (!leaks) return;
    for (size_t i = first; i < json_array_size(runs) && same_tracer(runs, i, first); ++i)
        rays += rays_of(json_array_get(runs, i));
    table_row(p, text_at(run, "spec"), true);
    table_words(p, text_at(run, "isa"));
    for (size_t k = 0; k < count; ++k) table_marked(p, sum_leaks(runs, first, families[k]), "leak");
    table_count(p, leaks);
    table_number(p, 100 * (double)leaks / (double)rays);
}

#define FAMILIES 32

/* Those in which something leaks, in the order of the runs. */
static size_t leaking_families(const json_t *runs, const char *out[FAMILIES]) {
    size_t count = 0, i, k;
    json_t *run, *family;
    json_array_foreach(runs, i, run) {
        json_array_foreach(json_object_get(run, "families"), k, family) {
            const char *name = text_at(family, "family");
            size_t at = 0;
            while (at < count && strcmp(out[at], name) != 0) ++at;
            if (at == count && count < FAMILIES && leaks_of(run, name)) out[count++] = name;
        }
    }
    return count;
}

void validate_leaks_put(page *p, const json_t *runs) {
    const char *families[FAMILIES];
    size_t count = leaking_families(runs, families);
    page_section(p, "leaks", "Tracer leaks");
    if (!count) {
        put_absent(p, "None: no tracer missed what it is known to miss.");
        return;
    }
    page_put(
        p,
        "<p>Surfaces that a tracer missed at an edge or a vertex, where they go on at the other side. Which "
        "rays leak depends on the instructions that the tracer was built for.</p>\n");
    table_begin(p, "Leaks by tracer and family of rays, all scenes");
    table_column(p, "tracer", false);
    table_column(p, "instructions", false);
    for (size_t k = 0; k < count; ++k) table_column(p, families[k], true);
    table_column(p, "all", true);
    table_column(p, "% of rays", true);
    table_body(p);
    for (size_t i = 0; i < json_array_size(runs); ++i) {
        if (i == 0 || !same_tracer(runs, i, i - 1)) put_leak_row(p, runs, i, families, count);
    }
    table_end(p);
}

/* ---- failing rays ---- */

#define SHOWN 20

void validate_failures_put(page *p, const json_t *results) {
    size_t i, k, shown = 0;
    json_t *run, *line;
    json_array_foreach(json_object_get(results, "runs"), i, run) {
        json_array_foreach(json_object_get(run, "failures"), k, line) {
            const char *text = json_string_value(line);
            if (!text || shown == SHOWN) continue;
            if (!shown++) {
                page_section(p, "failures", "Failing rays");
                page_put(
                    p, "<p>The first ones. Saved to a file, <code>fathom validate --replay FILE</code> asks "
                       "them again, each alone; <code>--failures FILE</code> writes all of them.</p>\n<pre>");
            }
            page_text(p, text);
            page_put(p, "\n");
        }
    }
    if (shown) page_put(p, "</pre>\n");
}
