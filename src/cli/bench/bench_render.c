/* `fathom bench render`: the phases of a render, and its time divided by that of bare Embree calls. */
#include "cli/bench/bench.h"
#include "cli/outputs.h"

#include "base/clock.h"
#include "base/status.h"
#include "film/film.h"
#include "measure/phases.h"
#include "scene/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

/* Enough for a million pixels with ten rays each; any machine that can render those has this memory. */
#define RECORD_BYTES ((uint64_t)512 << 20)
/* A .glb file has at most 4 GB, at 28 bytes per triangle. */
#define MOST_TRIANGLES 150e6

typedef struct bench_render_settings {
    bench_settings all;
    args_list tracers;
    args_counts triangles, spp, threads;
    double seconds;
    fathom_integrator integrator;
} bench_render_settings;

/* One scene or generated mesh. */
typedef struct source {
    const fathom_scene *scene;
    const char *name;
    uint64_t file_bytes;
    quartiles read[BENCH_CLOCKS];
} source;

/* One render of a source. */
typedef struct measured {
    const char *spec;
    fathom_settings settings;
    double write;
    phases phases;
} measured;

/* ---- results ---- */

static json_t *pack_rays(const ray_counts *r) {
    return json_of(JSON("camera", r->camera), JSON("shadow", r->shadow), JSON("reflection", r->reflection),
                   JSON("refraction", r->refraction), JSON("repaired", r->repaired));
}

static json_t *pack_ratio(const render_time *t) {
    if (!t->has_ratio) return json_null();
    const render_ratio *r = &t->ratio;
    return json_of(JSON("renderToBare", bench_quartiles(r->render_to_bare)),
                   JSON("tracedToBare", bench_quartiles(r->traced_to_bare)),
                   JSON("renderCpuSeconds", bench_quartiles(r->render)),
                   JSON("tracedCpuSeconds", bench_quartiles(r->traced)),
                   JSON("bareCpuSeconds", bench_quartiles(r->bare)), JSON("closestRays", r->closest),
                   JSON("anyRays", r->any), JSON("bands", r->bands));
}

static json_t *pack_speeds(const render_time *t) {
    json_t *speeds = json_array();
    const uint64_t rays = ray_counts_total(&t->rays);
    for (unsigned i = 0; i < t->speed_count; ++i) {
        const render_speed *s = &t->speeds[i];
        json_array_append_new(
            speeds, json_of(JSON("threads", s->threads), JSON("seconds", bench_quartiles(s->seconds)),
                            JSON("cpuSeconds", bench_quartiles(s->cpu_seconds)),
                            JSON("speedup", bench_quartiles(s->speedup)),
                            JSON("millionRaysPerSecond", 1e-6 * (double)rays / s->seconds.median)));
    }
    return speeds;
}

static json_t *pack_run(const source *from, const measured *m) {
    const render_time *time = &m->phases.time;
    json_t *seconds =
        json_of(JSON("read", from->read[BENCH_WALL].median),
                JSON("build", m->phases.build[BENCH_WALL].median), JSON("plan", time->plan_seconds.median),
                JSON("render", time->speeds[0].seconds.median), JSON("write", m->write));
    const char *way = m->settings.integrator == FATHOM_INTEGRATOR_CLASSIC ? "classic" : "path";
    return json_of(JSON("scene", from->name), JSON("triangles", scene_triangles(from->scene)),
                   JSON("fileBytes", from->file_bytes), JSON("spec", m->spec), JSON("integrator", way),
                   JSON("spp", m->settings.spp), JSON("width", m->settings.width),
                   JSON("height", m->settings.height), JSON("tracer", m->phases.tracer),
                   JSON("bvhBytes", m->phases.bvh_bytes), JSON("bvhPeakBytes", m->phases.peak_bytes),
                   JSON("seconds", seconds), JSON("readSeconds", bench_clocks(from->read)),
                   JSON("buildSeconds", bench_clocks(m->phases.build)), JSON("rays", pack_rays(&time->rays)),
                   JSON("speeds", pack_speeds(time)), JSON("ceiling", pack_ratio(time)));
}

