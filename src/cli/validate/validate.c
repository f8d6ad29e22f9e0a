#include "cli/validate/validate.h"

#include "base/clock.h"
#include "base/threads.h"
#include "cli/interrupt.h"
#include "cli/outputs.h"
#include "cli/render/progress.h"
#include "cli/report.h"

#include <fathom/trace.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Insertion sort, because it is stable and there are few runs: keeps the order of scenes within each
 * tracer. */
static void sort_by_tracer(validate_runs *runs) {
    for (size_t i = 1; i < runs->count; ++i) {
        const validate_run run = runs->items[i];
        size_t at = i;
        for (; at > 0 && strcmp(runs->items[at - 1].spec, run.spec) > 0; --at)
            runs->items[at] = runs->items[at - 1];
        runs->items[at] = run;
    }
}

/* others: also count the results that depend on the way of calling. */
static uint64_t count_all(const validate_results *results, verdict v, bool others) {
    uint64_t sum = validate_extremes_total(&results->extremes, v);
    for (size_t i = 0; i < results->runs.count; ++i) {
        const compare_family all = validate_sum(&results->runs.items[i]);
        sum += all.counts[v] + all.any_counts[v] + (others ? all.other_counts[v] : 0);
    }
    return sum;
}

/* Stores the findings about a tracer as a whole in its first run. */
static bool check_tracers(validate_runs *runs) {
    for (size_t i = 0, end; i < runs->count; i = end) {
        validate_run *run = &runs->items[i];
        const compare_family sum = validate_sum_tracer(runs, i, &end);
        if (!statistics_tracer(&run->kind, run->unit, &sum, &run->findings)) return false;
    }
    return true;
}

static uint64_t count_findings(const validate_runs *runs) {
    uint64_t sum = 0;
    for (size_t i = 0; i < runs->count; ++i) sum += runs->items[i].findings.count;
    return sum;
}

static void print(const validate_settings *settings, const validate_results *results, uint64_t wrong) {
    validate_print(&results->runs, settings);
    if (settings->extremes) validate_extremes_print(&results->extremes, settings);
    validate_shading_print(&results->shading, settings);
    validate_print_findings(results);
    uint64_t found = count_findings(&results->runs);
    printf("\n%llu wrong, ", (unsigned long long)wrong);
    if (found) printf("%llu statistics out of bounds, ", (unsigned long long)found);
    printf("%llu tracer leaks, %.1f s\n", (unsigned long long)count_all(results, VERDICT_LEAK, false),
           clock_seconds() - results->start);
}

static fathom_status write_results(fathom_context *context, const validate_settings *settings,
                                   validate_results *results, uint64_t *wrong) {
    fathom_status status = FATHOM_OK;
    sort_by_tracer(&results->runs);
    if (!check_tracers(&results->runs)) return fail_memory(context, sizeof(statistics_finding));
    *wrong = count_all(results, VERDICT_WRONG, true) + validate_shading_wrong(&results->shading);
    if (!settings->common.quiet) print(settings, results, *wrong);
    if (settings->json || settings->report) status = validate_write_json(context, results, settings);
    if (status == FATHOM_OK && settings->failures)
        status = validate_write_failures(context, results, settings);
    return status;
}

static fathom_status check(fathom_context *context, const validate_settings *settings) {
    const char *const files[] = {settings->json, settings->failures};
    if (outputs_is_standard(settings->failures))
        return fail(context, FATHOM_BAD_USAGE, "--failures: expected a file, found standard output");
    fathom_status status = report_check_files(context, files, settings->report, settings->scene);
    for (size_t i = 0; i < settings->tracers.count && status == FATHOM_OK; ++i)
        status = fathom_tracer_check(context, settings->tracers.items[i]);
    return status;
}

static void free_results(validate_results *results) {
    for (size_t i = 0; i < results->runs.count; ++i) {
        compare_result_free(&results->runs.items[i].result);
        array_free(&results->runs.items[i].findings);
        free(results->runs.items[i].scene);
        free(results->runs.items[i].spec);
    }
    array_free(&results->runs);
    array_free(&results->skips);
    array_free(&results->extremes);
    array_free(&results->extremes_failures);
    array_free(&results->shading);
}

