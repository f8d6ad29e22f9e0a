/* `fathom bench secondary`: mirrored, refracted and shadow rays by depth against single-ray calls. */
#include "cli/bench/bench.h"
#include "cli/bench/bench_output.h"
#include "cli/bench/bench_run.h"
#include "cli/json_text.h"
#include "cli/render/progress.h"

#include "measure/secondary.h"

#include <stdlib.h>

typedef struct bench_secondary_settings {
    const char *scene, *tracer;
    args_size size;
    uint64_t rays;
    uint32_t repeats;
    bool quiet;
    bench_output output;
    bool allow_outside;
} bench_secondary_settings;

/* ---- results ---- */

static json_t *pack_row(const secondary_row *row) {
    json_t *ways = json_object();
    for (int way = 0; way < SECONDARY_WAYS; ++way)
        json_object_set_new(ways, secondary_way_name((secondary_way)way), bench_quartiles(row->ns[way]));
    return json_pack("{s:i, s:s, s:o, s:o, s:o, s:o}", "depth", (int)row->depth, "kind",
                     secondary_name(row->kind), "rays", json_count(row->rays), "met", json_count(row->met),
                     "nsPerRay", ways, "renderToSingle", bench_quartiles(row->to_single));
}

static double ns_of(const json_t *row, int way) {
    return bench_number(json_object_get(row, "nsPerRay"), secondary_way_name((secondary_way)way), "median");
}

static void print_rows(const json_t *rows) {
    printf("ns a ray   %28s %s\n%-16s %9s %8s %-22s", "",
           "single    4    8   8c   16  16c  sorted: render single", "depth, kind", "rays", "render",
           "over single");
    putchar('\n');
    size_t i;
    json_t *row;
    json_array_foreach(rows, i, row) {
        printf("%.0f %-14s %9.0f %8.0f %.3f (%.3f to %.3f)", bench_number(row, "depth", NULL),
               json_string_value(json_object_get(row, "kind")), bench_number(row, "rays", NULL),
               ns_of(row, SECONDARY_RENDER), bench_number(row, "renderToSingle", "median"),
               bench_number(row, "renderToSingle", "low"), bench_number(row, "renderToSingle", "high"));
        for (int way = SECONDARY_SINGLE; way < SECONDARY_WAYS; ++way) printf(" %4.0f", ns_of(row, way));
        putchar('\n');
    }
}

static void put_csv(FILE *out, const json_t *root) {
    fputs("depth,kind,rays,met,render_to_single_low,render_to_single_median,render_to_single_high", out);
    for (int way = 0; way < SECONDARY_WAYS; ++way)
        fprintf(out, ",ns %s", secondary_way_name((secondary_way)way));
    fputc('\n', out);
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(root, "rows"), i, row) {
        fprintf(out, "%.0f,%s,%.0f,%.0f,%.5g,%.5g,%.5g", bench_number(row, "depth", NULL),
                json_string_value(json_object_get(row, "kind")), bench_number(row, "rays", NULL),
                bench_number(row, "met", NULL), bench_number(row, "renderToSingle", "low"),
                bench_number(row, "renderToSingle", "median"), bench_number(row, "renderToSingle", "high"));
        for (int way = 0; way < SECONDARY_WAYS; ++way) fprintf(out, ",%.5g", ns_of(row, way));
        fputc('\n', out);
    }
}

/* ---- the command ---- */

static fathom_status record_stage(fathom_context *context, const bench_stage *stage, uint64_t enough,
                                  secondary_rays *rays) {
    render_plan *plan;
    fathom_status status = plan_create(context, stage->world, stage->tracer, &stage->settings, &plan);
    if (status == FATHOM_OK) status = secondary_record(context, plan, enough, rays);
    plan_destroy(plan);
    return status;
}