static void print_run(const json_t *run) {
    size_t i;
    json_t *s;
    print_name(stdout, json_text_at(run, "scene"));
    json_print(run, ", {triangles:.0f} triangles, {spec:s}\n");
    json_print(run, "{spp:.0f} spp, {integrator:s}  read {seconds.read:.3f}, build {seconds.build:.3f}, plan "
                    "{seconds.plan:.4f}, render {seconds.render:.4f}, write {seconds.write:.3f} s\n"
                    "  rays        camera {rays.camera:.0f}, shadow {rays.shadow:.0f}, reflection "
                    "{rays.reflection:.0f}, refraction {rays.refraction:.0f}\n");
    json_array_foreach(json_object_get(run, "speeds"), i, s) {
        printf("  %2.0f thread%s", json_number_at(s, "threads"),
               json_number_at(s, "threads") > 1 ? "s" : " ");
        json_print(s, "  {seconds.median:.4f} s ({seconds.low:.4f} to {seconds.high:.4f}), "
                      "{millionRaysPerSecond:.1f} Mrays/s, {speedup.median:.2f} times the first; cpu "
                      "{cpuSeconds.median:.4f} s\n");
    }
    if (json_is_object(json_object_get(run, "ceiling")))
        json_print(run, "  bare calls  {ceiling.bareCpuSeconds.median:.4f} s of one thread; through the "
                        "tracer {ceiling.tracedToBare.median:.3f} times that ({ceiling.tracedToBare.low:.3f} "
                        "to {ceiling.tracedToBare.high:.3f})\n"
                        "  all of the render phase: {ceiling.renderToBare.median:.3f} times the bare calls "
                        "({ceiling.renderToBare.low:.3f} to {ceiling.renderToBare.high:.3f})\n");
    else
        puts("  no bare calls: only the tracer embree has them, and only if its scene is not empty");
    fflush(stdout);
}

static const bench_csv csv = {
    .rows = "runs",
    .inner = "speeds",
    .columns =
        "spp, width, height, threads, seconds_low=seconds.low, seconds_median=seconds.median, "
        "seconds_high=seconds.high, cpu_seconds_median=cpuSeconds.median, speedup_median=speedup.median, "
        "rays_camera=rays.camera, rays_shadow=rays.shadow, rays_reflection=rays.reflection, "
        "rays_refraction=rays.refraction, bare_cpu_seconds_median=ceiling.bareCpuSeconds.median, "
        "render_to_bare_low=ceiling.renderToBare.low, render_to_bare_median=ceiling.renderToBare.median, "
        "render_to_bare_high=ceiling.renderToBare.high, traced_to_bare_median=ceiling.tracedToBare.median, "
        "scene, triangles, tracer=spec, file_bytes=fileBytes, bvh_bytes=bvhBytes, "
        "bvh_peak_bytes=bvhPeakBytes, read_cpu_seconds=readSeconds.cpu.median, "
        "read_seconds=readSeconds.wall.median, build_cpu_seconds=buildSeconds.cpu.median, "
        "build_seconds=buildSeconds.wall.median, plan_seconds=seconds.plan, write_seconds=seconds.write, "
        "integrator"};

/* ---- growth with the triangles ---- */

static const struct {
    const char *name, *path, *words;
} series[] = {
    {"read", "readSeconds.cpu.median", "reading"},
    {"build", "buildSeconds.cpu.median", "building"},
    {"render", "ceiling.renderCpuSeconds.median", "render phase"},
    {"bare", "ceiling.bareCpuSeconds.median", "bare calls"},
    {"renderToBare", "ceiling.renderToBare.median", "render over bare"},
};
#define SERIES (sizeof series / sizeof *series)

static bool is_alike(const json_t *a, const json_t *b) {
    return strcmp(json_text_at(a, "spec"), json_text_at(b, "spec")) == 0 &&
           (uint64_t)json_number_at(a, "spp") == (uint64_t)json_number_at(b, "spp");
}

/* Adds the exponent over all runs with the tracer and sample count of `first`; adds nothing if they are too
 * few. */
