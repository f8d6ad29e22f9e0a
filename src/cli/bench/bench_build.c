/* `fathom bench build`: the quality of Embree's build against time. */
#include "cli/bench/bench.h"

#include "base/status.h"
#include "measure/build_time.h"

#include <math.h>

typedef struct bench_build_settings {
    bench_settings all;
    uint32_t spp;
} bench_build_settings;

/* ---- the object ---- */

/* [from, to], null where another quality is always faster; to: null where there is no end. */
static json_t *pack_range(const quality_time *q, int clock) {
    if (!(q->from[clock] < q->to[clock])) return json_null();
    return json_pack("[f, o]", q->from[clock], json_number(q->to[clock]));
}

static json_t *pack_quality(const quality_time *q) {
    json_t *ranges = json_of(JSON("cpu", pack_range(q, BENCH_CPU)), JSON("wall", pack_range(q, BENCH_WALL)));
    return json_of(JSON("quality", q->name), JSON("buildSeconds", bench_clocks(q->build)),
                   JSON("sampleSeconds", bench_clocks(q->sample)), JSON("raysOfASample", q->rays),
                   JSON("millionRaysPerSecond", 1e-6 * (double)q->rays / q->sample[BENCH_WALL].median),
                   JSON("bvhBytes", q->bvh_bytes), JSON("bvhPeakBytes", q->peak_bytes),
                   JSON("bestFromToSpp", ranges));
}

static json_t *pack_total(const build_time *result, const build_total *t) {
    json_t *object = json_of(JSON("spp", t->spp), JSON("automatic", result->qualities[t->automatic].name));
    for (int c = 0; c < BENCH_CLOCKS; ++c) {
        json_t *seconds = json_object();
        for (unsigned q = 0; q < BUILD_QUALITIES; ++q)
            json_add(seconds, JSON(result->qualities[q].name, t->seconds[q][c]));
        json_t *clock = json_of(JSON("seconds", seconds), JSON("best", result->qualities[t->best[c]].name),
                                JSON("automaticBehind", t->behind[c]));
        json_add(object, JSON(bench_clock_names[c], clock));
    }
    return object;
}

static void pack(const bench_build_settings *asked, const bench_stage *stage, const build_time *result,
                 json_t *root) {
    json_t *qualities = json_array(), *totals = json_array();
    bench_add_tracer(root, trace_name(stage->tracer));
    for (unsigned q = 0; q < BUILD_QUALITIES; ++q)
        json_array_append_new(qualities, pack_quality(&result->qualities[q]));
    for (unsigned i = 0; i < BUILD_TOTALS; ++i)
        json_array_append_new(totals, pack_total(result, &result->totals[i]));
    bench_add_asked(root, &asked->all);
    json_add(root, JSON("triangles", scene_triangles(stage->scene)), JSON("width", stage->settings.width),
             JSON("height", stage->settings.height), JSON("spp", asked->spp), JSON("qualities", qualities),
             JSON("totals", totals));
}

static const bench_csv csv = {
    .rows = "qualities",
    .columns = "quality, build_cpu_seconds=buildSeconds.cpu.median, build_seconds=buildSeconds.wall.median, "
               "sample_cpu_seconds=sampleSeconds.cpu.median, sample_seconds=sampleSeconds.wall.median, "
               "bvh_bytes=bvhBytes, bvh_peak_bytes=bvhPeakBytes"};

/* ---- the table ---- */

static void print_range(const json_t *range) {
    char text[48] = "never";
    const json_t *to = json_array_get(range, 1);
    const double from = json_number_value(json_array_get(range, 0));
    if (json_is_number(to))
        snprintf(text, sizeof text, "%.3g to %.3g", from, json_number_value(to));
    else if (range && !json_is_null(range))
        snprintf(text, sizeof text, "from %.3g", from);
    printf("  %16s", text);
}

static void print(const json_t *root) {
    size_t i;
    json_t *row;
    json_print(root, "Embree {machine.embree:s}, {width:.0f}x{height:.0f}\n\n");
    printf("%-8s %9s %9s %9s %9s %9s %9s %9s  %16s  %16s\n", "quality", "build cpu", "clock s", "a sample,",
           "clock s", "Mrays/s", "BVH MB", "at most", "best spp, by cpu", "by the clock");
    json_array_foreach(json_object_get(root, "qualities"), i, row) {
        json_print(row, "{quality:-8s} {buildSeconds.cpu.median:9.4g} {buildSeconds.wall.median:9.4g} "
                        "{sampleSeconds.cpu.median:9.4g} {sampleSeconds.wall.median:9.4g} "
                        "{millionRaysPerSecond:9.3g} {bvhBytes:9.4gM} {bvhPeakBytes:9.4gM}");
        print_range(json_at(row, "bestFromToSpp.cpu"));
        print_range(json_at(row, "bestFromToSpp.wall"));
        putchar('\n');
    }
    printf("\n%-6s %9s %9s %9s  %-8s %-10s %s\n", "spp", "low", "medium", "high", "best", "automatic",
           "behind the best (CPU seconds of build and render)");
    json_array_foreach(json_object_get(root, "totals"), i, row)
        json_print(row, "{spp:-6.0f} {cpu.seconds.low:9.4g} {cpu.seconds.medium:9.4g} "
                        "{cpu.seconds.high:9.4g}  {cpu.best:-8s} {automatic:-10s} "
                        "{cpu.automaticBehind:.1f%} %\n");
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

static fathom_status measure(fathom_context *context, const void *settings, json_t *root) {
    const bench_build_settings *asked = settings;
    bench_stage stage;
    build_time result;
    fathom_status status = check_tracer(context, asked->all.tracer);
    if (status != FATHOM_OK) return status;
    const bench_watch watch = bench_progress_part(0, 1);
    status = bench_open(context, &asked->all, &stage);
    if (status == FATHOM_OK)
        status = build_time_measure(context, &stage, asked->all.tracer, asked->all.repeats, asked->spp,
                                    &watch, &result);
    if (status == FATHOM_OK) status = fathom_scene_check_files(stage.scene);
    if (status == FATHOM_OK) {
        pack(asked, &stage, &result, root);
        progress_clear_line();
        if (!asked->all.common.quiet) print(root);
    }
    stage_close(&stage);
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_build_settings asked = {.all = {.tracer = "embree", .repeats = 5}, .spp = 4};
    return bench_run(&(bench_kind){&command_bench_build, measure, &csv}, argc, argv, &asked);
}

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_text, BENCH_FIELD(tracer), 0, 0,
     "Embree in words without a quality, such as embree:default (embree)"},
    BENCH_SIZE,
    {"spp", 0, "N", take_u32, offsetof(bench_build_settings, spp), 1, 65536,
     "samples a pixel of each render (4)"},
    BENCH_REPEATS(BUILD_REPEATS_MAX, "repetitions; the results are their medians (5)"),
    COMMAND_THREADS,
    COMMAND_ALLOW_OUTSIDE(command_common),
    BENCH_RESULTS,
};

const command command_bench_build = {
    .name = "bench build",
    .usage = "SCENE [options]",
    .summary = "Measure what build quality costs and saves.",
    .text = "Builds by low, medium and high quality and renders with each, in turn. From the\n"
            "medians: for which number of samples a pixel each is the fastest, build and\n"
            "render together, and how far the automatic choice is behind the best.\n",
    .examples = "  fathom bench build heavy.glb --report results\n",
    .args = {options, bench_operands, bench_operand_offsets, 1},
    .run = run,
};
