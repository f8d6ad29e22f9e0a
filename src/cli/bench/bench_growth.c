/* `fathom bench growth`: reading, building and tracing by the number of triangles. */
#include "cli/bench/bench.h"
#include "cli/outputs.h"

#include "base/status.h"
#include "measure/growth.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A .glb ends at 4 GB, 28 bytes a triangle. */
#define MOST_TRIANGLES 150e6
/* Enough for a million pixels of ten rays; no machine that renders them lacks it. */
#define RECORD_BYTES ((uint64_t)512 << 20)
/* A mesh of less fits into caches, and calls of threads outweigh the work on the smallest. */
#define HEAVY 0.9e6

typedef struct bench_growth_settings {
    bench_settings all;
    args_counts triangles;
    const char *with;
    double seconds;
} bench_growth_settings;

/* ---- one size ---- */

static json_t *pack_run(const growth_point *g) {
    const ray_counts *r = &g->time.rays;
    const render_ratio *ratio = &g->time.ratio;
    const uint64_t rays = r->camera + r->shadow + r->reflection + r->refraction;
    json_t *rates = json_of(JSON("render", 1e-6 * (double)rays / ratio->render.median),
                            JSON("bare", 1e-6 * (double)(ratio->closest + ratio->any) / ratio->bare.median));
    return json_of(JSON("triangles", g->triangles), JSON("fileBytes", g->file_bytes),
                   JSON("bvhBytes", g->bvh_bytes), JSON("bvhPeakBytes", g->peak_bytes),
                   JSON("readSeconds", bench_clocks(g->read)), JSON("buildSeconds", bench_clocks(g->build)),
                   JSON("rays", rays), JSON("renderCpuSeconds", bench_quartiles(ratio->render)),
                   JSON("bareCpuSeconds", bench_quartiles(ratio->bare)),
                   JSON("renderToBare", bench_quartiles(ratio->render_to_bare)),
                   JSON("millionRaysPerCpuSecond", rates));
}

/* A temporary file. */
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

