#include "report/bench_page.h"

#include "report/bench_parts.h"
#include "report/number.h"
#include "report/validate_parts.h"

#include <string.h>

static void put_fact(page *p, const char *name, const char *text) {
    if (!*text) return;
    page_put(p, "<dt>%s</dt><dd>", name);
    page_text(p, text);
    page_put(p, "</dd>\n");
}

static void put_number(page *p, const char *name, double x) {
    if (x == x) page_put(p, "<dt>%s</dt><dd>%s</dd>\n", name, number_of(x).text);
}

static void put_head(page *p, const json_t *results) {
    const json_t *machine = json_object_get(results, "machine");
    page_put(p, "<dl>\n");
    put_fact(p, "Scene", text_at(results, "scene"));
    put_number(p, "Threads", number_at(results, "threads"));
    put_number(p, "Repetitions", number_at(results, "repeats"));
    put_fact(p, "Fathom", text_at(results, "fathom"));
    put_fact(p, "Commit", text_at(results, "commit"));
    put_fact(p, "Processor", text_at(machine, "cpu"));
    put_number(p, "Processors", number_at(machine, "processors"));
    put_number(p, "Load at the start", number_at(machine, "load"));
    put_fact(p, "Embree", text_at(machine, "embree"));
    put_fact(p, "Compiler", text_at(machine, "compiler"));
    put_fact(p, "Flags", text_at(machine, "flags"));
    put_fact(p, "Date", text_at(results, "date"));
    page_put(p, "</dl>\n");
}

static const struct {
    const char *name, *title;
    void (*put)(page *p, const json_t *results);
} benches[] = {
    {"trace", "Fathom: rays a second of every tracer", bench_trace_put},
    {"render", "Fathom: the render phase against Embree\xe2\x80\x99s bare calls", bench_render_put},
    {"error", "Fathom: image error against run time", bench_error_put},
    {"build", "Fathom: build quality against time", bench_build_put},
    {"growth", "Fathom: reading, building and tracing by the number of triangles", bench_growth_put},
    {"secondary", "Fathom: secondary rays against single-ray calls", bench_secondary_put},
};

void bench_page(page *p, const json_t *results) {
    for (size_t i = 0; i < sizeof benches / sizeof *benches; ++i) {
        if (strcmp(benches[i].name, text_at(results, "bench")) != 0) continue;
        page_begin(p, benches[i].title);
        put_head(p, results);
        page_links(p);
        benches[i].put(p, results);
        page_end(p);
    }
}
