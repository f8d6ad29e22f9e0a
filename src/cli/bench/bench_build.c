/* `fathom bench build`: the quality of Embree's build against time. */
#include "cli/bench/bench.h"
#include "cli/bench/bench_output.h"
#include "cli/bench/bench_run.h"
#include "cli/json_text.h"
#include "cli/render/progress.h"

#include "measure/build_time.h"

#include <math.h>

typedef struct bench_build_settings {
    const char *scene, *tracer;
    args_size size;
    uint32_t spp, repeats;
    unsigned threads;
    bool quiet;
    bench_output output;
    bool allow_outside;
} bench_build_settings;

static const char *const clock_names[BENCH_CLOCKS] = {"cpu", "wall"};

/* ---- the object ---- */

static json_t *pack_quality(const quality_time *q) {
    json_t *ranges = json_object();
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        bool never = !(q->from[c] < q->to[c]);
        json_t *to = isinf(q->to[c]) ? json_null() : json_real(q->to[c]);
        json_object_set_new(ranges, clock_names[c],
                            never ? json_null() : json_pack("[f, O]", q->from[c], to));
        json_decref(to);
    }
    return json_pack("{s:s, s:o, s:o, s:o, s:f, s:o, s:o, s:o}", "quality", q->name, "buildSeconds",
                     bench_clocks(q->build), "sampleSeconds", bench_clocks(q->sample), "raysOfASample",
                     json_count(q->rays), "millionRaysPerSecond",
                     1e-6 * (double)q->rays / q->sample[BENCH_WALL].median, "bvhBytes",
                     json_count(q->bvh_bytes), "bvhPeakBytes", json_count(q->peak_bytes), "bestFromToSpp",
                     ranges);
}

static json_t *pack_total(const build_time *result, const build_total *t) {
    json_t *object =
        json_pack("{s:i, s:s}", "spp", (int)t->spp, "automatic", result->qualities[t->automatic].name);
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        json_t *seconds = json_object();
        for (unsigned q = 0; q < BUILD_QUALITIES; ++q)
            json_object_set_new(seconds, result->qualities[q].name, json_real(t->seconds[q][c]));
        json_object_set_new(object, clock_names[c],
                            json_pack("{s:o, s:s, s:f}", "seconds", seconds, "best",
                                      result->qualities[t->best[c]].name, "automaticBehind", t->behind[c]));
    }
    return object;
}

static json_t *pack(const bench_build_settings *asked, const bench_stage *stage, const build_time *result) {
    json_t *root = bench_head("build"), *qualities = json_array(), *totals = json_array();
    bench_head_tracer(root, trace_name(stage->tracer));
    for (unsigned q = 0; q < BUILD_QUALITIES; ++q)
        json_array_append_new(qualities, pack_quality(&result->qualities[q]));
    for (unsigned i = 0; i < BUILD_TOTALS; ++i)
        json_array_append_new(totals, pack_total(result, &result->totals[i]));
    json_object_set_new(root, "scene", json_text(asked->scene));
    json_object_set_new(root, "spec", json_text(asked->tracer));
    json_object_set_new(root, "triangles", json_count(scene_triangles(stage->scene)));
    json_object_set_new(root, "width", json_count(stage->settings.width));
    json_object_set_new(root, "height", json_count(stage->settings.height));
    json_object_set_new(root, "spp", json_count(asked->spp));
    json_object_set_new(root, "repeats", json_count(asked->repeats));
    json_object_set_new(root, "qualities", qualities);
    json_object_set_new(root, "totals", totals);
    return root;
}

static void put_csv(FILE *out, const json_t *root) {
    fputs("quality,build_cpu_seconds,build_seconds,sample_cpu_seconds,sample_seconds,bvh_bytes,bvh_peak_"
          "bytes\n",
          out);
    size_t i;
    json_t *q;
    json_array_foreach(json_object_get(root, "qualities"), i, q) {
        fputs(json_string_value(json_object_get(q, "quality")), out);
        static const char *const keys[] = {"buildSeconds", "sampleSeconds"};
        for (int k = 0; k < 2; ++k) {
            const json_t *clocks = json_object_get(q, keys[k]);
            for (int c = 0; c < BENCH_CLOCKS; ++c)
                fprintf(out, ",%.6g", bench_number(clocks, clock_names[c], "median"));
        }
        fprintf(out, ",%.0f,%.0f\n", bench_number(q, "bvhBytes", NULL),
                bench_number(q, "bvhPeakBytes", NULL));
    }
}

/* ---- the table ---- */

static void print_range(const quality_time *q, int clock) {
    char text[48] = "never";
    if (q->from[clock] < q->to[clock] && isinf(q->to[clock]))
        snprintf(text, sizeof text, "from %.3g", q->from[clock]);
    else if (q->from[clock] < q->to[clock])
        snprintf(text, sizeof text, "%.3g to %.3g", q->from[clock], q->to[clock]);
    printf("  %16s", text);
}

