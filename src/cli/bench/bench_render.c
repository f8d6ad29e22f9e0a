/* `fathom bench render`: the phases of a render, and what it takes beyond Embree's bare calls. */
#include "cli/bench/bench.h"
#include "cli/outputs.h"

#include "base/clock.h"
#include "base/status.h"
#include "film/film.h"
#include "integrate/plan.h"
#include "measure/render_time.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

/* Enough for a million pixels of ten rays; no machine that renders them lacks it. */
#define RECORD_BYTES ((uint64_t)512 << 20)

typedef struct bench_render_settings {
    bench_settings all;
    args_counts spp, threads;
} bench_render_settings;

/* ---- the phases ---- */

typedef struct measured {
    double build, build_cpu, write;
    uint64_t bvh_bytes;
    char tracer[64];
    render_time time;
} measured;

static fathom_status write_once(fathom_context *context, const fathom_scene *scene,
                                const fathom_settings *settings, double *seconds) {
    char path[TEMPORARY_PATH];
    fathom_status status = temporary_create(context, ".png", path);
    if (status != FATHOM_OK) return status;
    fathom_film *film;
    fathom_write_options options;
    fathom_write_options_default(&options);
    status = film_create(context, scene, settings, &film);
    double began = clock_seconds();
    if (status == FATHOM_OK) status = fathom_film_write(context, film, path, &options);
    *seconds = clock_seconds() - began;
    if (film) fathom_film_destroy(film);
    temporary_remove(path);
    return status;
}

static fathom_status build(fathom_context *context, const world *w, const trace_spec *spec,
                           const fathom_settings *settings, measured *out, trace_tracer **tracer) {
    trace_options options = {.spec = spec,
                             .width = settings->block_width,
                             .expected_rays = plan_expected_rays(w->scene, settings)};
    double began = clock_seconds(), cpu = clock_process_seconds();
    fathom_status status = trace_create(context, w, &options, tracer);
    out->build += clock_seconds() - began;
    out->build_cpu += clock_process_seconds() - cpu;
    if (status != FATHOM_OK) return status;
    out->bvh_bytes = trace_bvh_bytes(*tracer);
    snprintf(out->tracer, sizeof out->tracer, "%s", trace_name(*tracer));
    return FATHOM_OK;
}

static fathom_status measure_phases(fathom_context *context, const fathom_scene *scene,
                                    const trace_spec *spec, const fathom_settings *settings,
                                    const bench_render_settings *asked, const bench_watch *watch,
                                    measured *out) {
    render_time_options options = {
        .repeats = asked->all.repeats, .record_bytes = RECORD_BYTES, .watch = watch};
    for (size_t i = 0; i < asked->threads.count; ++i)
        options.threads[options.thread_counts++] = (unsigned)asked->threads.items[i];
    fathom_context_set_threads(context, 0);
    world *w = NULL;
    trace_tracer *tracer = NULL;
    double began = clock_seconds();
    fathom_status status = world_create(scene, &w);
    out->build = clock_seconds() - began;
    if (status == FATHOM_OK) status = world_check(w);
    if (status == FATHOM_OK) status = build(context, w, spec, settings, out, &tracer);
    if (status == FATHOM_OK) status = render_time_measure(context, w, tracer, settings, &options, &out->time);
    trace_destroy(tracer);
    world_destroy(w);
    return status == FATHOM_OK ? write_once(context, scene, settings, &out->write) : status;
}

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
    uint64_t rays = t->rays.camera + t->rays.shadow + t->rays.reflection + t->rays.refraction;
    for (unsigned i = 0; i < t->speed_count; ++i) {
        const render_speed *s = &t->speeds[i];
        json_t *bare = s->bare_speedup.median > 0 ? bench_quartiles(s->bare_speedup) : json_null();
        json_array_append_new(
            speeds, json_of(JSON("threads", s->threads), JSON("seconds", bench_quartiles(s->seconds)),
                            JSON("cpuSeconds", bench_quartiles(s->cpu_seconds)),
                            JSON("speedup", bench_quartiles(s->speedup)), JSON("bareSpeedup", bare),
                            JSON("millionRaysPerSecond", 1e-6 * (double)rays / s->seconds.median)));
    }
    return speeds;
}