static fathom_status replay(fathom_context *context, const validate_settings *settings) {
    const fathom_status status = validate_replay(context, settings);
    return status == FATHOM_CHECK_FAILED ? status : say_status(&command_validate, context, status);
}

static fathom_status validate(fathom_context *context, const validate_settings *settings) {
    progress_begin(settings->common.quiet, "validate");
    interrupt_keep_work(true);
    validate_results results = {.start = clock_seconds()};
    uint64_t wrong = 0;
    fathom_status status = validate_run_all(context, settings, &results);
    if (status == FATHOM_OK && settings->extremes)
        status = validate_extremes_run(context, settings, &results);
    if (status == FATHOM_OK && settings->extremes) status = validate_shading_run(context, settings, &results);
    say_status(&command_validate, context, status);
    if (status == FATHOM_OK || status == FATHOM_INTERRUPTED) {
        fathom_status written = write_results(context, settings, &results, &wrong);
        if (written != FATHOM_OK) status = say_status(&command_validate, context, written);
    }
    const bool found = wrong || count_findings(&results.runs);
    free_results(&results);
    return status == FATHOM_OK && found ? FATHOM_CHECK_FAILED : status;
}

static const args_list default_tracers = {{"embree", "reference"}, 2};

/* At least four, even on one processor: races appear only if threads interrupt each other. */
static unsigned judging_threads(void) { return processor_count() > 4 ? processor_count() : 4; }

static const validate_settings usual = {
    .rays = 1500, .sample = 2, .power = -1, .light_error = 1e-3, .families = (1u << RAYS_FAMILIES) - 1};

/* The options that only one of the three kinds of runs takes. */
static const char *find_unused(const validate_settings *s) {
    const bool rays = !s->light && !s->replay, light = s->light && !s->replay;
    const struct {
        bool given, taken;
        const char *name;
    } options[] = {{s->light, !s->replay, "light"},
                   {s->light_error != usual.light_error, light, "light-error"},
                   {s->light_only, light && !s->scene, "light-only"},
                   {s->tracers.count, !s->light, "tracer"},
                   {s->rays != usual.rays, rays, "rays"},
                   {s->families != usual.families, rays, "families"},
                   {s->power >= 0, rays, "power"},
                   {s->sample != usual.sample, rays, "sample"},
                   {s->seed, !s->replay, "seed"},
                   {s->heavy, rays, "heavy"},
                   {s->extremes, rays, "extremes"},
                   {s->report, rays, "report"},
                   {s->failures, rays, "failures"},
                   {s->json, !s->replay, "json"}};
    for (size_t i = 0; i < sizeof options / sizeof *options; ++i)
        if (options[i].given && !options[i].taken) return options[i].name;
    return NULL;
}

static fathom_status check_kind(fathom_context *context, const validate_settings *s) {
    const char *unused = find_unused(s);
    if (!unused) return FATHOM_OK;
    const char *kind = s->replay               ? "with --replay"
                       : s->light && !s->scene ? "with --light"
                       : s->light              ? "with --light of a SCENE"
                                               : "without --light";
    return fail(context, FATHOM_BAD_USAGE, "--%s: has no effect %s", unused, kind);
}

static fathom_status prepare_and_validate(fathom_context *context, void *user) {
    validate_settings *settings = user;
    fathom_status status = check_kind(context, settings);
    if (status == FATHOM_OK) status = check(context, settings);
    if (status != FATHOM_OK) return say_status(&command_validate, context, status);
    if (settings->light) return validate_light(context, settings);
    settings->tracers_given = settings->tracers.count > 0;
    if (!settings->tracers_given && !settings->replay) settings->tracers = default_tracers;
    settings->threads = settings->common.threads ? settings->common.threads : judging_threads();
    if (settings->heavy) settings->rays *= 10, settings->power /= 10;
    return (settings->replay ? replay : validate)(context, settings);
}