static void add_fit(json_t *fits, const json_t *runs, const json_t *first, size_t k) {
    const size_t room = json_array_size(runs);
    double *x = malloc(2 * room * sizeof *x);
    size_t count = 0, i;
    json_t *run;
    if (!x) return;
    json_array_foreach(runs, i, run) {
        if (!is_alike(run, first)) continue;
        x[count] = json_number_at(run, "triangles"), x[room + count++] = json_number_at(run, series[k].path);
    }
    const power_fit fit = power_through(x, x + room, count);
    free(x);
    if (!isfinite(fit.exponent)) return;
    json_array_append_new(fits, json_of(JSON("of", series[k].name), JSON("spec", json_text_at(first, "spec")),
                                        JSON("spp", json_number_at(first, "spp")),
                                        JSON("exponent", fit.exponent), JSON("half", fit.half),
                                        JSON("scale", fit.scale), JSON("sizes", fit.count)));
}

static json_t *pack_fits(const json_t *runs) {
    json_t *fits = json_array(), *run;
    size_t i;
    json_array_foreach(runs, i, run) {
        size_t before = 0;
        while (before < i && !is_alike(json_array_get(runs, before), run)) ++before;
        for (size_t k = 0; k < SERIES && before == i; ++k) add_fit(fits, runs, run, k);
    }
    return fits;
}

static void print_fits(const json_t *fits) {
    size_t i;
    json_t *fit;
    if (json_array_size(fits)) puts("seconds ~ triangles ^ exponent, and its 95 % interval");
    json_array_foreach(fits, i, fit) {
        size_t k = 0;
        while (k + 1 < SERIES && strcmp(series[k].name, json_text_at(fit, "of")) != 0) ++k;
        printf("%-18s", series[k].words);
        bench_print_slope(json_at(fit, "exponent"), json_at(fit, "half"), -18);
        json_print(fit, "{spp:.0f} spp, {spec:s}\n");
    }
}

static fathom_settings settings_of(const fathom_scene *scene, const bench_render_settings *asked,
                                   size_t index) {
    const args_size size = asked->all.size;
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    settings.spp = (uint32_t)asked->spp.items[index];
    settings.target_error = 0; /* so many everywhere */
    settings.aovs = 0;
    memset(settings.crop, 0, sizeof settings.crop);
    if (size.width) settings.width = size.width, settings.height = size.height;
    return settings;
}

/* Checks the combination of the scene's settings and the command line. */
static fathom_status check_settings(fathom_context *context, const fathom_scene *scene,
                                    const bench_render_settings *asked) {
    for (size_t i = 0; i < asked->spp.count; ++i) {
        fathom_settings settings = settings_of(scene, asked, i);
        if (scene_check_settings(context, &settings) != FATHOM_OK) return FATHOM_BAD_USAGE;
    }
    return FATHOM_OK;
}

/* The first `index` counts as a fraction of all, with `more` added to each count. */
static double share_before(const args_counts *counts, size_t index, double more) {
    double before = 0, all = 0;
    for (size_t i = 0; i < counts->count; ++i) {
        if (i < index) before += (double)counts->items[i] + more;
        all += (double)counts->items[i] + more;
    }
    return before / all;
}

static fathom_status write_once(fathom_context *context, const fathom_scene *scene, measured *out) {
    char path[TEMPORARY_PATH];
    fathom_status status = temporary_create(context, ".png", path);
    if (status != FATHOM_OK) return status;
    fathom_film *film;
    fathom_write_options options;
    fathom_write_options_default(&options);
    status = film_create(context, scene, &out->settings, &film);
    double began = clock_seconds();
    if (status == FATHOM_OK) status = fathom_film_write(context, film, path, &options);
    out->write = clock_seconds() - began;
    if (film) fathom_film_destroy(film);
    temporary_remove(path);
    return status;
}