static json_t *pack_run(const fathom_settings *settings, const measured *m, double read) {
    json_t *phases =
        json_of(JSON("read", read), JSON("build", m->build), JSON("plan", m->time.plan_seconds.median),
                JSON("render", m->time.speeds[0].seconds.median), JSON("write", m->write));
    return json_of(JSON("spp", settings->spp), JSON("width", settings->width),
                   JSON("height", settings->height), JSON("tracer", m->tracer),
                   JSON("bvhBytes", m->bvh_bytes), JSON("seconds", phases),
                   JSON("buildCpuSeconds", m->build_cpu), JSON("rays", pack_rays(&m->time.rays)),
                   JSON("speeds", pack_speeds(&m->time)), JSON("ceiling", pack_ratio(&m->time)));
}

static void print_run(const json_t *run) {
    size_t i;
    json_t *s;
    json_print(run,
               "{spp:.0f} spp  read {seconds.read:.3f}, build {seconds.build:.3f}, plan {seconds.plan:.4f}, "
               "render {seconds.render:.4f}, write {seconds.write:.3f} s\n"
               "  rays        camera {rays.camera:.0f}, shadow {rays.shadow:.0f}, reflection "
               "{rays.reflection:.0f}, refraction {rays.refraction:.0f}\n");
    json_array_foreach(json_object_get(run, "speeds"), i, s) {
        printf("  %2.0f thread%s", json_number_at(s, "threads"),
               json_number_at(s, "threads") > 1 ? "s" : " ");
        json_print(s, "  {seconds.median:.4f} s ({seconds.low:.4f} to {seconds.high:.4f}), "
                      "{millionRaysPerSecond:.1f} Mrays/s, {speedup.median:.2f} times the first; cpu "
                      "{cpuSeconds.median:.4f} s");
        if (i > 0 && json_number_at(s, "bareSpeedup.median") > 0)
            json_print(s, "; bare calls {bareSpeedup.median:.2f} times");
        putchar('\n');
    }
    if (json_is_object(json_object_get(run, "ceiling")))
        json_print(run,
                   "  bare calls  {ceiling.bareCpuSeconds.median:.4f} s of one thread; through the tracer "
                   "{ceiling.tracedToBare.median:.3f} times that ({ceiling.tracedToBare.low:.3f} to "
                   "{ceiling.tracedToBare.high:.3f})\n"
                   "  all of the render phase: {ceiling.renderToBare.median:.3f} times the bare calls "
                   "({ceiling.renderToBare.low:.3f} to {ceiling.renderToBare.high:.3f})\n");
    else
        puts("  no bare form of this tracer: expected embree, but not by streams");
    fflush(stdout);
}

static const bench_csv csv = {
    .rows = "runs",
    .inner = "speeds",
    .columns = "spp, width, height, threads, seconds_low=seconds.low, seconds_median=seconds.median, "
               "seconds_high=seconds.high, cpu_seconds_median=cpuSeconds.median, "
               "speedup_median=speedup.median, rays_camera=rays.camera, rays_shadow=rays.shadow, "
               "rays_reflection=rays.reflection, rays_refraction=rays.refraction, "
               "bare_cpu_seconds_median=ceiling.bareCpuSeconds.median, "
               "render_to_bare_low=ceiling.renderToBare.low, "
               "render_to_bare_median=ceiling.renderToBare.median, "
               "render_to_bare_high=ceiling.renderToBare.high, "
               "traced_to_bare_median=ceiling.tracedToBare.median, bare_speedup_median=bareSpeedup.median"};

/* ---- the command ---- */

static fathom_settings settings_of(const fathom_scene *scene, const bench_render_settings *asked,
                                   size_t index) {
    const args_size size = asked->all.size;
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    settings.spp = (uint32_t)asked->spp.items[index];
    settings.aovs = 0;
    memset(settings.crop, 0, sizeof settings.crop);
    if (size.width) settings.width = size.width, settings.height = size.height;
    return settings;
}

/* The settings that come of the scene and the command line together. */
static fathom_status check_settings(fathom_context *context, const fathom_scene *scene,
                                    const bench_render_settings *asked) {
    for (size_t i = 0; i < asked->spp.count; ++i) {
        fathom_settings settings = settings_of(scene, asked, i);
        if (scene_check_settings(context, &settings) != FATHOM_OK) return FATHOM_BAD_USAGE;
    }
    return FATHOM_OK;
}

