#include "report/validate_page.h"

#include "report/number.h"
#include "report/validate_parts.h"

#include <math.h>
#include <string.h>

/* ---- what came of it ---- */

typedef struct outcome {
    uint64_t rays, wrong, leaks, cases, cases_bad, shading, shading_bad;
} outcome;

static void add_cases(outcome *o, const json_t *results) {
    size_t i;
    json_t *item;
    json_array_foreach(json_object_get(results, "extremes"), i, item) {
        o->rays += count_at(item, "rays"), ++o->cases;
        o->leaks += case_verdicts(item, "leak");
        o->cases_bad += !json_is_true(json_object_get(item, "ok"));
    }
    json_array_foreach(json_object_get(results, "shading"), i, item) {
        ++o->shading, o->shading_bad += !json_is_true(json_object_get(item, "ok"));
    }
}

static outcome outcome_of(const json_t *results) {
    outcome o = {.rays = 0};
    size_t i;
    json_t *run;
    json_array_foreach(json_object_get(results, "runs"), i, run) {
        o.rays += rays_of(run);
        for (int any = 0; any < 2; ++any) {
            o.wrong += verdicts_of(run, "wrong", any);
            o.leaks += verdicts_of(run, "leak", any);
        }
    }
    add_cases(&o, results);
    return o;
}

static void put_verdict(page *p, const outcome *o) {
    bool good = !o->wrong && !o->cases_bad && !o->shading_bad;
    page_put(p, "<p class=\"verdict %s\">", good ? "good" : "bad");
    if (good) page_put(p, "Nothing wrong");
    const char *between = "";
    if (o->wrong)
        page_put(p, "%s answer%s wrong", number_count(o->wrong).text, o->wrong == 1 ? "" : "s"),
            between = ", ";
    if (o->cases_bad)
        page_put(p, "%s%s of %s extreme cases failed", between, number_count(o->cases_bad).text,
                 number_count(o->cases).text),
            between = ", ";
    if (o->shading_bad)
        page_put(p, "%s%s of %s shading cases out of bounds", between, number_count(o->shading_bad).text,
                 number_count(o->shading).text);
    page_put(p, " in %s rays", number_count(o->rays).text);
    if (o->leaks) page_put(p, "; %s tracer leak%s", number_count(o->leaks).text, o->leaks == 1 ? "" : "s");
    page_put(p, ".</p>\n");
}

/* ---- the head ---- */

static void put_fact(page *p, const char *name, const char *text) {
    if (!*text) return;
    page_put(p, "<dt>%s</dt><dd>", name);
    page_text(p, text);
    page_put(p, "</dd>\n");
}

/* The different values of a key of the runs, in order. */
static void put_values(page *p, const char *name, const json_t *runs, const char *key, bool code) {
    page_put(p, "<dt>%s</dt><dd>", name);
    size_t i;
    json_t *run;
    bool first = true;
    json_array_foreach(runs, i, run) {
        const char *text = text_at(run, key);
        bool seen = false;
        for (size_t k = 0; k < i && !seen; ++k)
            seen = strcmp(text, text_at(json_array_get(runs, k), key)) == 0;
        if (seen) continue;
        page_put(p, "%s%s", first ? "" : ", ", code ? "<code>" : "");
        page_text(p, text);
        page_put(p, "%s", code ? "</code>" : "");
        first = false;
    }
    page_put(p, "</dd>\n");
}

static void put_machine(page *p, const json_t *machine) {
    if (!machine) return;
    put_fact(p, "Processor", text_at(machine, "cpu"));
    uint64_t threads = count_at(machine, "threads");
    if (threads) page_put(p, "<dt>Threads</dt><dd>%s</dd>\n", number_count(threads).text);
    put_fact(p, "Embree", text_at(machine, "embree"));
    put_fact(p, "Compiler", text_at(machine, "compiler"));
}

static void put_head(page *p, const json_t *results) {
    const json_t *runs = json_object_get(results, "runs");
    page_put(p, "<dl>\n");
    if (json_array_size(runs)) {
        put_values(p, "Scenes", runs, "scene", false);
        put_values(p, "Tracers", runs, "spec", true);
    }
    put_fact(p, "Fathom", text_at(results, "fathom"));
    put_machine(p, json_object_get(results, "machine"));
    put_fact(p, "Date", text_at(results, "date"));
    page_put(p, "<dt>Rays</dt><dd>%s of each family, scene and tracer; seed %s</dd>\n",
             number_count(count_at(results, "raysPerFamily")).text,
             number_count(count_at(results, "seed")).text);
    page_put(p,
             "<dt>Exit code</dt><dd>0 when nothing is wrong, 1 otherwise. Leaks are faults that a tracer is "
             "known for; they are counted, and are not wrong.</dd>\n</dl>\n");
}

/* ---- pictures ---- */

static bool is_base64(const char *text) {
    return text[strspn(text, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/=")] == '\0';
}

static void put_picture(page *p, const json_t *image) {
    const char *png = text_at(image, "png");
    if (!*png || !is_base64(png)) return;
    page_put(p, "<figure class=\"mark\">\n<h3>");
    page_text(p, text_at(image, "title"));
    page_put(p, "</h3>\n<img alt=\"");
    page_text(p, text_at(image, "title"));
    page_put(p, "\" src=\"data:image/png;base64,%s\">\n<figcaption>", png);
    page_text(p, text_at(image, "caption"));
    page_put(p, "</figcaption>\n</figure>\n");
}

static void put_pictures(page *p, const json_t *results) {
    page_section(p, "images", "Images");
    const json_t *images = json_object_get(results, "images");
    if (!json_array_size(images)) {
        put_absent(p, "No images: --extremes renders the demo scene at Earth\xe2\x80\x99s radius.");
        return;
    }
    page_put(p, "<div class=\"figures pictures\" data-marks=\"%zu\">\n", json_array_size(images));
    size_t i;
    json_t *image;
    json_array_foreach(images, i, image) put_picture(p, image);
    page_put(p, "</div>\n");
}

void validate_page(page *p, const json_t *results) {
    outcome o = outcome_of(results);
    page_begin(p, "Fathom: tracers against exact arithmetic");
    put_verdict(p, &o);
    put_head(p, results);
    page_links(p);
    validate_runs_put(p, results);
    validate_failures_put(p, results);
    validate_plots_put(p, results);
    validate_extremes_put(p, results);
    validate_shading_put(p, results);
    put_pictures(p, results);
    page_end(p);
}
