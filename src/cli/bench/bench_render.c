/* `fathom bench render`: the phases of a render, and what it takes beyond Embree's bare calls. */
#include "cli/bench/bench.h"
#include "cli/bench/bench_output.h"
#include "cli/bench/bench_run.h"
#include "cli/json_text.h"
#include "cli/render/progress.h"
#include "cli/temporary.h"

#include "base/clock.h"
#include "film/film.h"
#include "integrate/plan.h"
#include "measure/render_time.h"
#include "scene/scene.h"

#include <stdlib.h>
#include <string.h>

#define DEFAULT_REPEATS 9
/* Enough for a million pixels of ten rays; no machine that renders them lacks it. */
#define RECORD_BYTES ((uint64_t)512 << 20)

typedef struct bench_render_settings {
    const char *scene, *tracer;
    args_counts spp, threads;
    args_size size;
    uint32_t repeats;
    bool quiet;
    bench_output output;
    bool allow_outside;
} bench_render_settings;

/* ---- the phases ---- */

typedef struct measured {
    double read, build, build_cpu, write;
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

static fathom_status measure(fathom_context *context, const fathom_scene *scene, const trace_spec *spec,
                             const fathom_settings *settings, const bench_render_settings *asked,
                             const bench_watch *watch, measured *out) {
    render_time_options options = {.repeats = asked->repeats, .record_bytes = RECORD_BYTES, .watch = watch};
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
    return json_pack("{s:o, s:o, s:o, s:o, s:o}", "camera", json_count(r->camera), "shadow",
                     json_count(r->shadow), "reflection", json_count(r->reflection), "refraction",
                     json_count(r->refraction), "repaired", json_count(r->repaired));
}

static json_t *pack_ratio(const render_time *t) {
    if (!t->has_ratio) return json_null();
    const render_ratio *r = &t->ratio;
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "renderToBare",
                     bench_quartiles(r->render_to_bare), "tracedToBare", bench_quartiles(r->traced_to_bare),
                     "renderCpuSeconds", bench_quartiles(r->render), "tracedCpuSeconds",
                     bench_quartiles(r->traced), "bareCpuSeconds", bench_quartiles(r->bare), "closestRays",
                     json_count(r->closest), "anyRays", json_count(r->any), "bands", json_count(r->bands));
}

static json_t *pack_speeds(const render_time *t) {
    json_t *speeds = json_array();
    uint64_t rays = t->rays.camera + t->rays.shadow + t->rays.reflection + t->rays.refraction;
    for (unsigned i = 0; i < t->speed_count; ++i) {
        const render_speed *s = &t->speeds[i];
        json_array_append_new(
            speeds, json_pack("{s:o, s:o, s:o, s:o, s:o, s:f}", "threads", json_count(s->threads), "seconds",
                              bench_quartiles(s->seconds), "cpuSeconds", bench_quartiles(s->cpu_seconds),
                              "speedup", bench_quartiles(s->speedup), "bareSpeedup",
                              s->bare_speedup.median > 0 ? bench_quartiles(s->bare_speedup) : json_null(),
                              "millionRaysPerSecond", 1e-6 * (double)rays / s->seconds.median));
    }
    return speeds;
}

static json_t *pack_run(const fathom_settings *settings, const measured *m) {
    json_t *phases =
        json_pack("{s:f, s:f, s:f, s:f, s:f}", "read", m->read, "build", m->build, "plan",
                  m->time.plan_seconds.median, "render", m->time.speeds[0].seconds.median, "write", m->write);
    return json_pack("{s:i, s:i, s:i, s:s, s:o, s:o, s:f, s:o, s:o, s:o}", "spp", (int)settings->spp, "width",
                     (int)settings->width, "height", (int)settings->height, "tracer", m->tracer, "bvhBytes",
                     json_count(m->bvh_bytes), "seconds", phases, "buildCpuSeconds", m->build_cpu, "rays",
                     pack_rays(&m->time.rays), "speeds", pack_speeds(&m->time), "ceiling",
                     pack_ratio(&m->time));
}

static void print_speeds(const json_t *run) {
    size_t i;
    json_t *s;
    json_array_foreach(json_object_get(run, "speeds"), i, s) {
        printf("  %2.0f thread%s  %.4f s (%.4f to %.4f), %.1f Mrays/s, %.2f times the first; cpu %.4f s",
               bench_number(s, "threads", NULL), bench_number(s, "threads", NULL) > 1 ? "s" : " ",
               bench_number(s, "seconds", "median"), bench_number(s, "seconds", "low"),
               bench_number(s, "seconds", "high"), bench_number(s, "millionRaysPerSecond", NULL),
               bench_number(s, "speedup", "median"), bench_number(s, "cpuSeconds", "median"));
        double bare = bench_number(s, "bareSpeedup", "median");
        if (i > 0 && bare > 0) printf("; bare calls %.2f times", bare);
        putchar('\n');
    }
}

