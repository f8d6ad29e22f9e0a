/* `fathom bench trace`: rays per second and build time of every tracer, by triangle count. */
#include "cli/bench/bench.h"

#include "base/clock.h"
#include "base/status.h"
#include "measure/trace_time.h"

#include <stdlib.h>

typedef struct bench_trace_settings {
    bench_settings all;
    args_list tracers;
    args_counts triangles;
    uint64_t rays;
    uint32_t tracing; /* threads that build and trace */
    double seconds;
} bench_trace_settings;

/* ---- which tracers ---- */

typedef struct contestant {
    const char *text; /* "embree:16" */
    double build, build_cpu;
} contestant;

typedef struct field {
    contestant items[TRACE_TIME_TRACERS_MAX];
    trace_tracer *tracers[TRACE_TIME_TRACERS_MAX];
    trace_rate rates[TRACE_TIME_TRACERS_MAX][TRACE_SETS];
    size_t count;
} field;

/* Maximum number of primitives for linear search by default: sixteen rays take about 30 ms then. */
#define LINEAR_MOST 1000000

/* Enters the given tracers; without any, all that do not only repeat another. */
static void enter(field *f, const args_list *given, uint64_t primitives) {
    static const args_list all = {
        {"embree:1", "embree:4", "embree:8", "embree:16", "embree:raw:16", "embree:user:16", "bvh", "linear"},
        8};
    const args_list *list = given->count ? given : &all;
    f->count = list->count - (list == &all && primitives > LINEAR_MOST);
    for (size_t i = 0; i < f->count; ++i) f->items[i].text = list->items[i];
}

/* ---- one scene ---- */

typedef struct arena {
    bench_stage stage; /* without a tracer: each contestant has its own */
    const char *name;
    uint64_t triangles, primitives;
    double from, to; /* its range within all scenes */
} arena;

static fathom_status open_sphere(fathom_context *context, uint64_t triangles, bench_stage *out) {
    fathom_scene *scene;
    fathom_settings settings;
    fathom_status status = bench_sphere(context, triangles, &scene);
    if (status == FATHOM_OK) status = fathom_scene_complete(scene);
    *out = (bench_stage){.scene = scene};
    if (status != FATHOM_OK) return status;
    fathom_scene_settings(scene, &settings);
    fathom_settings_set_integrator(&settings, FATHOM_INTEGRATOR_CLASSIC);
    return stage_open(context, scene, &settings, out);
}

static fathom_status build(fathom_context *context, const world *w, contestant *c, unsigned threads,
                           trace_tracer **out) {
    trace_options options = {.words = c->text, .width = LANES, .threads = threads};
    double began = clock_seconds(), cpu = clock_process_seconds();
    fathom_status status = trace_create(context, w, &options, out);
    c->build = clock_seconds() - began, c->build_cpu = clock_process_seconds() - cpu;
    return status == FATHOM_OK ? status : fail_within(context, status, &(fathom_place){.field = c->text});
}

/* The first tracer finds the hits from which the rays start. */
static fathom_status race(fathom_context *context, const arena *s, const bench_trace_settings *asked,
                          field *f, trace_sets *sets) {
    const world *w = s->stage.world;
    const bench_watch watch = bench_progress_part(s->from, s->to);
    const trace_time_options options = {asked->all.repeats, asked->tracing, asked->seconds, &watch};
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < f->count && status == FATHOM_OK; ++i)
        status = build(context, w, &f->items[i], asked->tracing, &f->tracers[i]);
    if (status != FATHOM_OK) return status;
    status = trace_sets_create(context, w, f->tracers[0], asked->rays, sets);
    if (status == FATHOM_BAD_INPUT) fail_within(context, status, &(fathom_place){.file = s->name});
    if (status != FATHOM_OK) return status;
    return trace_time_measure(context, f->tracers, f->count, sets, &options, f->rates);
}

/* ---- results ---- */

static json_t *millions(quartiles q) {
    return bench_quartiles((quartiles){1e-6 * q.low, 1e-6 * q.median, 1e-6 * q.high});
}

static json_t *pack_rate(const trace_set *set, const trace_rate *r) {
    return json_of(JSON("set", set->name), JSON("query", set->any ? "any" : "closest"),
                   JSON("coherent", (bool)(set->coherence == TRACE_COHERENT)), JSON("rays", r->rays),
                   JSON("met", r->met), JSON("millionRaysPerSecond", millions(r->per_second)),
                   JSON("millionRaysPerCpuSecond", millions(r->per_cpu_second)));
}

