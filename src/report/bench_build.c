#include "report/bench_parts.h"
#include "report/number.h"
#include "report/table.h"
#include "report/validate_parts.h"

#include <stdio.h>

static const char *const clocks[2][2] = {{"cpu", "processor"}, {"wall", "clock"}};

static double median_at(const json_t *quality, const char *key, const char *clock) {
    return number_at(json_object_get(json_object_get(quality, key), clock), "median");
}

/* "2.1 to 30", "30 and more", "never" */
static void put_range(page *p, const json_t *quality, const char *clock) {
    const json_t *range = json_object_get(json_object_get(quality, "bestFromToSpp"), clock);
    char text[120] = "never";
    const json_t *to = json_array_get(range, 1);
    if (json_is_array(range) && json_is_number(to))
        snprintf(text, sizeof text, "%s to %s", number_of(json_number_value(json_array_get(range, 0))).text,
                 number_of(json_number_value(to)).text);
    else if (json_is_array(range))
        snprintf(text, sizeof text, "%s and more",
                 number_of(json_number_value(json_array_get(range, 0))).text);
    table_words(p, text);
}

static void put_qualities(page *p, const json_t *results) {
    page_section(p, "qualities", "What each quality costs and saves");
    page_put(p,
             "<p>Medians over repetitions that took turns; a sample is one a pixel, over %.0f \xc3\x97 %.0f "
             "pixels. The fastest is by build and render together.</p>\n",
             number_at(results, "width"), number_at(results, "height"));
    table_begin(p, "Build quality against time");
    table_column(p, "quality", false);
    static const char *const names[] = {"build, processor s", "build, clock s", "a sample, processor s",
                                        "a sample, clock s",  "Mrays/s",        "BVH, bytes",
                                        "while built, bytes"};
    for (size_t i = 0; i < sizeof names / sizeof *names; ++i) table_column(p, names[i], true);
    table_column(p, "fastest at spp, processor", false);
    table_column(p, "fastest at spp, clock", false);
    table_body(p);
    size_t i;
    json_t *q;
    json_array_foreach(json_object_get(results, "qualities"), i, q) {
        table_row(p, text_at(q, "quality"), false);
        for (int c = 0; c < 2; ++c) table_number(p, median_at(q, "buildSeconds", clocks[c][0]));
        for (int c = 0; c < 2; ++c) table_number(p, median_at(q, "sampleSeconds", clocks[c][0]));
        table_number(p, number_at(q, "millionRaysPerSecond"));
        table_count(p, count_at(q, "bvhBytes"));
        table_count(p, count_at(q, "bvhPeakBytes"));
        for (int c = 0; c < 2; ++c) put_range(p, q, clocks[c][0]);
    }
    table_end(p);
}

static void put_totals(page *p, const json_t *results, int clock) {
    char caption[80];
    snprintf(caption, sizeof caption, "Build and render, %s seconds", clocks[clock][1]);
    table_begin(p, caption);
    table_column(p, "samples a pixel", false);
    static const char *const names[] = {"low", "medium", "high"};
    for (int k = 0; k < 3; ++k) table_column(p, names[k], true);
    table_column(p, "best", false);
    table_column(p, "automatic", false);
    table_column(p, "behind the best, %", true);
    table_body(p);
    size_t i;
    json_t *t;
    json_array_foreach(json_object_get(results, "totals"), i, t) {
        const json_t *by = json_object_get(t, clocks[clock][0]);
        table_row(p, number_of(number_at(t, "spp")).text, false);
        for (int k = 0; k < 3; ++k) table_number(p, number_at(json_object_get(by, "seconds"), names[k]));
        table_words(p, text_at(by, "best"));
        table_words(p, text_at(t, "automatic"));
        table_number(p, 100 * number_at(by, "automaticBehind"));
    }
    table_end(p);
}

void bench_build_put(page *p, const json_t *results) {
    put_qualities(p, results);
    page_section(p, "totals", "By samples a pixel");
    for (int c = 0; c < 2; ++c) put_totals(p, results, c);
}