static void print_run(const json_t *run) {
    printf("%.0f spp  read %.3f, build %.3f, plan %.4f, render %.4f, write %.3f s\n",
           bench_number(run, "spp", NULL), bench_number(run, "seconds", "read"),
           bench_number(run, "seconds", "build"), bench_number(run, "seconds", "plan"),
           bench_number(run, "seconds", "render"), bench_number(run, "seconds", "write"));
    printf("  rays        camera %.0f, shadow %.0f, reflection %.0f, refraction %.0f\n",
           bench_number(run, "rays", "camera"), bench_number(run, "rays", "shadow"),
           bench_number(run, "rays", "reflection"), bench_number(run, "rays", "refraction"));
    print_speeds(run);
    const json_t *c = json_object_get(run, "ceiling");
    if (!json_is_object(c)) {
        puts("  no bare form of this tracer: expected embree, but not by streams");
        return;
    }
    printf("  bare calls  %.4f s of one thread; through the tracer %.3f times that (%.3f to %.3f)\n",
           bench_number(c, "bareCpuSeconds", "median"), bench_number(c, "tracedToBare", "median"),
           bench_number(c, "tracedToBare", "low"), bench_number(c, "tracedToBare", "high"));
    printf("  all of the render phase: %.3f times the bare calls (%.3f to %.3f)\n",
           bench_number(c, "renderToBare", "median"), bench_number(c, "renderToBare", "low"),
           bench_number(c, "renderToBare", "high"));
}

static void put_csv(FILE *out, const json_t *root) {
    fputs("spp,width,height,threads,seconds_low,seconds_median,seconds_high,cpu_seconds_median,"
          "speedup_median,rays_camera,rays_shadow,rays_reflection,rays_refraction,bare_cpu_seconds_median,"
          "render_to_bare_low,render_to_bare_median,render_to_bare_high,traced_to_bare_median,"
          "bare_speedup_median\n",
          out);
    size_t i, k;
    json_t *run, *s;
    json_array_foreach(json_object_get(root, "runs"), i, run) {
        const json_t *c = json_object_get(run, "ceiling");
        json_array_foreach(json_object_get(run, "speeds"), k, s) {
            fprintf(out, "%.0f,%.0f,%.0f,%.0f,%.6g,%.6g,%.6g,%.6g,%.5g,%.0f,%.0f,%.0f,%.0f",
                    bench_number(run, "spp", NULL), bench_number(run, "width", NULL),
                    bench_number(run, "height", NULL), bench_number(s, "threads", NULL),
                    bench_number(s, "seconds", "low"), bench_number(s, "seconds", "median"),
                    bench_number(s, "seconds", "high"), bench_number(s, "cpuSeconds", "median"),
                    bench_number(s, "speedup", "median"), bench_number(run, "rays", "camera"),
                    bench_number(run, "rays", "shadow"), bench_number(run, "rays", "reflection"),
                    bench_number(run, "rays", "refraction"));
            fprintf(out, ",%.6g,%.5g,%.5g,%.5g,%.5g,%.5g\n", bench_number(c, "bareCpuSeconds", "median"),
                    bench_number(c, "renderToBare", "low"), bench_number(c, "renderToBare", "median"),
                    bench_number(c, "renderToBare", "high"), bench_number(c, "tracedToBare", "median"),
                    bench_number(s, "bareSpeedup", "median"));
        }
    }
}

/* ---- the command ---- */

static fathom_settings settings_of(const fathom_scene *scene, const bench_render_settings *asked,
                                   size_t index) {
    fathom_settings settings;
    fathom_scene_settings(scene, &settings);
    settings.spp = (uint32_t)asked->spp.items[index];
    settings.aovs = 0;
    memset(settings.crop, 0, sizeof settings.crop);
    if (asked->size.width) settings.width = asked->size.width, settings.height = asked->size.height;
    return settings;
}

static json_t *head(const bench_render_settings *asked, const fathom_scene *scene) {
    json_t *root = bench_head("render");
    json_object_set_new(root, "scene", json_text(asked->scene));
    json_object_set_new(root, "triangles", json_count(scene_triangles(scene)));
    json_object_set_new(root, "lights", json_count(scene->lights.count));
    json_object_set_new(root, "spec", json_text(asked->tracer));
    json_object_set_new(root, "repeats", json_count(asked->repeats));
    json_object_set_new(root, "runs", json_array());
    return root;
}

/* What the scene and the command line make of each other. */
static fathom_status check_settings(fathom_context *context, const fathom_scene *scene,
                                    const bench_render_settings *asked) {
    for (size_t i = 0; i < asked->spp.count; ++i) {
        fathom_settings settings = settings_of(scene, asked, i);
        if (scene_check_settings(context, &settings) != FATHOM_OK) return FATHOM_BAD_USAGE;
    }
    return FATHOM_OK;
}