static json_t *pack_run(const arena *s, const field *f, size_t i, const trace_sets *sets) {
    const contestant *c = &f->items[i];
    json_t *rates = json_array();
    for (size_t k = 0; k < TRACE_SETS; ++k)
        json_array_append_new(rates, pack_rate(&sets->items[k], &f->rates[i][k]));
    return json_of(JSON("scene", s->name), JSON("triangles", s->triangles), JSON("primitives", s->primitives),
                   JSON("spec", c->text), JSON("tracer", trace_name(f->tracers[i])),
                   JSON("buildSeconds", c->build), JSON("buildCpuSeconds", c->build_cpu),
                   JSON("bvhBytes", trace_bvh_bytes(f->tracers[i])), JSON("rates", rates));
}

static void print_rate(const json_t *rate, uint64_t most) {
    const double median = json_number_at(rate, "millionRaysPerCpuSecond.median");
    const double low = json_number_at(rate, "millionRaysPerCpuSecond.low");
    const double high = json_number_at(rate, "millionRaysPerCpuSecond.high");
    const bool fewer = json_number_at(rate, "rays") < (double)most;
    char cell[48];
    snprintf(cell, sizeof cell, "%.3g%s +-%.0f%%", median, fewer ? "*" : "", 50 * (high - low) / median);
    printf(" %-15s", cell);
}

/* The maximum number of rays of a set that any tracer traced. */
static uint64_t most_rays(const field *f, size_t set) {
    uint64_t most = 0;
    for (size_t i = 0; i < f->count; ++i)
        if (f->rates[i][set].rays > most) most = f->rates[i][set].rays;
    return most;
}

static void print_fewer(const field *f, const trace_sets *sets) {
    bool any = false;
    for (size_t i = 0; i < f->count; ++i) {
        for (size_t s = 0; s < TRACE_SETS; ++s) {
            if (f->rates[i][s].rays >= most_rays(f, s)) continue;
            printf("%s%s %s %llu", any ? ", " : "* fewer rays: ", f->items[i].text, sets->items[s].name,
                   (unsigned long long)f->rates[i][s].rays);
            any = true;
        }
    }
    if (any) putchar('\n');
}

/* The scene's runs begin with `first`. */
static void print_scene(const arena *s, const field *f, const trace_sets *sets, const json_t *runs,
                        size_t first) {
    print_name(stdout, s->name);
    printf(": %llu primitives, of them %llu triangles\n%-17s %8s %8s", (unsigned long long)s->primitives,
           (unsigned long long)s->triangles, "Mrays/s", "build s", "BVH MB");
    for (size_t k = 0; k < TRACE_SETS; ++k) printf(" %-15s", sets->items[k].name);
    printf("\n%-35s", "rays");
    for (size_t k = 0; k < TRACE_SETS; ++k) printf(" %-15llu", (unsigned long long)most_rays(f, k));
    putchar('\n');
    for (size_t i = 0; i < f->count; ++i) {
        const json_t *run = json_array_get(runs, first + i), *rates = json_object_get(run, "rates");
        json_print(run, "{spec:-17s} {buildSeconds:8.3f} {bvhBytes:8.1fM}");
        for (size_t k = 0; k < TRACE_SETS; ++k) print_rate(json_array_get(rates, k), most_rays(f, k));
        putchar('\n');
    }
    print_fewer(f, sets);
    fflush(stdout);
}

static const bench_csv csv = {
    .rows = "runs",
    .inner = "rates",
    .columns = "triangles, primitives, tracer=spec, build_seconds=buildSeconds, "
               "build_cpu_seconds=buildCpuSeconds, bvh_bytes=bvhBytes, set, query, coherent, rays, met, "
               "mrays_per_cpu_second_low=millionRaysPerCpuSecond.low, "
               "mrays_per_cpu_second_median=millionRaysPerCpuSecond.median, "
               "mrays_per_cpu_second_high=millionRaysPerCpuSecond.high, "
               "mrays_per_second_median=millionRaysPerSecond.median, scene"};

static fathom_status run_arena(fathom_context *context, const arena *s, const bench_trace_settings *asked,
                               json_t *root) {
    json_t *runs = json_object_get(root, "runs");
    size_t first = json_array_size(runs);
    field *f = calloc(1, sizeof *f);
    if (!f) return fail_memory(context, sizeof *f);
    trace_sets sets = {{{.count = 0}}};
    enter(f, &asked->tracers, s->primitives);
    fathom_status status = race(context, s, asked, f, &sets);
    for (size_t i = 0; i < f->count && status == FATHOM_OK; ++i) {
        bench_add_tracer(root, trace_name(f->tracers[i]));
        json_array_append_new(runs, pack_run(s, f, i, &sets));
    }
    progress_clear_line();
    if (status == FATHOM_OK && !asked->all.common.quiet) print_scene(s, f, &sets, runs, first);
    trace_sets_free(&sets);
    for (size_t i = 0; i < f->count; ++i) trace_destroy(f->tracers[i]);
    free(f);
    return status;
}