/* index: in the list of samples a pixel. */
static fathom_status measure_run(fathom_context *context, const bench_render_settings *asked,
                                 const source *from, const char *spec, size_t index, const bench_watch *watch,
                                 json_t *root) {
    render_time_options options = {.repeats = asked->all.repeats,
                                   .seconds = asked->seconds,
                                   .record_bytes = RECORD_BYTES,
                                   .watch = watch};
    for (size_t i = 0; i < asked->threads.count; ++i)
        options.threads[options.thread_counts++] = (unsigned)asked->threads.items[i];
    measured *m = calloc(1, sizeof *m);
    if (!m) return fail_memory(context, sizeof *m);
    m->spec = spec;
    m->settings = settings_of(from->scene, asked, index);
    fathom_status status = phases_measure(context, from->scene, &m->settings, spec, &options, &m->phases);
    if (status == FATHOM_OK) status = write_once(context, from->scene, m);
    if (status == FATHOM_OK) status = fathom_scene_check_files(from->scene);
    if (status == FATHOM_OK) {
        json_t *run = pack_run(from, m);
        bench_add_tracer(root, m->phases.tracer);
        progress_clear_line();
        if (!asked->all.common.quiet) print_run(run);
        json_array_append_new(json_object_get(root, "runs"), run);
    }
    free(m);
    return status;
}

static fathom_status measure_source(fathom_context *context, const bench_render_settings *asked,
                                    const args_list *tracers, const char *name, const char *path,
                                    const bench_watch *watch, json_t *root) {
    fathom_read_options read;
    fathom_read_options_default(&read);
    read.width = asked->all.size.width, read.height = asked->all.size.height;
    read.choose_integrator = true, read.integrator = asked->integrator;
    read.own_spp = true;
    const render_time_options options = {.repeats = asked->all.repeats, .seconds = asked->seconds};
    struct stat info;
    source from = {.name = name, .file_bytes = stat(path, &info) == 0 ? (uint64_t)info.st_size : 0};
    fathom_scene *scene;
    fathom_status status = phases_read(context, path, &read, &options, &scene, from.read);
    from.scene = scene;
    if (status == FATHOM_OK) status = check_settings(context, scene, asked);
    for (size_t i = 0; i < asked->spp.count * tracers->count && status == FATHOM_OK; ++i) {
        const size_t t = i % tracers->count, s = i / tracers->count;
        const double begin = share_before(&asked->spp, s, 0), end = share_before(&asked->spp, s + 1, 0);
        const double each = (end - begin) / (double)tracers->count, at = begin + each * (double)t;
        const bench_watch part = bench_watch_part(watch, at, at + each);
        status = measure_run(context, asked, &from, tracers->items[t], s, &part, root);
    }
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status measure_sphere(fathom_context *context, const bench_render_settings *asked,
                                    const args_list *tracers, uint64_t triangles, const bench_watch *watch,
                                    json_t *root) {
    char path[TEMPORARY_PATH];
    fathom_scene *scene;
    fathom_status status = temporary_create(context, ".glb", path);
    if (status != FATHOM_OK) return status;
    fathom_context_set_threads(context, 0);
    status = bench_sphere(context, triangles, &scene);
    if (status == FATHOM_OK) status = fathom_scene_write(scene, path);
    fathom_scene_destroy(scene);
    if (status == FATHOM_OK)
        status = measure_source(context, asked, tracers, "generated sphere", path, watch, root);
    temporary_remove(path);
    return status;
}

/* Rendering takes about the time of reading and building a million triangles. */
#define RENDER_WORK 1e6

static fathom_status measure_all(fathom_context *context, const bench_render_settings *asked,
                                 const args_list *tracers, json_t *root) {
    const double scenes = asked->all.scene != NULL, spheres = (double)asked->triangles.count;
    const bench_watch all = bench_progress_part(0, 1);
    const bench_watch first = bench_watch_part(&all, 0, scenes / (scenes + spheres)),
                      others = bench_watch_part(&all, scenes / (scenes + spheres), 1);
    fathom_status status = FATHOM_OK;
    if (asked->all.scene)
        status = measure_source(context, asked, tracers, asked->all.scene, asked->all.scene, &first, root);
    for (size_t i = 0; i < asked->triangles.count && status == FATHOM_OK; ++i) {
        const bench_watch part = bench_watch_part(&others, share_before(&asked->triangles, i, RENDER_WORK),
                                                  share_before(&asked->triangles, i + 1, RENDER_WORK));
        status = measure_sphere(context, asked, tracers, asked->triangles.items[i], &part, root);
    }
    return status;
}

static fathom_status measure(fathom_context *context, const void *user, json_t *root) {
    static const args_list embree = {{"embree"}, 1};
    const bench_render_settings *asked = user;
    const args_list *tracers = asked->tracers.count ? &asked->tracers : &embree;
    fathom_status status = FATHOM_OK;
    if (!asked->all.scene && !asked->triangles.count)
        return fail(context, FATHOM_BAD_USAGE, "bench render: SCENE is missing; expected it or --triangles");
    if (asked->threads.count > RENDER_TIME_THREADS_MAX)
        return fail(context, FATHOM_BAD_USAGE, "--threads: expected at most 8 numbers");
    for (size_t i = 0; i < tracers->count && status == FATHOM_OK; ++i)
        status = fathom_tracer_check(context, tracers->items[i]);
    json_t *runs = json_array();
    json_add(root, JSON("repeats", asked->all.repeats), JSON("runs", runs));
    if (status == FATHOM_OK) status = measure_all(context, asked, tracers, root);
    if (status != FATHOM_OK) return status;
    json_add(root, JSON("fits", pack_fits(runs)));
    if (!asked->all.common.quiet) print_fits(json_object_get(root, "fits"));
    return FATHOM_OK;
}

#define FIELD(name) offsetof(bench_render_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_list, FIELD(tracers), 0, 0,
     "tracer (embree); may be given several times, such as embree:low and embree:medium"},
    {"triangles", 't', "N,N", take_counts, FIELD(triangles), 1, MOST_TRIANGLES,
     "generate spheres of so many triangles, such as 10k,100k,1M, after SCENE or instead of it; "
     "the files are made in $TMPDIR and removed"},
    {"integrator", 0, "classic|path", take_choice, FIELD(integrator), 0, 0,
     "integrator, in place of that of SCENE (classic)"},
    BENCH_SIZE,
    {"spp", 0, "N,N", take_counts, FIELD(spp), 1, 65536, "samples per pixel, one run each (1,16)"},
    {"threads", 0, "N,N", take_counts, FIELD(threads), 1, 1024,
     "numbers of threads; the speedup is over the first (1,2)"},
    BENCH_REPEATS(RENDER_TIME_REPEATS_MAX, "repetitions; the results are their medians and quartiles (9)"),
    {"seconds", 0, "S", take_f64, FIELD(seconds), 0, 1e6,
     "reading, or building, is not repeated after this time (2)"},
    COMMAND_ALLOW_OUTSIDE,
    BENCH_RESULTS,
};