/* The part of all work that comes before run `index`: it is in proportion to the samples. */
static double work_before(const bench_render_settings *asked, size_t index) {
    double before = 0, all = 0;
    for (size_t i = 0; i < asked->spp.count; ++i) {
        if (i < index) before += (double)asked->spp.items[i];
        all += (double)asked->spp.items[i];
    }
    return before / all;
}

static fathom_status measure_run(fathom_context *context, const fathom_scene *scene, const trace_spec *spec,
                                 const bench_render_settings *asked, size_t index, double read,
                                 json_t *root) {
    const fathom_settings settings = settings_of(scene, asked, index);
    const bench_watch watch = bench_progress_part(work_before(asked, index), work_before(asked, index + 1));
    measured *m = calloc(1, sizeof *m);
    if (!m) return fail_memory(context, sizeof *m);
    fathom_status status = measure_phases(context, scene, spec, &settings, asked, &watch, m);
    if (status == FATHOM_OK) status = fathom_scene_check_files(scene);
    if (status == FATHOM_OK) {
        json_t *run = pack_run(&settings, m, read);
        bench_add_tracer(root, m->tracer);
        progress_clear_line();
        if (!asked->all.common.quiet) print_run(run);
        json_array_append_new(json_object_get(root, "runs"), run);
    }
    free(m);
    return status;
}

static fathom_status measure(fathom_context *context, const void *user, json_t *root) {
    const bench_render_settings *asked = user;
    const fathom_read_options read_options = {.width = asked->all.size.width,
                                              .height = asked->all.size.height};
    trace_spec spec;
    fathom_scene *scene;
    if (asked->threads.count > RENDER_TIME_THREADS_MAX)
        return fail(context, FATHOM_BAD_USAGE, "--threads: expected at most 8 numbers");
    fathom_status status = trace_spec_parse(context, asked->all.tracer, &spec);
    if (status != FATHOM_OK) return status;
    const double began = clock_seconds();
    status = fathom_scene_read_with(context, asked->all.scene, &read_options, &scene);
    const double read = clock_seconds() - began;
    if (status != FATHOM_OK) return status;
    bench_add_asked(root, &asked->all);
    json_add(root, JSON("triangles", scene_triangles(scene)), JSON("lights", scene->lights.count),
             JSON("runs", json_array()));
    status = check_settings(context, scene, asked);
    for (size_t i = 0; i < asked->spp.count && status == FATHOM_OK; ++i)
        status = measure_run(context, scene, &spec, asked, i, read, root);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status run(int argc, char **argv) {
    bench_render_settings asked = {
        .all = {.tracer = "embree", .repeats = 9}, .spp = {{1, 16}, 2}, .threads = {{1, 2}, 2}};
    return bench_run(&(bench_kind){&command_bench_render, measure, &csv}, argc, argv, &asked);
}

#define FIELD(name) offsetof(bench_render_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_text, BENCH_FIELD(tracer), 0, 0, "what answers the rays (embree)"},
    BENCH_SIZE,
    {"spp", 0, "N,N", take_counts, FIELD(spp), 1, 65536, "samples a pixel, one run each (1,16)"},
    {"threads", 0, "N,N", take_counts, FIELD(threads), 1, 1024,
     "how many render; the speedup is over the first (1,2)"},
    BENCH_REPEATS(RENDER_TIME_REPEATS_MAX, "repetitions; the results are their medians and quartiles (9)"),
    COMMAND_ALLOW_OUTSIDE(command_common),
    BENCH_RESULTS,
};

const command command_bench_render = {
    .name = "bench render",
    .usage = "SCENE [options]",
    .summary = "Measure the phases of a render, and its distance from Embree's ceiling.",
    .text = "Records the rays of the render itself and traces them again by nothing but\n"
            "Embree's calls, with the same scene, packets, flags and masks. The time that the\n"
            "render phase takes beyond that is the renderer's own: it makes rays, shades\n"
            "surfaces and fills the film. Render and bare calls take turns, and the\n"
            "ratio is of the processor time of one thread, of each turn by itself. Next to\n"
            "the speedup of threads stands the speedup of as many threads that make only the\n"
            "bare calls: the machine allows no more.\n",
    .examples = "  fathom generate sphere --triangles 8M -o heavy.glb\n"
                "  fathom bench render heavy.glb\n"
                "  fathom bench render heavy.glb --spp 1 --tracer embree:avx2:8 --json avx2.json\n",
    .args = {options, bench_operands, bench_operand_offsets, 1},
    .run = run,
};