static void print(const bench_stage *stage, const build_time *result) {
    printf("%s, %ux%u\n\n%-8s %9s %9s %9s %9s %9s %9s %9s  %16s  %16s\n", trace_name(stage->tracer),
           stage->settings.width, stage->settings.height, "quality", "build cpu", "clock s", "a sample,",
           "clock s", "Mrays/s", "BVH MB", "at most", "best spp, by cpu", "by the clock");
    for (unsigned i = 0; i < BUILD_QUALITIES; ++i) {
        const quality_time *q = &result->qualities[i];
        printf("%-8s %9.4g %9.4g %9.4g %9.4g %9.3g %9.4g %9.4g", q->name, q->build[BENCH_CPU].median,
               q->build[BENCH_WALL].median, q->sample[BENCH_CPU].median, q->sample[BENCH_WALL].median,
               1e-6 * (double)q->rays / q->sample[BENCH_WALL].median, 1e-6 * (double)q->bvh_bytes,
               1e-6 * (double)q->peak_bytes);
        for (int c = 0; c < BENCH_CLOCKS; ++c) print_range(q, c);
        putchar('\n');
    }
    printf("\n%-6s %9s %9s %9s  %-8s %-10s %s\n", "spp", "low", "medium", "high", "best", "automatic",
           "behind the best (CPU seconds of build and render)");
    for (unsigned i = 0; i < BUILD_TOTALS; ++i) {
        const build_total *t = &result->totals[i];
        printf("%-6u", t->spp);
        for (unsigned q = 0; q < BUILD_QUALITIES; ++q) printf(" %9.4g", t->seconds[q][BENCH_CPU]);
        printf("  %-8s %-10s %.1f %%\n", result->qualities[t->best[BENCH_CPU]].name,
               result->qualities[t->automatic].name, 100 * t->behind[BENCH_CPU]);
    }
}

/* ---- the command ---- */

static fathom_status check_tracer(fathom_context *context, const char *words) {
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, words, &spec);
    if (status != FATHOM_OK || (spec.kind == TRACE_EMBREE && spec.quality == TRACE_QUALITY_AUTO))
        return status;
    return fail(context, FATHOM_BAD_USAGE, "--tracer: expected embree without a quality, found \"%.60s\"",
                words);
}

static fathom_status bench(fathom_context *context, const void *user) {
    const bench_build_settings *asked = user;
    bench_stage stage = {.scene = NULL};
    build_time result;
    fathom_status status = check_tracer(context, asked->tracer);
    if (status == FATHOM_OK) status = bench_output_check(context, &asked->output, asked->scene);
    bench_progress_begin(asked->quiet);
    const bench_watch watch = bench_progress_part(0, 1);
    if (status == FATHOM_OK) status = bench_open(context, asked->scene, asked->size, &stage);
    if (status == FATHOM_OK)
        status =
            build_time_measure(context, &stage, asked->tracer, asked->repeats, asked->spp, &watch, &result);
    progress_clear_line();
    if (status == FATHOM_OK) status = fathom_scene_check_files(stage.scene);
    if (status == FATHOM_OK) {
        if (!asked->quiet) print(&stage, &result);
        json_t *root = pack(asked, &stage, &result);
        status =
            root ? bench_output_write(context, &asked->output, root, put_csv) : fail_memory(context, 4096);
        json_decref(root);
    }
    stage_close(&stage);
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_build_settings asked = {.tracer = "embree", .spp = 4, .repeats = 5};
    fathom_status status;
    if (!command_parse(&command_bench_build, argc, argv, &asked, &status)) return status;
    return bench_run(&command_bench_build, asked.threads, asked.allow_outside, bench, &asked);
}

#define FIELD(name) offsetof(bench_build_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_text, FIELD(tracer), 0, 0,
     "Embree in words without a quality, such as embree:default (embree)"},
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536, "pixels (the scene's, else 1280x720)"},
    {"spp", 0, "N", take_u32, FIELD(spp), 1, 65536, "samples a pixel of each render (4)"},
    {"repeats", 0, "N", take_u32, FIELD(repeats), 1, BUILD_REPEATS_MAX, "of which medians are told (5)"},
    {"threads", 0, "N", take_u32, FIELD(threads), 1, 1024, "1 to 1024 (one a processor)"},
    COMMAND_ALLOW_OUTSIDE(bench_build_settings),
    BENCH_OUTPUT_OPTIONS(bench_build_settings),
    {.help = NULL},
};
static const char *const operands[] = {"SCENE"};
static const size_t operand_offsets[] = {FIELD(scene)};

const command command_bench_build = {
    .name = "bench build",
    .usage = "SCENE [options]",
    .summary = "Measure what build quality costs and saves.",
    .text = "Builds by low, medium and high quality and renders with each, in turn. From the\n"
            "medians: for which number of samples a pixel each is the fastest, build and\n"
            "render together, and how far the automatic choice is behind the best.\n",
    .examples = "  fathom bench build heavy.glb --report results\n",
    .args = {options, operands, operand_offsets, 1},
    .run = run,
};
