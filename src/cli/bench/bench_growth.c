/* `fathom bench growth`: reading, building and tracing by the number of triangles. */
#include "cli/bench/bench_growth.h"
#include "cli/bench/bench.h"
#include "cli/bench/bench_output.h"
#include "cli/bench/bench_run.h"
#include "cli/json_text.h"
#include "cli/render/progress.h"
#include "cli/temporary.h"

#include "measure/growth.h"

#include <stdlib.h>
#include <string.h>

/* A .glb ends at 4 GB, 28 bytes a triangle. */
#define MOST_TRIANGLES 150e6
/* Enough for a million pixels of ten rays; no machine that renders them lacks it. */
#define RECORD_BYTES ((uint64_t)512 << 20)

typedef struct bench_growth_settings {
    args_counts triangles;
    const char *with;
    args_size size;
    uint32_t repeats;
    double seconds;
    bool quiet;
    bench_output output;
} bench_growth_settings;

/* ---- one size ---- */

static json_t *pack_run(const growth_point *g) {
    const ray_counts *r = &g->time.rays;
    const render_ratio *ratio = &g->time.ratio;
    double rays = (double)(r->camera + r->shadow + r->reflection + r->refraction);
    json_t *rates = json_pack("{s:f, s:f}", "render", 1e-6 * rays / ratio->render.median, "bare",
                              1e-6 * (double)(ratio->closest + ratio->any) / ratio->bare.median);
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "triangles",
                     json_count(g->triangles), "fileBytes", json_count(g->file_bytes), "bvhBytes",
                     json_count(g->bvh_bytes), "bvhPeakBytes", json_count(g->peak_bytes), "readSeconds",
                     bench_clocks(g->read), "buildSeconds", bench_clocks(g->build), "rays",
                     json_count((uint64_t)rays), "renderCpuSeconds", bench_quartiles(ratio->render),
                     "bareCpuSeconds", bench_quartiles(ratio->bare), "renderToBare",
                     bench_quartiles(ratio->render_to_bare), "millionRaysPerCpuSecond", rates);
}

/* A file of its own, gone when it was measured. */
static fathom_status generate(fathom_context *context, uint64_t triangles, const char *path) {
    fathom_scene *scene;
    fathom_status status = bench_sphere(context, triangles, &scene);
    if (status == FATHOM_OK) status = fathom_scene_write_mesh(scene, path);
    fathom_scene_destroy(scene);
    return status;
}

/* The part of all work that comes before size `index`. Rendering takes as long as reading and building of
 * about a million triangles. */
static double work_before(const bench_growth_settings *asked, size_t index) {
    double before = 0, all = 0;
    for (size_t i = 0; i < asked->triangles.count; ++i) {
        const double work = (double)asked->triangles.items[i] + 1e6;
        if (i < index) before += work;
        all += work;
    }
    return before / all;
}

static fathom_status measure(fathom_context *context, const bench_growth_settings *asked, size_t index,
                             growth_point *out) {
    const bench_watch watch = bench_progress_part(work_before(asked, index), work_before(asked, index + 1));
    const growth_options options = {asked->repeats,     asked->seconds, asked->size.width,
                                    asked->size.height, RECORD_BYTES,   &watch};
    char path[TEMPORARY_PATH];
    fathom_status status = temporary_create(context, ".glb", path);
    if (status != FATHOM_OK) return status;
    fathom_context_set_threads(context, 0);
    status = generate(context, asked->triangles.items[index], path);
    if (status == FATHOM_OK) status = growth_measure(context, path, &options, out);
    temporary_remove(path);
    return status;
}

/* ---- all sizes ---- */

/* In the order of triangles, in place of one of as many. */
static void insert(json_t *runs, json_t *run) {
    double triangles = bench_number(run, "triangles", NULL);
    size_t at = 0;
    while (at < json_array_size(runs) &&
           bench_number(json_array_get(runs, at), "triangles", NULL) < triangles)
        ++at;
    if (bench_number(json_array_get(runs, at), "triangles", NULL) >= triangles + 1 ||
        at == json_array_size(runs))
        json_array_insert_new(runs, at, run);
    else
        json_array_set_new(runs, at, run);
}

/* The sizes that an earlier run measured. */
static fathom_status take_earlier(fathom_context *context, const char *path, json_t *runs) {
    json_error_t error;
    json_t *earlier = json_load_file(path, 0, &error);
    if (!earlier)
        return fail_at(context, FATHOM_BAD_INPUT, &(fathom_place){.file = path, .line = (size_t)error.line},
                       "%s; expected what bench growth --json wrote", error.text);
    const char *bench = json_string_value(json_object_get(earlier, "bench"));
    json_t *run;
    size_t i;
    fathom_status status = FATHOM_OK;
    if (!bench || strcmp(bench, "growth") != 0)
        status = fail_file(context, FATHOM_BAD_INPUT, path, "expected what bench growth --json wrote");
    json_array_foreach(json_object_get(earlier, "runs"), i, run) insert(runs, json_incref(run));
    json_decref(earlier);
    return status;
}

