#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <math.h>
#include <string.h>

/* ---- verdicts ---- */

static const struct {
    const char *name, *meaning;
} meanings[] = {
    {"agree", "the exact hit or miss, t to the last places"},
    {"tie", "another primitive at the same t"},
    {"edge", "closer to an edge than the tracer\xe2\x80\x99s precision can tell"},
    {"range", "closer to an end of the interval than it can tell"},
    {"conditioned", "t off by no more than a bound: a constant times the condition number of that "
                    "intersection times the unit roundoff"},
    {"beyond", "numbers that leave the range of the tracer\xe2\x80\x99s floats"},
    {"leak", "what the tracer is known to miss: surfaces at edges and vertices"},
    {"wrong", "anything else"},
};

#define VERDICTS 16

/* The results say which verdicts there are, and in which order. */
typedef struct verdicts {
    const char *names[VERDICTS];
    size_t count;
} verdicts;

static verdicts verdicts_in(const json_t *runs) {
    json_t *family = json_array_get(json_object_get(json_array_get(runs, 0), "families"), 0);
    verdicts v = {.count = 0};
    const char *name;
    json_t *count;
    json_object_foreach(json_object_get(family, "verdicts"), name, count) {
        if (v.count < VERDICTS) v.names[v.count++] = name;
    }
    return v;
}

static void put_verdict(page *p, const char *name, uint64_t count) {
    table_marked(p, count, strcmp(name, "wrong") == 0 ? "bad" : strcmp(name, "leak") == 0 ? "leak" : "");
}

static void put_verdicts_of(page *p, const verdicts *v, const json_t *run, bool any) {
    for (size_t i = 0; i < v->count; ++i) put_verdict(p, v->names[i], verdicts_of(run, v->names[i], any));
}

static void put_meanings(page *p, const verdicts *v) {
    page_put(p, "<details><summary>What the verdicts and columns mean</summary>\n<dl>\n");
    for (size_t i = 0; i < v->count; ++i) {
        for (size_t k = 0; k < sizeof meanings / sizeof *meanings; ++k) {
            if (strcmp(meanings[k].name, v->names[i]) == 0)
                page_put(p, "<dt>%s</dt><dd>%s</dd>\n", meanings[k].name, meanings[k].meaning);
        }
    }
    page_put(
        p,
        "<dt>constant</dt><dd>the largest error of t over the condition number times the unit "
        "roundoff</dd>\n"
        "<dt>ulp</dt><dd>the error of t in units in the last place of t as a float: the median, what all but "
        "1 in 1000 rays do not exceed, the largest</dd>\n"
        "<dt>ns a ray</dt><dd>nanoseconds of tracing alone, one thread, closest hit</dd>\n"
        "</dl></details>\n");
}

/* ---- the runs ---- */

static double largest_constant(const json_t *run) {
    double most = (double)NAN;
    size_t i;
    json_t *family;
    json_array_foreach(json_object_get(run, "families"), i, family) most =
        fmax(most, number_at(json_object_get(family, "constant"), "value"));
    return most;
}

static void put_spread(page *p, const spread *s) {
    table_number(p, spread_quantile(s, 0.5));
    table_number(p, spread_quantile(s, 0.999));
    table_number(p, s->most);
}

static void put_run(page *p, const verdicts *v, const json_t *run) {
    spread sum = {.zeros = 0};
    size_t i;
    json_t *family;
    json_array_foreach(json_object_get(run, "families"), i, family) {
        spread_add(&sum, json_object_get(family, "tUlps"));
    }
    table_row(p, text_at(run, "scene"), false);
    table_count(p, rays_of(run));
    put_verdicts_of(p, v, run, false);
    table_number(p, largest_constant(run));
    put_spread(p, &sum);
    table_number(p, number_at(run, "nsPerRay"));
}

static void put_columns(page *p, const verdicts *v, const char *first) {
    table_column(p, first, false);
    table_column(p, "rays", true);
    for (size_t i = 0; i < v->count; ++i) table_column(p, v->names[i], true);
    table_column(p, "constant", true);
    table_column(p, "median ulp", true);
    table_column(p, "99.9\xe2\x80\xaf% ulp", true);
    table_column(p, "max ulp", true);
}

static void put_run_table(page *p, const verdicts *v, const json_t *runs) {
    table_begin(p, "Closest hits of each tracer in each scene, all families of rays");
    put_columns(p, v, "scene");
    table_column(p, "ns a ray", true);
    table_body(p);
    size_t i;
    json_t *run;
    json_array_foreach(runs, i, run) {
        if (i == 0 || !same_tracer(runs, i, i - 1))
            table_group(p, v->count + 7, text_at(run, "spec"), text_at(run, "tracer"));
        put_run(p, v, run);
    }
    table_end(p);
}

/* ---- families ---- */