/* Words separated by commas. */
static bool take_families(const args_option *option, const char *value, void *field, args_problem *problem) {
    (void)option;
    char words[256] = "";
    for (rays_family f = 0; f < RAYS_FAMILIES; ++f) {
        const size_t length = strlen(words);
        snprintf(words + length, sizeof words - length, "%s%s", f ? "|" : "", rays_family_name(f));
    }
    const fathom_parameter p = {.type = FATHOM_PARAMETER_WORDS,
                                .flags = FATHOM_PARAMETER_OPEN_LOW,
                                .words = words,
                                .high = usual.families};
    return take_parameter(&p, value, field, problem);
}

static const args_option options[] = {
    {.help = "Options"},
    {"tracer", 0, "SPEC", take_list, offsetof(validate_settings, tracers), 0, 0,
     "tracer to check; may be given several times (embree and reference)"},
    {"rays", 0, "N", take_u64, offsetof(validate_settings, rays), 1, 1e15,
     "rays of each family, scene and tracer (1500), such as 20k, 8M or 1G"},
    {"seed", 0, "N", take_u64, offsetof(validate_settings, seed), 0, HUGE_VAL, "seed of the rays (0)"},
    {"families", 0, "LIST", take_families, offsetof(validate_settings, families), 0, 0,
     "camera, uniform, edge, vertex, grazing, tangent, surface, far, axis, scaled, interval, tiny, bundle, "
     "lattice, ends and rendered, separated by commas (all)"},
    {"power", 0, "RATE", take_f64, offsetof(validate_settings, power), 0, 1,
     "trace 3/RATE further rays with each tracer, over all scenes, and check those on which a second tracer "
     "disagrees: finds errors of this rate with 95 % probability (3e-6, and at most 100 rays for each of "
     "--rays); 0: none. Not for tracers that test every primitive"},
    {"heavy", 0, NULL, take_true, offsetof(validate_settings, heavy), 0, 0,
     "ten times as many rays for --rays and --power"},
    {"sample", 0, "N", take_u64, offsetof(validate_settings, sample), 0, 1e15,
     "rays of each family and scene for which the exact hit is also searched without a BVH, over all "
     "primitives (2)"},
    {"extremes", 0, NULL, take_true, offsetof(validate_settings, extremes), 0, 0,
     "also run the grid of extreme cases, each with a twelfth of --rays, and compare shading with closed "
     "forms. Without --tracer: linear:f32, linear:f64, bvh, embree and embree:user"},
    {"light", 0, NULL, take_true, offsetof(validate_settings, light), 0, 0,
     "check light instead of rays: path tracing against closed forms, or with SCENE against the "
     "reference integrator"},
    {"light-error", 0, "E", take_f64, offsetof(validate_settings, light_error), 1e-5, 1,
     "relative standard error of --light (0.001); half of it takes four times as long"},
    {"light-only", 0, "TEXT", take_text, offsetof(validate_settings, light_only), 0, 0,
     "only laws of --light whose names contain TEXT"},
    {"threads", 0, "N", take_u32, offsetof(command_common, threads), 1, 1024,
     "number of threads, 1 to 1024 (one per processor; four at least if rays are checked, so that threads "
     "interrupt each other)"},
    COMMAND_ALLOW_OUTSIDE,
    {.help = "Results"},
    {"verbose", 'v', NULL, take_true, offsetof(validate_settings, verbose), 0, 0,
     "print a row for each family"},
    COMMAND_QUIET("only the exit code"),
    {"json", 0, "FILE", take_text, offsetof(validate_settings, json), 0, 0, "all figures"},
    {"report", 0, "DIR", take_text, offsetof(validate_settings, report), 0, 0,
     "write all figures as a page with tables and plots, DIR/index.html"},
    {"failures", 0, "FILE", take_text, offsetof(validate_settings, failures), 0, 0,
     "write every ray with a leak or a wrong answer, one per line"},
    {"replay", 0, "FILE", take_text, offsetof(validate_settings, replay), 0, 0,
     "trace the rays of a file of --failures again, grouped as before, and print the answers that "
     "have changed"},
    {.help = NULL},
};