const command command_bench_render = {
    .name = "bench render",
    .usage = "[SCENE] [--triangles N,N] [options]",
    .summary = "Measure the phases of a render, and compare them with Embree alone.",
    .text = "Records the rays of a render, and traces them again with Embree's calls alone\n"
            "(\"bare calls\"): same scene, packets, flags and masks. Planes, and spheres if\n"
            "there are at most 16, are not in Embree's scene, so bare calls leave them out.\n"
            "The render phase takes longer, because it also makes rays, shades surfaces and\n"
            "fills the film. Render and bare calls take turns; each turn gives one ratio of\n"
            "their CPU times on one thread. Files are read from the system's cache.\n"
            "With meshes of several sizes, also prints the exponents b of seconds = a *\n"
            "triangles^b with their 95 % intervals: 1 is linear. If that of render over bare\n"
            "is 0 or less, the renderer slows down no faster than Embree itself.\n",
    .examples = "  fathom bench render forest.glb\n"
                "  fathom bench render forest.glb --tracer embree:low --tracer embree:medium\n"
                "  fathom bench render --triangles 10k,100k,1M,10M --spp 1 --report results\n",
    .args = {options, {{"SCENE", BENCH_FIELD(scene)}}, 1},
    COMMAND_BODY(bench_run, bench_render_settings,
                 {.all = {.command = &command_bench_render, .measure = measure, .table = &csv, .repeats = 9},
                  .spp = {{1, 16}, 2},
                  .threads = {{1, 2}, 2},
                  .seconds = 2}),
};
