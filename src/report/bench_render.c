#include "report/bench_parts.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <stdio.h>

static double inner(const json_t *object, const char *key, const char *name) {
    return number_at(json_object_get(object, key), name);
}

static void put_spp(page *p, const json_t *run) {
    char name[32];
    snprintf(name, sizeof name, "%.0f", number_at(run, "spp"));
    table_row(p, name, false);
}

static void put_columns(page *p, const char *const *names) {
    for (; *names; ++names) table_column(p, *names, true);
    table_body(p);
}

static void put_ceiling(page *p, const json_t *runs) {
    static const char *const columns[] = {"samples a pixel",
                                          "bare calls, s",
                                          "render over bare",
                                          "lower quartile",
                                          "upper quartile",
                                          "tracer over bare",
                                          "rays",
                                          NULL};
    page_section(p, "ceiling", "Against the bare calls");
    page_put(
        p,
        "<p>Embree\xe2\x80\x99s calls alone over the rays of the same render, by one thread; render is all "
        "of the render phase: rays made, traced, shaded and filmed. Each ratio is a median over "
        "repetitions that took turns.</p>\n");
    table_begin(p, "Processor time of the render phase over that of the bare calls");
    put_columns(p, columns);
    size_t i;
    json_t *run;
    json_array_foreach(runs, i, run) {
        const json_t *c = json_object_get(run, "ceiling");
        if (!json_is_object(c)) continue;
        put_spp(p, run);
        table_number(p, inner(c, "bareCpuSeconds", "median"));
        table_number(p, inner(c, "renderToBare", "median"));
        table_number(p, inner(c, "renderToBare", "low"));
        table_number(p, inner(c, "renderToBare", "high"));
        table_number(p, inner(c, "tracedToBare", "median"));
        table_count(p, count_at(c, "closestRays") + count_at(c, "anyRays"));
    }
    table_end(p);
}

static void put_speeds(page *p, const json_t *runs) {
    static const char *const columns[] = {"samples a pixel",
                                          "threads",
                                          "seconds",
                                          "lower quartile",
                                          "upper quartile",
                                          "processor seconds",
                                          "million rays a second",
                                          "speedup",
                                          "speedup of bare calls",
                                          NULL};
    page_section(p, "threads", "The render phase by threads");
    table_begin(p, "Seconds by the clock, medians and quartiles");
    put_columns(p, columns);
    size_t i, k;
    json_t *run, *s;
    json_array_foreach(runs, i, run) {
        json_array_foreach(json_object_get(run, "speeds"), k, s) {
            put_spp(p, run);
            table_count(p, count_at(s, "threads"));
            table_number(p, inner(s, "seconds", "median"));
            table_number(p, inner(s, "seconds", "low"));
            table_number(p, inner(s, "seconds", "high"));
            table_number(p, inner(s, "cpuSeconds", "median"));
            table_number(p, number_at(s, "millionRaysPerSecond"));
            table_number(p, inner(s, "speedup", "median"));
            table_number(p, inner(s, "bareSpeedup", "median"));
        }
    }
    table_end(p);
}

static void put_phases(page *p, const json_t *runs) {
    static const char *const columns[] = {"samples a pixel", "read",      "build",       "plan",
                                          "render",          "write",     "camera rays", "shadow rays",
                                          "reflected",       "refracted", NULL};
    page_section(p, "phases", "Phases and rays");
    table_begin(p, "Seconds of each phase, and rays by kind");
    put_columns(p, columns);
    size_t i;
    json_t *run;
    json_array_foreach(runs, i, run) {
        static const char *const phases[] = {"read", "build", "plan", "render", "write"};
        static const char *const kinds[] = {"camera", "shadow", "reflection", "refraction"};
        put_spp(p, run);
        for (int k = 0; k < 5; ++k) table_number(p, inner(run, "seconds", phases[k]));
        for (int k = 0; k < 4; ++k) table_count(p, count_at(json_object_get(run, "rays"), kinds[k]));
    }
    table_end(p);
}

void bench_render_put(page *p, const json_t *results) {
    const json_t *runs = json_object_get(results, "runs");
    put_ceiling(p, runs);
    put_speeds(p, runs);
    put_phases(p, runs);
}