static fathom_status measure(fathom_context *context, const bench_stage *stage,
                             const bench_secondary_settings *asked, json_t *root) {
    if (!embree_bare_possible(stage->tracer))
        return fail(context, FATHOM_BAD_USAGE,
                    "--tracer: \"%s\" has no single-ray calls to compare with; expected embree, but not by "
                    "streams",
                    asked->tracer);
    secondary_rays *rays = malloc(sizeof *rays);
    secondary_time *time = malloc(sizeof *time);
    fathom_status status = rays && time ? FATHOM_OK : fail_memory(context, sizeof *rays + sizeof *time);
    if (status == FATHOM_OK) status = record_stage(context, stage, asked->rays, rays);
    if (status == FATHOM_OK) {
        const bench_watch watch = bench_progress_part(0, 1);
        status = secondary_measure(context, stage->tracer, rays, asked->repeats, &watch, time);
        progress_clear_line();
        secondary_free(rays);
    }
    bench_head_tracer(root, trace_name(stage->tracer));
    json_t *rows = json_object_get(root, "rows");
    for (size_t i = 0; status == FATHOM_OK && i < time->count; ++i)
        json_array_append_new(rows, pack_row(&time->rows[i]));
    free(rays);
    free(time);
    return status;
}

static fathom_status run_scene(fathom_context *context, const bench_secondary_settings *asked, json_t *root) {
    bench_stage stage;
    fathom_status status = bench_open(context, asked->scene, asked->size, &stage);
    if (status == FATHOM_OK) status = stage_build(context, &stage, asked->tracer, 0);
    if (status == FATHOM_OK) status = measure(context, &stage, asked, root);
    if (status == FATHOM_OK) status = fathom_scene_check_files(stage.scene);
    stage_close(&stage);
    return status;
}

static json_t *head(const bench_secondary_settings *asked) {
    json_t *root = bench_head("secondary");
    json_object_set_new(root, "scene", json_text(asked->scene));
    json_object_set_new(root, "spec", json_text(asked->tracer));
    json_object_set_new(root, "repeats", json_count(asked->repeats));
    json_object_set_new(root, "raysAsked", json_count(asked->rays));
    json_object_set_new(root, "rows", json_array());
    return root;
}

static fathom_status bench(fathom_context *context, const void *user) {
    const bench_secondary_settings *asked = user;
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, asked->tracer, &spec);
    if (status == FATHOM_OK) status = bench_output_check(context, &asked->output, asked->scene);
    if (status != FATHOM_OK) return status;
    bench_progress_begin(asked->quiet);
    json_t *root = head(asked);
    status = run_scene(context, asked, root);
    if (status == FATHOM_OK && !asked->quiet) print_rows(json_object_get(root, "rows"));
    if (status == FATHOM_OK) status = bench_output_write(context, &asked->output, root, put_csv);
    json_decref(root);
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_secondary_settings asked = {.tracer = "embree", .rays = 100000, .repeats = 9};
    fathom_status status;
    if (!command_parse(&command_bench_secondary, argc, argv, &asked, &status)) return status;
    return bench_run(&command_bench_secondary, 0, asked.allow_outside, bench, &asked);
}

#define FIELD(name) offsetof(bench_secondary_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_text, FIELD(tracer), 0, 0, "what answers the rays (embree)"},
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536, "pixels (the scene's, else 1280x720)"},
    {"rays", 0, "N", take_count, FIELD(rays), 16, 1e8,
     "of each depth and kind, about, if there are (100000)"},
    {"repeats", 0, "N", take_u32, FIELD(repeats), 1, SECONDARY_REPEATS_MAX,
     "of which medians and quartiles are told (9)"},
    COMMAND_ALLOW_OUTSIDE(bench_secondary_settings),
    BENCH_OUTPUT_OPTIONS(bench_secondary_settings),
    {.help = NULL},
};
static const char *const operands[] = {"SCENE"};
static const size_t operand_offsets[] = {FIELD(scene)};

const command command_bench_secondary = {
    .name = "bench secondary",
    .usage = "SCENE [options]",
    .summary = "Measure mirrored, refracted and shadow rays by depth.",
    .text = "The rays of a render's first samples are recorded by depth and kind, from waves\n"
            "all over the image, and asked again: as the render asks them, all that its\n"
            "tracer does included, and by Embree's calls alone, one ray a call, in packets\n"
            "of 4, 8 and 16, and by the kernels for coherent packets; in the render's order,\n"
            "and sorted by octant and origin. All take turns; times are of one thread's\n"
            "processor, and what is told is each way's nanoseconds a ray, and the render's\n"
            "over single rays'.\n",
    .examples = "  fathom bench secondary scenes/first-render.json\n"
                "  fathom bench secondary scenes/tour/13-refraction.json --rays 20000\n",
    .args = {options, operands, operand_offsets, 1},
    .run = run,
};