/* One family of a tracer over all its scenes. */
static void put_family(page *p, const verdicts *v, const json_t *runs, size_t first, const char *name) {
    spread sum = {.zeros = 0};
    uint64_t rays = 0, counts[VERDICTS] = {0};
    double constant = (double)NAN;
    for (size_t r = first; r < json_array_size(runs) && same_tracer(runs, r, first); ++r) {
        size_t i;
        json_t *family;
        json_array_foreach(json_object_get(json_array_get(runs, r), "families"), i, family) {
            if (strcmp(text_at(family, "family"), name) != 0) continue;
            rays += count_at(family, "rays");
            for (size_t k = 0; k < v->count; ++k)
                counts[k] += count_at(json_object_get(family, "verdicts"), v->names[k]);
            constant = fmax(constant, number_at(json_object_get(family, "constant"), "value"));
            spread_add(&sum, json_object_get(family, "tUlps"));
        }
    }
    table_row(p, name, false);
    table_count(p, rays);
    for (size_t k = 0; k < v->count; ++k) put_verdict(p, v->names[k], counts[k]);
    table_number(p, constant);
    put_spread(p, &sum);
}

static void put_families(page *p, const verdicts *v, const json_t *runs) {
    page_put(p, "<details><summary>By family of rays</summary>\n");
    table_begin(p, "Closest hits of each tracer by family of rays, all scenes");
    put_columns(p, v, "family");
    table_body(p);
    size_t i, k;
    json_t *run, *family;
    json_array_foreach(runs, i, run) {
        if (i > 0 && same_tracer(runs, i, i - 1)) continue;
        table_group(p, v->count + 6, text_at(run, "spec"), text_at(run, "tracer"));
        json_array_foreach(json_object_get(run, "families"), k, family) {
            put_family(p, v, runs, i, text_at(family, "family"));
        }
    }
    table_end(p);
    page_put(p, "</details>\n");
}

/* ---- any hit ---- */

static void put_any(page *p, const verdicts *v, const json_t *runs) {
    uint64_t all = 0;
    size_t i;
    json_t *run;
    json_array_foreach(runs, i, run) {
        for (size_t k = 0; k < v->count; ++k) all += verdicts_of(run, v->names[k], true);
    }
    if (!all) return;
    page_put(p, "<details><summary>Any-hit queries</summary>\n");
    table_begin(p, "Whether anything is met, as shadow rays ask");
    table_column(p, "scene", false);
    for (size_t k = 0; k < v->count; ++k) table_column(p, v->names[k], true);
    table_body(p);
    json_array_foreach(runs, i, run) {
        if (i == 0 || !same_tracer(runs, i, i - 1))
            table_group(p, v->count + 1, text_at(run, "spec"), text_at(run, "tracer"));
        table_row(p, text_at(run, "scene"), false);
        put_verdicts_of(p, v, run, true);
    }
    table_end(p);
    page_put(p, "</details>\n");
}

/* ---- errors of other things than t ---- */

static const struct {
    const char *key, *name;
} others[] = {{"tRelative", "t, relative to the scene\xe2\x80\x99s size"},
              {"position", "position, ulp"},
              {"normal", "normal, ulp"},
              {"uv", "u and v, ulp"}};
#define OTHERS (sizeof others / sizeof *others)

static void put_other(page *p, const json_t *runs, size_t first, size_t which) {
    spread sum = {.zeros = 0};
    for (size_t r = first; r < json_array_size(runs) && same_tracer(runs, r, first); ++r) {
        size_t i;
        json_t *family;
        json_array_foreach(json_object_get(json_array_get(runs, r), "families"), i, family) {
            spread_add(&sum, json_object_get(family, others[which].key));
        }
    }
    if (!sum.total) return;
    table_row(p, others[which].name, false);
    put_spread(p, &sum);
}

static void put_others(page *p, const json_t *runs) {
    const json_t *family = json_array_get(json_object_get(json_array_get(runs, 0), "families"), 0);
    if (!json_object_get(json_object_get(family, "tRelative"), "histogram")) return;
    page_put(p, "<details><summary>Errors of position, normal and uv</summary>\n");
    table_begin(p, "Errors over all scenes and families");
    table_column(p, "error of", false);
    table_column(p, "median", true);
    table_column(p, "99.9\xe2\x80\xaf%", true);
    table_column(p, "max", true);
    table_body(p);
    for (size_t i = 0; i < json_array_size(runs); ++i) {
        const json_t *run = json_array_get(runs, i);
        if (i > 0 && same_tracer(runs, i, i - 1)) continue;
        table_group(p, 4, text_at(run, "spec"), text_at(run, "tracer"));
        for (size_t k = 0; k < OTHERS; ++k) put_other(p, runs, i, k);
    }
    table_end(p);
    page_put(p, "</details>\n");
}

void validate_runs_put(page *p, const json_t *results) {
    const json_t *runs = json_object_get(results, "runs");
    page_section(p, "runs", "Tracers and scenes");
    if (!json_array_size(runs)) {
        put_absent(p, "No tracer was run on families of rays.");
        return;
    }
    verdicts v = verdicts_in(runs);
    put_run_table(p, &v, runs);
    put_meanings(p, &v);
    put_families(p, &v, runs);
    put_any(p, &v, runs);
    put_others(p, runs);
    validate_leaks_put(p, runs);
}