static fathom_status measure_size(fathom_context *context, const bench_growth_settings *asked, size_t index,
                                  growth_point *out) {
    const bench_watch watch = bench_progress_part(work_before(asked, index), work_before(asked, index + 1));
    const growth_options options = {.repeats = asked->all.repeats,
                                    .seconds = asked->seconds,
                                    .width = asked->all.size.width,
                                    .height = asked->all.size.height,
                                    .record_bytes = RECORD_BYTES,
                                    .watch = &watch};
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

/* By the number of triangles; it replaces one of as many. */
static void insert(json_t *runs, json_t *run) {
    const double triangles = json_number_at(run, "triangles");
    size_t at = 0;
    while (json_number_at(json_array_get(runs, at), "triangles") < triangles) ++at;
    if (json_number_at(json_array_get(runs, at), "triangles") < triangles + 1)
        json_array_set_new(runs, at, run);
    else
        json_array_insert_new(runs, at, run);
}

/* The sizes that an earlier run measured. */
static fathom_status take_earlier(fathom_context *context, const char *path, json_t *runs) {
    json_error_t error;
    json_t *earlier = json_load_file(path, 0, &error);
    if (!earlier)
        return fail_at(context, FATHOM_BAD_INPUT, &(fathom_place){.file = path, .line = (size_t)error.line},
                       "%s; expected what bench growth --json wrote", error.text);
    json_t *run;
    size_t i;
    fathom_status status = FATHOM_OK;
    if (strcmp(json_text_at(earlier, "bench"), "growth") != 0)
        status = fail_file(context, FATHOM_BAD_INPUT, path, "expected what bench growth --json wrote");
    json_array_foreach(json_object_get(earlier, "runs"), i, run) insert(runs, json_incref(run));
    json_decref(earlier);
    return status;
}

static void print_run(const json_t *run) {
    json_print(run, "{triangles:11.0f}  {readSeconds.cpu.median:9.5f} {readSeconds.wall.median:9.5f}  "
                    "{buildSeconds.cpu.median:9.4f} {buildSeconds.wall.median:9.4f}  {bvhBytes:9.1fM}  "
                    "{millionRaysPerCpuSecond.render:7.1f} {millionRaysPerCpuSecond.bare:7.1f}  "
                    "{renderToBare.median:.3f} ({renderToBare.low:.3f} to {renderToBare.high:.3f})\n");
    fflush(stdout);
}

static fathom_status run_sizes(fathom_context *context, const bench_growth_settings *asked, json_t *root) {
    json_t *runs = json_object_get(root, "runs");
    growth_point *point = malloc(sizeof *point);
    fathom_status status = point ? FATHOM_OK : fail_memory(context, sizeof *point);
    if (!asked->all.common.quiet && status == FATHOM_OK) {
        printf("%11s  %9s %9s  %9s %9s  %9s  %7s %7s  %s\n", "triangles", "read cpu", "clock s", "build cpu",
               "clock s", "BVH MB", "Mrays/s", "bare", "render phase over bare calls");
        for (size_t i = 0; i < json_array_size(runs); ++i) print_run(json_array_get(runs, i));
    }
    for (size_t i = 0; i < asked->triangles.count && status == FATHOM_OK; ++i) {
        status = measure_size(context, asked, i, point);
        progress_clear_line();
        if (status != FATHOM_OK) break;
        json_t *run = pack_run(point);
        bench_add_tracer(root, point->tracer);
        if (!asked->all.common.quiet) print_run(run);
        insert(runs, run);
    }
    free(point);
    return status;
}

/* ---- exponents ---- */

static const struct {
    const char *name, *path, *words;
} all_series[] = {
    {"read", "readSeconds.cpu.median", "reading"},
    {"build", "buildSeconds.cpu.median", "building"},
    {"render", "renderCpuSeconds.median", "render phase"},
    {"bare", "bareCpuSeconds.median", "bare calls"},
    {"renderToBare", "renderToBare.median", "render over bare"},
};
#define SERIES (sizeof all_series / sizeof *all_series)

/* {"exponent", "half", "scale", "sizes"} of the sizes from `least` on; null where they are too few. */
static json_t *pack_fit(const json_t *runs, const char *path, double least) {
    size_t room = json_array_size(runs), count = 0, i;
    double *x = malloc(2 * (room + 1) * sizeof *x);
    if (!x) return json_null();
    json_t *run;
    json_array_foreach(runs, i, run) {
        if (json_number_at(run, "triangles") < least) continue;
        x[count] = json_number_at(run, "triangles"), x[room + count++] = json_number_at(run, path);
    }
    growth_fit fit = growth_fit_of(x, x + room, count);
    free(x);
    if (!isfinite(fit.exponent)) return json_null();
    return json_of(JSON("exponent", fit.exponent), JSON("half", fit.half), JSON("scale", fit.scale),
                   JSON("sizes", fit.count));
}

static json_t *pack_fits(const json_t *runs) {
    json_t *fits = json_object();
    for (size_t i = 0; i < SERIES; ++i) {
        const char *path = all_series[i].path;
        json_t *fit =
            json_of(JSON("all", pack_fit(runs, path, 0)), JSON("heavy", pack_fit(runs, path, HEAVY)));
        json_add(fits, JSON(all_series[i].name, fit));
    }
    return fits;
}

static void print_fits(const json_t *fits) {
    printf("\n%-18s  %-18s  %s\n", "seconds ~ triangles", "exponent, all", "from a million on");
    for (size_t i = 0; i < SERIES; ++i) {
        const json_t *fit = json_object_get(fits, all_series[i].name);
        printf("%-18s", all_series[i].words);
        bench_print_slope(json_at(fit, "all.exponent"), json_at(fit, "all.half"), -18);
        bench_print_slope(json_at(fit, "heavy.exponent"), json_at(fit, "heavy.half"), -18);
        putchar('\n');
    }
}

static const bench_csv csv = {
    .rows = "runs",
    .columns = "triangles, file_bytes=fileBytes, bvh_bytes=bvhBytes, bvh_peak_bytes=bvhPeakBytes, "
               "read_cpu_seconds=readSeconds.cpu.median, read_seconds=readSeconds.wall.median, "
               "build_cpu_seconds=buildSeconds.cpu.median, build_seconds=buildSeconds.wall.median, rays, "
               "render_cpu_seconds=renderCpuSeconds.median, bare_cpu_seconds=bareCpuSeconds.median, "
               "render_to_bare_low=renderToBare.low, render_to_bare_median=renderToBare.median, "
               "render_to_bare_high=renderToBare.high"};

/* ---- the command ---- */

static fathom_status measure(fathom_context *context, const void *settings, json_t *root) {
    const bench_growth_settings *asked = settings;
    if (!asked->triangles.count && !asked->with)
        return fail(context, FATHOM_BAD_USAGE, "--triangles N,N is missing");
    json_t *runs = json_array();
    json_add(root, JSON("width", asked->all.size.width), JSON("height", asked->all.size.height),
             JSON("repeats", asked->all.repeats), JSON("runs", runs));
    fathom_status status = asked->with ? take_earlier(context, asked->with, runs) : FATHOM_OK;
    if (status == FATHOM_OK) status = run_sizes(context, asked, root);
    if (status != FATHOM_OK) return status;
    json_add(root, JSON("fits", pack_fits(runs)));
    if (!asked->all.common.quiet) print_fits(json_object_get(root, "fits"));
    return FATHOM_OK;
}

static fathom_status run(int argc, char **argv) {
    bench_growth_settings asked = {.all = {.size = {1280, 720}, .repeats = 5}, .seconds = 8};
    return bench_run(&(bench_kind){&command_bench_growth, measure, &csv}, argc, argv, &asked);
}

#define FIELD(name) offsetof(bench_growth_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"triangles", 't', "N,N", take_counts, FIELD(triangles), 1, MOST_TRIANGLES,
     "of generated spheres, such as 10k,100k,1M; a file of each is made in $TMPDIR and removed"},
    {"with", 0, "FILE", take_text, FIELD(with), 0, 0,
     "also the sizes in the --json of an earlier run: what takes too long for one run is measured in "
     "several"},
    {"size", 0, "WxH", take_size, BENCH_FIELD(size), 1, 65536, "pixels (1280x720)"},
    BENCH_REPEATS(GROWTH_REPEATS_MAX,
                  "repetitions, after one that warms up; the results are their medians and quartiles (5)"),
    {"seconds", 0, "S", take_f64, FIELD(seconds), 0, 1e6,
     "after which reading, or building, is not repeated (8)"},
    BENCH_RESULTS,
};

const command command_bench_growth = {
    .name = "bench growth",
    .usage = "--triangles N,N [options]",
    .summary = "Measure how read, build and rays a second go with the triangles.",
    .text = "Reads each mesh from a file that the system has in memory, builds all that\n"
            "stands between it and the first ray, and renders one sample a pixel, by one\n"
            "thread, next to Embree's bare calls for the same rays. Prints the exponents b of\n"
            "seconds = a * triangles^b with their 95 % intervals, over all sizes and over\n"
            "those from a million on: 1 is linear. If that of render over bare is 0 or less,\n"
            "the renderer slows down no faster than Embree itself.\n",
    .examples = "  fathom bench growth --triangles 10k,100k,1M,10M --report results\n"
                "  fathom bench growth --triangles 100M --with g.json --json g.json\n",
    .args = {options, NULL, NULL, 0, 0},
    .run = run,
};