static void print_run(const json_t *run) {
    const json_t *rates = json_object_get(run, "millionRaysPerCpuSecond");
    printf("%11.0f  %9.5f %9.5f  %9.4f %9.4f  %9.1f  %7.1f %7.1f  %.3f (%.3f to %.3f)\n",
           bench_number(run, "triangles", NULL),
           bench_number(json_object_get(run, "readSeconds"), "cpu", "median"),
           bench_number(json_object_get(run, "readSeconds"), "wall", "median"),
           bench_number(json_object_get(run, "buildSeconds"), "cpu", "median"),
           bench_number(json_object_get(run, "buildSeconds"), "wall", "median"),
           1e-6 * bench_number(run, "bvhBytes", NULL), bench_number(rates, "render", NULL),
           bench_number(rates, "bare", NULL), bench_number(run, "renderToBare", "median"),
           bench_number(run, "renderToBare", "low"), bench_number(run, "renderToBare", "high"));
    fflush(stdout);
}

static void print_head(void) {
    printf("%11s  %9s %9s  %9s %9s  %9s  %7s %7s  %s\n", "triangles", "read cpu", "clock s", "build cpu",
           "clock s", "BVH MB", "Mrays/s", "bare", "render phase over bare calls");
}

static fathom_status run_sizes(fathom_context *context, const bench_growth_settings *asked, json_t *root) {
    json_t *runs = json_object_get(root, "runs");
    growth_point *point = malloc(sizeof *point);
    fathom_status status = point ? FATHOM_OK : fail_memory(context, sizeof *point);
    if (!asked->quiet && status == FATHOM_OK) {
        print_head();
        for (size_t i = 0; i < json_array_size(runs); ++i) print_run(json_array_get(runs, i));
    }
    for (size_t i = 0; i < asked->triangles.count && status == FATHOM_OK; ++i) {
        status = measure(context, asked, i, point);
        progress_clear_line();
        if (status != FATHOM_OK) break;
        json_t *run = pack_run(point);
        bench_head_tracer(root, point->tracer);
        if (!asked->quiet) print_run(run);
        insert(runs, run);
    }
    free(point);
    return status;
}

/* ---- the command ---- */

static fathom_status bench(fathom_context *context, const void *user) {
    const bench_growth_settings *asked = user;
    if (!asked->triangles.count && !asked->with)
        return fail(context, FATHOM_BAD_USAGE, "--triangles N,N is missing");
    fathom_status status = bench_output_check(context, &asked->output, NULL);
    if (status != FATHOM_OK) return status;
    bench_progress_begin(asked->quiet);
    json_t *root = bench_head("growth"), *runs = json_array();
    json_object_set_new(root, "width", json_count(asked->size.width));
    json_object_set_new(root, "height", json_count(asked->size.height));
    json_object_set_new(root, "repeats", json_count(asked->repeats));
    json_object_set_new(root, "runs", runs);
    if (asked->with) status = take_earlier(context, asked->with, runs);
    if (status == FATHOM_OK) status = run_sizes(context, asked, root);
    if (status == FATHOM_OK) {
        bench_growth_fit(root);
        if (!asked->quiet) bench_growth_print(root);
        status = bench_output_write(context, &asked->output, root, bench_growth_csv);
    }
    json_decref(root);
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_growth_settings asked = {.size = {1280, 720}, .repeats = 5, .seconds = 8};
    fathom_status status;
    if (!command_parse(&command_bench_growth, argc, argv, &asked, &status)) return status;
    return bench_run(&command_bench_growth, 0, false, bench, &asked);
}

#define FIELD(name) offsetof(bench_growth_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"triangles", 't', "N,N", take_counts, FIELD(triangles), 1, MOST_TRIANGLES,
     "of generated spheres, such as 10k,100k,1M; a file of each is made in $TMPDIR and removed"},
    {"with", 0, "FILE", take_text, FIELD(with), 0, 0,
     "besides, the sizes in the --json of an earlier run: what is too long for one run is measured in "
     "several"},
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536, "pixels (1280x720)"},
    {"repeats", 0, "N", take_u32, FIELD(repeats), 1, GROWTH_REPEATS_MAX,
     "of which medians and quartiles are told, after one that warms up (5)"},
    {"seconds", 0, "S", take_f64, FIELD(seconds), 0, 1e6,
     "after which reading, or building, is not repeated (8)"},
    BENCH_OUTPUT_OPTIONS(bench_growth_settings),
    {.help = NULL},
};

const command command_bench_growth = {
    .name = "bench growth",
    .usage = "--triangles N,N [options]",
    .summary = "Measure how read, build and rays a second go with the triangles.",
    .text = "Reads each mesh from a file that the system has in memory, builds all that\n"
            "stands between it and the first ray, and renders one sample a pixel, by one\n"
            "thread, beside Embree's bare calls for the same rays. Told are the exponents b\n"
            "of seconds = a * triangles^b with their 95 % intervals, over all sizes and over\n"
            "those from a million on: 1 is linear. Of render over bare, 0 or less is falling\n"
            "no faster than Embree itself.\n",
    .examples = "  fathom bench growth --triangles 10k,100k,1M,10M --report results\n"
                "  fathom bench growth --triangles 100M --with g.json --json g.json\n",
    .args = {options, NULL, NULL, 0, 0},
    .run = run,
};