const command command_validate = {
    .name = "validate",
    .usage = "[SCENE] [--tracer SPEC ...] [options]",
    .summary = "Check tracers against exact arithmetic.",
    .text = "Traces families of difficult rays, computes the exact hit of each, and sorts the\n"
            "answers of each tracer into these classes:\n"
            "  agree        the exact hit or miss; t is right to the last places\n"
            "  tie          another primitive at the same t\n"
            "  edge         the ray passes too close to an edge for the tracer's precision\n"
            "  range        the hit is too close to an end of the ray's interval for it\n"
            "  conditioned  t is off by no more than a bound: 32 roundoffs (spheres 64,\n"
            "               planes 16) times the sizes and the slant of the intersection, a\n"
            "               few times its condition number. Slivers and grazing rays may be\n"
            "               off by millions of roundoffs; -v shows the largest bound\n"
            "  beyond       numbers exceed the range of the tracer's floats\n"
            "  leak         a known fault: Embree misses surfaces at edges and vertices\n"
            "  wrong        anything else; also u, v and normals that are NaN or off by more\n"
            "               than their bounds\n"
            "\n"
            "Each ray is traced for the closest hit and for any hit. Rows of any hit appear\n"
            "with --verbose, or if they have leaks or wrong hits. Each ray is traced again in\n"
            "calls of 16, 11, 8, 5, 4 and 1 rays, as coherent and incoherent rays, from\n"
            "several threads, while the same tracer builds other scenes. If an answer\n"
            "differs, it is checked, too. So are the rays of a small render, before and after\n"
            "it repairs leaks.\n"
            "\n"
            "Statistics must stay within limits:\n"
            "  errors in units of their condition: median 1, 99.9th percentile 64\n"
            "  mean of signed errors: 2 roundoffs\n"
            "  leaks: known rates\n"
            "  rays of a render that hit the surface they start on: 0.1 %\n"
            "  the unit roundoff that a library declares: 64 times the measured one\n"
            "Means and rates are tested at 6 standard errors (level 1e-9). The error\n"
            "statistics exclude slivers and surfaces seen from very far. `constant` is their\n"
            "largest error, in units of the condition number times the unit roundoff. Other\n"
            "errors of t are of all hits, in units of its last place as a float.\n"
            "\n"
            "SCENE is a file or a built-in scene: spheres, quads, triangles, planes,\n"
            "instances, boxes, squares, masks, masked-shapes or fine. The default is all\n"
            "built-in scenes that the tracer supports. SPEC is embree, reference, linear or\n"
            "bvh with options, such as linear:f64 or embree:robust:high:16, or a library such\n"
            "as ./mine.so.\n"
            "\n"
            "--extremes adds extreme cases, by group and number: scales and positions,\n"
            "slivers, grazing and tangent rays, copies, nested transforms, invalid shapes and\n"
            "rays. One line has the total of all tracers; -v prints a line for each tracer,\n"
            "and the case. Each tracer also renders small scenes, which are compared with\n"
            "closed forms: facing mirrors, light guides, indices of refraction, highlights,\n"
            "lights and spots at their limits, and a scene moved by the Earth's radius.\n"
            "\n"
            "--light renders rooms, lights and materials with a known radiance, and tests\n"
            "each image by Student's t-test with Sidak's correction: a correct renderer fails\n"
            "one run in 500. The table has the channel that is off most, its relative\n"
            "standard error, and by how many of these it is off. With SCENE, --light compares\n"
            "path tracing with the reference integrator.\n"
            "\n"
            "The exit code is 1 if anything is wrong or a statistic exceeds its limit. Lines\n"
            "that begin with \"found:\" name each case.\n",
    .examples = "  fathom validate\n"
                "  fathom validate --report results\n"
                "  fathom validate --tracer ./mine.so\n"
                "  fathom validate triangles --tracer ./mine.so --power 1e-7\n"
                "  fathom validate bunny.obj --rays 100k --families edge,vertex -v\n"
                "  fathom validate --tracer linear:f64 --failures bad.txt\n"
                "  fathom validate --replay bad.txt\n"
                "  fathom validate --extremes --json all.json\n"
                "  fathom validate --light\n",
    .args = {options, {{"SCENE", offsetof(validate_settings, scene)}}, 1},
    .body = prepare_and_validate,
    .defaults = &usual,
    .size = sizeof usual,
};
