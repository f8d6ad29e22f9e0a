/* `fathom bench secondary`: mirrored, refracted and shadow rays by depth against single-ray calls. */
#include "cli/bench/bench.h"

#include "base/status.h"
#include "measure/secondary.h"

#include <stdlib.h>

typedef struct bench_secondary_settings {
    bench_settings all;
    uint64_t rays;
} bench_secondary_settings;

/* ---- results ---- */

static json_t *pack_row(const secondary_row *row) {
    json_t *ways = json_object();
    for (int way = 0; way < SECONDARY_WAYS; ++way)
        json_add(ways, JSON(secondary_way_name((secondary_way)way), bench_quartiles(row->ns[way])));
    return json_of(JSON("depth", row->depth), JSON("kind", secondary_name(row->kind)),
                   JSON("rays", row->rays), JSON("met", row->met), JSON("nsPerRay", ways),
                   JSON("renderToSingle", bench_quartiles(row->to_single)));
}

static void print_rows(const json_t *rows) {
    size_t i;
    json_t *row;
    printf("ns a ray   %28s %s\n%-16s %9s %8s %-22s\n", "",
           "single    4    8   8c   16  16c  sorted: render single", "depth, kind", "rays", "render",
           "over single");
    json_array_foreach(rows, i, row) json_print(
        row, "{depth:.0f} {kind:-14s} {rays:9.0f} {nsPerRay.render.median:8.0f} "
             "{renderToSingle.median:.3f} ({renderToSingle.low:.3f} to {renderToSingle.high:.3f})"
             " {nsPerRay.single.median:4.0f} {nsPerRay.4.median:4.0f} {nsPerRay.8.median:4.0f} {nsPerRay.8 "
             "coherent.median:4.0f} {nsPerRay.16.median:4.0f} {nsPerRay.16 coherent.median:4.0f} "
             "{nsPerRay.render sorted.median:4.0f} {nsPerRay.single sorted.median:4.0f}\n");
}

static const bench_csv csv = {
    .rows = "rows",
    .columns = "depth, kind, rays, met, render_to_single_low=renderToSingle.low, "
               "render_to_single_median=renderToSingle.median, render_to_single_high=renderToSingle.high, "
               "ns render=nsPerRay.render.median, ns single=nsPerRay.single.median, ns 4=nsPerRay.4.median, "
               "ns 8=nsPerRay.8.median, ns 8 coherent=nsPerRay.8 coherent.median, ns 16=nsPerRay.16.median, "
               "ns 16 coherent=nsPerRay.16 coherent.median, ns render sorted=nsPerRay.render sorted.median, "
               "ns single sorted=nsPerRay.single sorted.median"};

/* ---- the command ---- */

static fathom_status record_stage(fathom_context *context, const bench_stage *stage, uint64_t enough,
                                  secondary_rays *rays) {
    render_plan *plan;
    fathom_status status = plan_create(context, stage->world, stage->tracer, &stage->settings, &plan);
    if (status == FATHOM_OK) status = secondary_record(context, plan, enough, rays);
    plan_destroy(plan);
    return status;
}

static fathom_status measure_stage(fathom_context *context, const bench_stage *stage,
                                   const bench_secondary_settings *asked, json_t *root) {
    if (!embree_bare_possible(stage->tracer))
        return fail(context, FATHOM_BAD_USAGE,
                    "--tracer: \"%s\" has no single-ray calls to compare with; expected embree, but not by "
                    "streams",
                    asked->all.tracer);
    secondary_rays *rays = malloc(sizeof *rays);
    secondary_time *time = malloc(sizeof *time);
    fathom_status status = rays && time ? FATHOM_OK : fail_memory(context, sizeof *rays + sizeof *time);
    if (status == FATHOM_OK) status = record_stage(context, stage, asked->rays, rays);
    if (status == FATHOM_OK) {
        const bench_watch watch = bench_progress_part(0, 1);
        status = secondary_measure(context, stage->tracer, rays, asked->all.repeats, &watch, time);
        secondary_free(rays);
    }
    bench_add_tracer(root, trace_name(stage->tracer));
    json_t *rows = json_object_get(root, "rows");
    for (size_t i = 0; status == FATHOM_OK && i < time->count; ++i)
        json_array_append_new(rows, pack_row(&time->rows[i]));
    free(rays);
    free(time);
    return status;
}

static fathom_status measure(fathom_context *context, const void *settings, json_t *root) {
    const bench_secondary_settings *asked = settings;
    bench_stage stage;
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, asked->all.tracer, &spec);
    if (status != FATHOM_OK) return status;
    bench_add_asked(root, &asked->all);
    json_add(root, JSON("raysAsked", asked->rays), JSON("rows", json_array()));
    status = bench_open(context, &asked->all, &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage, asked->all.tracer, 0);
    if (status == FATHOM_OK) status = measure_stage(context, &stage, asked, root);
    if (status == FATHOM_OK) status = fathom_scene_check_files(stage.scene);
    stage_close(&stage);
    progress_clear_line();
    if (status == FATHOM_OK && !asked->all.common.quiet) print_rows(json_object_get(root, "rows"));
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_secondary_settings asked = {.all = {.tracer = "embree", .repeats = 9}, .rays = 100000};
    return bench_run(&(bench_kind){&command_bench_secondary, measure, &csv}, argc, argv, &asked);
}

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_text, BENCH_FIELD(tracer), 0, 0, "what answers the rays (embree)"},
    BENCH_SIZE,
    {"rays", 0, "N", take_count, offsetof(bench_secondary_settings, rays), 16, 1e8,
     "of each depth and kind, about, if there are (100000)"},
    BENCH_REPEATS(SECONDARY_REPEATS_MAX, "repetitions; the results are their medians and quartiles (9)"),
    COMMAND_ALLOW_OUTSIDE(command_common),
    BENCH_RESULTS,
};

const command command_bench_secondary = {
    .name = "bench secondary",
    .usage = "SCENE [options]",
    .summary = "Measure mirrored, refracted and shadow rays by depth.",
    .text = "Records the rays of a render's first samples by depth and kind, from all over\n"
            "the image, and traces them again: as the render traces them, with all that its\n"
            "tracer does, and by Embree's calls alone, one ray a call, in packets of 4, 8 and\n"
            "16, and by the kernels for coherent packets; in the render's order, and sorted\n"
            "by octant and origin. All take turns; times are of one thread's\n"
            "processor. Prints each way's nanoseconds a ray, and the ratio of the render's to\n"
            "those of single rays.\n",
    .examples = "  fathom bench secondary scenes/first-render.json\n"
                "  fathom bench secondary scenes/tour/13-refraction.json --rays 20000\n",
    .args = {options, bench_operands, bench_operand_offsets, 1},
    .run = run,
};