/* Opens scene i: the given one first, then the spheres. */
static fathom_status open_arena(fathom_context *context, const bench_trace_settings *asked, size_t i,
                                arena *out) {
    const size_t given = asked->all.scene != NULL, all = given + asked->triangles.count;
    *out = (arena){.name = i < given ? asked->all.scene : "generated sphere",
                   .from = (double)i / (double)all,
                   .to = (double)(i + 1) / (double)all};
    const fathom_status status = i < given
                                     ? bench_open(context, &asked->all, true, &out->stage)
                                     : open_sphere(context, asked->triangles.items[i - given], &out->stage);
    if (status != FATHOM_OK) return status;
    const fathom_scene *scene = out->stage.scene;
    out->triangles = scene_triangles(scene);
    out->primitives = scene_primitives(scene);
    return FATHOM_OK;
}

static fathom_status run_scenes(fathom_context *context, const bench_trace_settings *asked, json_t *root) {
    const size_t all = (asked->all.scene != NULL) + asked->triangles.count;
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < all && status == FATHOM_OK; ++i) {
        arena a;
        status = open_arena(context, asked, i, &a);
        if (status == FATHOM_OK) status = run_arena(context, &a, asked, root);
        if (status == FATHOM_OK) status = fathom_scene_check_files(a.stage.scene);
        stage_close(&a.stage);
    }
    return status;
}

static fathom_status measure(fathom_context *context, const void *settings, json_t *root) {
    const bench_trace_settings *asked = settings;
    if (!asked->all.scene && !asked->triangles.count)
        return fail(context, FATHOM_BAD_USAGE, "bench trace: SCENE is missing; expected it or --triangles");
    fathom_status status = FATHOM_OK;
    for (size_t i = 0; i < asked->tracers.count && status == FATHOM_OK; ++i)
        status = fathom_tracer_check(context, asked->tracers.items[i]);
    json_add(root, JSON("repeats", asked->all.repeats), JSON("threads", asked->tracing),
             JSON("raysAsked", asked->rays), JSON("runs", json_array()));
    return status == FATHOM_OK ? run_scenes(context, asked, root) : status;
}

#define FIELD(name) offsetof(bench_trace_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_list, FIELD(tracers), 0, 0,
     "tracer to measure; may be given several times (all, with linear search up to a million "
     "primitives)"},
    {"triangles", 't', "N,N", take_counts, FIELD(triangles), 1, 4e9,
     "generate spheres of so many triangles, such as 10k,100k,1M, after SCENE or instead of it"},
    {"rays", 0, "N", take_u64, FIELD(rays), 16, 1e9, "rays of each kind (262144)"},
    {"seconds", 0, "S", take_f64, FIELD(seconds), 1e-6, 1e6,
     "maximum time for one repetition of one tracer and kind of rays; slower ones get fewer rays "
     "(0.1)"},
    BENCH_REPEATS(TRACE_TIME_REPEATS_MAX, "repetitions; the results are their medians and quartiles (9)"),
    {"threads", 0, "N", take_u32, FIELD(tracing), 1, 1024, "number of threads that build and trace (1)"},
    COMMAND_ALLOW_OUTSIDE,
    BENCH_RESULTS,
};

const command command_bench_trace = {
    .name = "bench trace",
    .usage = "[SCENE] [--triangles N,N] [options]",
    .summary = "Measure rays per second of every tracer.",
    .text = "Generates four kinds of rays once, and traces them with every tracer:\n"
            "  camera   closest hit, coherent: packets of 4 x 4 pixels\n"
            "  bounce   closest hit, incoherent: from visible points in any direction\n"
            "  shadow   any hit, coherent: from visible points to the first light\n"
            "  between  any hit, incoherent: between any two visible points\n"
            "Tracers take turns, so that a machine that slows down favours none. All of them\n"
            "are in memory together. Prints million rays per second of a thread's processor\n"
            "time: medians, and half the distance of the quartiles. --json and --csv also\n"
            "have rays per second of elapsed time. SPEC is as for render.\n",
    .examples = "  fathom bench trace --triangles 10k,100k,1M --report results\n"
                "  fathom bench trace heavy.glb --tracer embree:8 --tracer embree:16\n",

    .args = {options, {{"SCENE", BENCH_FIELD(scene)}}, 1},
    COMMAND_BODY(bench_run, bench_trace_settings,
                 {.all = {.command = &command_bench_trace, .measure = measure, .table = &csv, .repeats = 9},
                  .rays = 262144,
                  .tracing = 1,
                  .seconds = 0.1}),
};