static fathom_status measure_one(fathom_context *context, const fathom_scene *scene, const trace_spec *spec,
                                 const fathom_settings *settings, const bench_render_settings *asked,
                                 const bench_watch *watch, double read, json_t *root) {
    measured *m = calloc(1, sizeof *m);
    if (!m) return fail_memory(context, sizeof *m);
    fathom_status status = measure(context, scene, spec, settings, asked, watch, m);
    if (status == FATHOM_OK) status = fathom_scene_check_files(scene);
    if (status == FATHOM_OK) {
        m->read = read;
        json_t *run = pack_run(settings, m);
        bench_head_tracer(root, m->tracer);
        progress_clear_line();
        if (!asked->quiet) print_run(run);
        fflush(stdout);
        json_array_append_new(json_object_get(root, "runs"), run);
    }
    free(m);
    return status;
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

static fathom_status measure_all(fathom_context *context, const bench_render_settings *asked,
                                 const trace_spec *spec) {
    fathom_scene *scene;
    const fathom_read_options read_options = {.width = asked->size.width, .height = asked->size.height};
    double began = clock_seconds();
    fathom_status status = fathom_scene_read_with(context, asked->scene, &read_options, &scene);
    double read = clock_seconds() - began;
    if (status != FATHOM_OK) return status;
    json_t *root = head(asked, scene);
    status = check_settings(context, scene, asked);
    for (size_t i = 0; i < asked->spp.count && status == FATHOM_OK; ++i) {
        fathom_settings settings = settings_of(scene, asked, i);
        const bench_watch watch = bench_progress_part(work_before(asked, i), work_before(asked, i + 1));
        status = measure_one(context, scene, spec, &settings, asked, &watch, read, root);
    }
    if (status == FATHOM_OK) status = bench_output_write(context, &asked->output, root, put_csv);
    json_decref(root);
    fathom_scene_destroy(scene);
    return status;
}

static fathom_status bench(fathom_context *context, const void *user) {
    const bench_render_settings *asked = user;
    if (asked->threads.count > RENDER_TIME_THREADS_MAX)
        return fail(context, FATHOM_BAD_USAGE, "--threads: expected at most 8 numbers");
    trace_spec spec;
    fathom_status status = trace_spec_parse(context, asked->tracer, &spec);
    if (status == FATHOM_OK) status = bench_output_check(context, &asked->output, asked->scene);
    if (status != FATHOM_OK) return status;
    bench_progress_begin(asked->quiet);
    return measure_all(context, asked, &spec);
}

static fathom_status run(int argc, char **argv) {
    bench_render_settings asked = {
        .tracer = "embree", .spp = {{1, 16}, 2}, .threads = {{1, 2}, 2}, .repeats = DEFAULT_REPEATS};
    fathom_status status;
    if (!command_parse(&command_bench_render, argc, argv, &asked, &status)) return status;
    return bench_run(&command_bench_render, 0, asked.allow_outside, bench, &asked);
}

#define FIELD(name) offsetof(bench_render_settings, name)

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_text, FIELD(tracer), 0, 0, "what answers the rays (embree)"},
    {"size", 0, "WxH", take_size, FIELD(size), 1, 65536, "pixels (the scene's, else 1280x720)"},
    {"spp", 0, "N,N", take_counts, FIELD(spp), 1, 65536, "samples a pixel, one run each (1,16)"},
    {"threads", 0, "N,N", take_counts, FIELD(threads), 1, 1024,
     "how many render; the speedup is over the first (1,2)"},
    {"repeats", 0, "N", take_u32, FIELD(repeats), 1, RENDER_TIME_REPEATS_MAX,
     "of which medians and quartiles are told (9)"},
    COMMAND_ALLOW_OUTSIDE(bench_render_settings),
    BENCH_OUTPUT_OPTIONS(bench_render_settings),
    {.help = NULL},
};
static const char *const operands[] = {"SCENE"};
static const size_t operand_offsets[] = {FIELD(scene)};

const command command_bench_render = {
    .name = "bench render",
    .usage = "SCENE [options]",
    .summary = "Measure the phases of a render, and its distance from Embree's ceiling.",
    .text = "The rays of the render itself are recorded, and asked again by nothing but\n"
            "Embree's calls, with the same scene, packets, flags and masks. What the render\n"
            "phase takes beyond that is the renderer's own: rays made, answers settled,\n"
            "surfaces shaded, samples filmed. Render and bare calls take turns, and the\n"
            "ratio is of the processor time of one thread, of each turn by itself. Beside the\n"
            "speedup of threads stands what as many threads gain that ask all bare calls at\n"
            "once: what the machine allows.\n",
    .examples = "  fathom generate sphere --triangles 8M -o heavy.glb\n"
                "  fathom bench render heavy.glb\n"
                "  fathom bench render heavy.glb --spp 1 --tracer embree:avx2:8 --json avx2.json\n",
    .args = {options, operands, operand_offsets, 1},
    .run = run,
};
